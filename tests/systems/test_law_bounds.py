"""What bounds of error rest on: laws that weaken, and what leaving out changes at most over whole boxes."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.errors import RopefricError
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.kinds import KINDS
from ropefric.systems.beltdrive.drive import DriveProblem
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem

WEAKENING = sorted(name for name, law in ALL_LAWS.items() if law.weakens)
USUAL = {"A": 5.0, "mu": 0.6, "mu_inf": 0.8, "d": 0.4, "a": 3.0, "b": 3.0}


def parameters(law, rng):
    """Parameters anywhere within the bounds, most of them as they are usual, some at an end."""
    ends = [
        (max(one.lower, -USUAL.get(one.name, 9.0)), min(one.upper, USUAL.get(one.name, 9.0)))
        for one in law.parameters
    ]
    theta = np.array([rng.uniform(low, high) for low, high in ends])
    return np.where(rng.random(theta.size) < 0.1, [end[rng.integers(2)] for end in ends], theta)


@pytest.mark.parametrize("name", WEAKENING)
def test_a_law_that_weakens_keeps_to_what_that_means(name):
    law, rng, n = ALL_LAWS[name], np.random.default_rng(1), 60
    wrap = np.geomspace(1e-3, 40.0, n)
    checked = 0
    for _ in range(150):
        theta = parameters(law, rng)
        own = {
            "wheel_radius_m": 10.0 ** rng.uniform(-2.0, 0.0),
            "rope_radius_m": 10.0 ** rng.uniform(-3.5, -2.0),
            "wrap_angle_rad": rng.uniform(0.1, 30.0),
            "end_tension_N": 10.0 ** rng.uniform(0.0, 4.0),
        }

        def rise(**other):
            at = {key: np.broadcast_to(value, n) for key, value in {**own, **other}.items()}  # noqa: B023
            conditions = Conditions(**at)
            return law.log_lift(theta, conditions) - conditions.log_end_tension  # noqa: B023

        try:
            by_wrap = rise(wrap_angle_rad=wrap)
        except RopefricError:
            continue
        checked += 1
        tiny = 1e-9 * (1.0 + np.abs(by_wrap).max())
        average, slopes = by_wrap / wrap, np.diff(by_wrap) / np.diff(wrap)
        assert by_wrap[0] >= -tiny
        assert (np.diff(slopes) <= 1e-9 * (1.0 + slopes.max()) + tiny / np.diff(wrap)[:-1]).all(), "concave"
        assert (np.diff(average) <= 1e-9 * average[:-1] + 1e-12).all()
        tension = np.geomspace(1.0, 1e5, n)
        by_tension = rise(end_tension_N=tension)
        assert (np.diff(by_tension) <= tiny).all(), "falls with the tension …"
        assert (np.diff(by_tension) >= -np.diff(np.log(tension)) - tiny).all(), (
            "… and no faster than it rises"
        )
        for key in ("wheel_radius_m", "rope_radius_m"):
            steps = np.diff(rise(**{key: own[key] * np.geomspace(0.1, 10.0, n)}))
            assert (steps <= tiny).all() or (steps >= -tiny).all(), key
            assert "size" in law.effects or not steps.any(), key
    assert checked > 40


def test_a_law_of_ones_own_promises_nothing():
    law = replace(ALL_LAWS["wrap-power"], weakens=False)
    friction = WrapFriction(
        law=law, theta=np.array([0.1, -0.5, 0.1]), reference=one_condition(0.04, 0.005, 3.0, 60.0)
    )
    told = dict.fromkeys(("wheel_radius_m", "rope_radius_m"), (0.05, 0.05))
    told |= {"wrap_angle_rad": (3.0, 3.0), "slack_tension_N": (60.0, 60.0)}
    assert np.isinf(friction.spread(**told)).all()
    assert (replace(friction, law=ALL_LAWS["wrap-power"]).spread(**told) < 1e-12).all()
    outside = replace(friction, law=ALL_LAWS["wrap-power"], theta=np.array([-0.1, -0.5, 0.3]))
    assert np.isinf(outside.spread(**told)).all(), "a parameter beyond its bounds"


def ranges(rng, low, high, n):
    """Values spread over a range of their own within some limits, often a narrow one."""
    start = np.exp(rng.uniform(np.log(low), np.log(high)))
    return start * np.exp(rng.uniform(0.0, 10.0 ** rng.uniform(-4.0, 0.3)) * rng.random(n))


def friction_of(rng):
    law = ALL_LAWS[str(rng.choice(WEAKENING))]
    theta = parameters(law, rng)
    if rng.random() < 0.5 and "a" in law.parameter_names:
        theta[law.parameter_names.index("a")] *= 1e-3  # hardly any dependence
    reference = one_condition(
        ranges(rng, 0.02, 0.3, 1)[0],
        ranges(rng, 1e-3, 0.01, 1)[0],
        ranges(rng, 0.5, 15.0, 1)[0],
        ranges(rng, 2.0, 2e3, 1)[0],
    )
    return WrapFriction(law=law, theta=theta, reference=reference)


@pytest.mark.parametrize("name", WEAKENING)
def test_of_parameters_that_differ_each_case_has_the_spread_it_has_alone(name):
    rng = np.random.default_rng(7)
    law, reference = ALL_LAWS[name], one_condition(0.04, 0.005, 3.0, 60.0)
    theta = np.array([parameters(law, rng) for _ in range(40)])
    theta[3] += 100.0  # beyond its bounds
    low, high = rng.uniform(1.0, 60.0, 40), rng.uniform(60.0, 900.0, 40)
    radii = {"wheel_radius_m": (0.03, 0.09), "rope_radius_m": (0.005, 0.005), "wrap_angle_rad": (0.5, 3.5)}
    whole = WrapFriction(law=law, theta=theta, reference=reference)
    many = whole.spread(**radii, slack_tension_N=(low, high))
    alone = [
        replace(whole, theta=one).spread(**radii, slack_tension_N=(low[i], high[i]))[0]
        for i, one in enumerate(theta)
    ]
    assert np.broadcast_to(many, 40) == pytest.approx(np.array(alone), rel=1e-7, abs=1e-12)
    assert np.isinf(many).any() or not law.effects - {"groove"}


def hoist(rng, n):
    wheel_m, end_N = ranges(rng, 0.02, 0.3, n), ranges(rng, 2.0, 2e3, n)
    share = ranges(rng, 1e-8, 0.3, n)
    return "hoist", HoistProblem(
        friction=friction_of(rng),
        wheel_radius_m=wheel_m,
        rope_radius_m=ranges(rng, 1e-3, 0.01, n),
        wrap_angle_rad=ranges(rng, 0.3, 15.0, n),
        end_tension_N=end_N,
        linear_density_kg_m=0.06,
        speed_m_s=rng.uniform(0.0, 0.7) * np.sqrt(end_N.min() / 0.06),
        hanging_length_m=5.0,
        bending_stiffness_N_m2=2.0 * wheel_m**2 * share * 0.5 * end_N.min(),
    )


def drive(rng, n):
    tension_N = ranges(rng, 50.0, 5e3, n)
    return "beltdrive", DriveProblem(
        friction=friction_of(rng),
        closure=str(rng.choice(["limit", "tensioner", "fixed"])),
        wheel_radius_m=ranges(rng, 0.02, 0.3, n),
        wrap_angle_rad=ranges(rng, 0.5, 6.0, n),
        tension_N=tension_N,
        rope_radius_m=ranges(rng, 1e-3, 0.01, n),
        belt_count=2.0,
        driven_radius_m=0.1,
        driven_wrap_rad=rng.uniform(1.0, 5.0),
        axial_stiffness_N=rng.uniform(10.0, 1e4) * tension_N.max(),
        groove_angle_rad=1.0,
    )


def scattered(rng, friction, n):
    """The friction with parameters that differ from case to case, by little or much, some moved onto a bound."""
    law, theta = friction.law, friction.theta
    theta = theta * np.exp(10.0 ** rng.uniform(-3.0, -0.3) * rng.standard_normal((n, theta.size)))
    return replace(friction, theta=np.clip(theta, law.lower, law.upper))


def drawn_drive(rng, n):
    name, problem = drive(rng, n)
    return name, replace(problem, friction=scattered(rng, problem.friction, n))


def check_boxes(draw, count, seed, n=400):
    """In how many boxes there was a bound below a tenth; no case lies outside any, whatever is left out at once."""
    told = 0
    for one in range(count):
        rng = np.random.default_rng([seed, one])
        name, problem = draw(rng, n)
        system = KINDS[name].system
        applicable = frozenset(effect.name for effect in system.effects.values() if not effect.needs(problem))
        able = sorted(effect for effect in applicable if system.effects[effect].each is not None)
        gone = [effect for effect in able if rng.random() < 0.6]
        try:
            whole, less = (
                system.solve(assemble(system, problem, applicable - set(without)), None)
                for without in ((), gone)
            )
        except RopefricError:
            continue
        # A coefficient that is 0 with and without has no logarithm, and has not changed.
        same = (whole.logs == less.logs) | (np.isnan(whole.logs) & np.isnan(less.logs))
        worth = np.abs(np.where(same, 0.0, whole.logs) - np.where(same, 0.0, less.logs)).max(axis=0)
        bound = sum((system.effects[effect].each(problem, less) for effect in gone), np.zeros(n))
        before = sum((system.effects[effect].each(problem, None) for effect in gone), np.zeros(n))
        assert (worth <= bound * (1.0 + 1e-9) + 1e-11).all(), (name, one, gone)
        assert (before <= bound * (1.0 + 1e-12) + 1e-12).all(), (name, one, gone)
        told += bool(gone and np.median(bound) < 0.1)
    return told


@pytest.mark.parametrize("draw", [hoist, drive, drawn_drive])
def test_no_case_of_a_random_box_lies_outside_its_bound(draw):
    assert check_boxes(draw, 60, 1) > 5


@pytest.mark.slow
@pytest.mark.parametrize("draw", [hoist, drive, drawn_drive])
def test_no_case_of_thousands_of_random_boxes_lies_outside_its_bound(draw):
    assert check_boxes(draw, 3000, 2) > 300
