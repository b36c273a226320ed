"""Each effect of a press changes the answer by what its own formula says."""

import math
from dataclasses import replace

import numpy as np
import pytest
from paper import law_of
from scipy.integrate import quad
from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.plan import make_plan
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS

STEADY = ("gravity-load", "squeeze-load", "belt-inertia", "tensioner-spring", "belt-elasticity",
          "elastic-creep", "wrap-dependence", "size")  # fmt: skip
MOVING = ("belt-damping", "tensioner-damping", "arc-inertia", "transient")

# One belt over a driver, a loaded roller and a tensioner: small enough to be done by hand.
R_LOAD, R_TENS, WRAPS, THICK = 0.2, 0.1, (3.0, 2.5, 2.8), 0.005
GRAVITY, SQUEEZE, DRAG = 12.0, 30.0, 4.0
SPRING, TRAVEL, FORCE, ANGLES = 2e4, 0.03, 2500.0, (0.3, 0.7)
RHO, SPEED, STIFF, LENGTHS = 12.0, 5.0, 8e5, (1.0, 1.5, 0.8)


def small_press(friction, **operation):
    rollers = (Roller(name="drive", radius_m=0.15, wrap_angle_rad=WRAPS[0], role="driver"),
               Roller(name="load", radius_m=R_LOAD, wrap_angle_rad=WRAPS[1], gravity_torque_N_m=GRAVITY,
                      squeeze_torque_N_m=SQUEEZE),
               Roller(name="tensioner", radius_m=R_TENS, wrap_angle_rad=WRAPS[2], role="tensioner",
                      gravity_torque_N_m=DRAG,
                      tensioner=Tensioner(spring_N_m=SPRING, travel_m=TRAVEL, force_N=FORCE,
                                          upstream_angle_rad=ANGLES[0], downstream_angle_rad=ANGLES[1])))  # fmt: skip
    belt = Belt(name="belt", loop=("drive", "load", "tensioner"), linear_density_kg_m=RHO,
                thickness_m=THICK, width_m=1.0, axial_stiffness_N=STIFF, span_lengths_m=LENGTHS)  # fmt: skip
    press = Press(rollers=rollers, belts=(belt,), speed_m_s=SPEED)
    given_ones = {"speed_m_s": SPEED, "load_factor": 1.0} | operation
    return PressProblem(press=press, closure="share", friction=friction, **given_ones)


def by_hand(gravity=0.0, squeeze=0.0):
    """Tensions at rest: the tensioner's balance, then the rollers' one after the other."""
    drag = gravity * DRAG / R_TENS
    cos_in, cos_out = (math.cos(angle) for angle in ANGLES)
    arriving = (SPRING * TRAVEL + FORCE - drag * cos_out) / (cos_in + cos_out)
    load = (gravity * GRAVITY + squeeze * SQUEEZE) / R_LOAD
    return np.array([arriving - load, arriving, arriving + drag])


def solved(problem, effects):
    model = assemble(SYSTEM, problem, effects)
    return SYSTEM.solve(model, SYSTEM.method(model, 0.01))


def tensions(problem, effects):
    return solved(problem, effects).state.effective_tension_N[0]


CONSTANT = WrapFriction.constant(0.8)


def test_the_loads_are_the_balances_done_by_hand():
    for gravity in [0, 1]:
        for squeeze in [0, 1]:
            effects = ["gravity-load"] * gravity + ["squeeze-load"] * squeeze
            found = tensions(small_press(CONSTANT), effects)
            assert found == pytest.approx(by_hand(gravity, squeeze), rel=1e-13), (gravity, squeeze)


def test_the_factor_on_the_loads_and_the_common_preload_act_on_what_is_simulated():
    problem = small_press(CONSTANT, load_factor=0.5, preload_N=3000.0)
    shift = (3000.0 - FORCE) / sum(math.cos(angle) for angle in ANGLES)
    wanted = by_hand() + 0.5 * (by_hand(gravity=1) - by_hand()) + shift
    assert tensions(problem, ["gravity-load"]) == pytest.approx(wanted, rel=1e-13)


@pytest.mark.parametrize(
    ("effects", "share"),
    [
        ([], 0.0),
        (["tensioner-spring", "belt-elasticity"], 0.0),  # belts without mass need no tension to circle
        (["belt-inertia"], 1.0),
        (["belt-inertia", "belt-elasticity"], 1.0),
        (["belt-inertia", "tensioner-spring"], 0.0),
        (["belt-inertia", "tensioner-spring", "belt-elasticity"], None),
    ],
)
def test_what_speed_takes_is_shared_between_belt_and_spring(effects, share):
    """dT' = −ρAv²/(1 + s), s = (Σcos)² (EA/L)/k1: locked tensioners are s = 0, belts that do not stretch s = ∞."""
    if share is None:
        # At the rollers' surface, as the page's loop.
        arcs = 0.15 * WRAPS[0] + R_LOAD * WRAPS[1] + R_TENS * WRAPS[2]
        s = sum(math.cos(angle) for angle in ANGLES) ** 2 * STIFF / (sum(LENGTHS) + arcs) / SPRING
        share = 1.0 / (1.0 + s)
        assert 0.02 < share < 0.2
    found = tensions(small_press(CONSTANT), effects)
    assert found == pytest.approx(by_hand() - share * RHO * SPEED**2, rel=1e-12)


def test_without_effects_the_belts_are_not_loaded_and_no_roller_needs_friction():
    bare = solved(small_press(CONSTANT), [])
    assert bare.state.effective_tension_N[0] == pytest.approx(np.full(3, by_hand()[1]), rel=1e-13)
    assert bare.slip.utilisation.max() < 1e-14


LOADS = ["gravity-load", "squeeze-load"]
POWER = (0.9, -0.4, 0.1)  # μ(φ) = a φ^b + c


def of_hand(exponents):
    """U from the tensions by hand, with the exponent of each roller."""
    by_span = by_hand(1, 1)
    pairs = np.stack([np.roll(by_span, 1), by_span])
    return (pairs.max(axis=0) - pairs.min(axis=0)) / (pairs.min(axis=0) * np.expm1(exponents))


@pytest.mark.parametrize("told", [True, False])
def test_a_law_is_integrated_over_the_wrap_from_the_angle_of_the_slack_tension(told):
    a, b, c = POWER
    reference = one_condition(0.2, 0.0025, 2.0, 900.0)
    friction = WrapFriction(law=ALL_LAWS["wrap-power"], theta=np.array(POWER), reference=reference)

    def mu(phi):
        return a * phi**b + c

    def exponent(wrap, slack_N):
        start = brentq(lambda phi: a * phi ** (b + 1) / (b + 1) + c * phi - math.log(slack_N), 1e-6, 1e3)
        return quad(mu, start, start + wrap, epsabs=0.0, epsrel=1e-12)[0]

    by_span = by_hand(1, 1)
    slack_N = np.minimum(np.roll(by_span, 1), by_span)
    if told:
        exponents = [exponent(wrap, one) for wrap, one in zip(WRAPS, slack_N, strict=True)]
    else:
        exponents = np.array(WRAPS) * exponent(2.0, 900.0) / 2.0
    effects = [*LOADS, "wrap-dependence"] if told else LOADS
    found = solved(small_press(friction), effects).slip.utilisation[0]
    assert found == pytest.approx(of_hand(np.array(exponents)), rel=1e-9)


@pytest.mark.parametrize("told", [True, False])
def test_size_is_the_rollers_radius_over_half_the_belts_thickness(told):
    mu_inf, a, b = 0.9, -0.03, -0.2
    friction = law_of("size-exponential", [mu_inf, a, b], (0.12, 0.0025, 2.0, 900.0))
    radii = np.array([0.15, R_LOAD, R_TENS]) if told else np.full(3, 0.12)
    mu = mu_inf * (1.0 - np.exp(a * radii / (0.5 * THICK) + b))
    found = solved(small_press(friction), [*LOADS, "size"] if told else LOADS).slip.utilisation[0]
    assert found == pytest.approx(of_hand(mu * np.array(WRAPS)), rel=1e-12)


@pytest.fixture(scope="module")
def paper_problem(paper_press):
    """The printed machine at 50 rpm."""
    return PressProblem(press=paper_press, closure="share", friction=WrapFriction.constant(1.2),
                        speed_m_s=paper_press.speed_m_s, load_factor=1.0)  # fmt: skip


def test_each_load_alone_is_balanced_on_the_printed_machine(paper_problem, paper_data):
    """Eqs. (35), (36) for the tensioners, then roller by roller; `share` splits the press rollers' pull in halves."""
    for effect in LOADS:
        own = "gravity_torque_N_m" if effect == "gravity-load" else "squeeze_torque_N_m"
        pull = {roller.name: getattr(roller, own) / roller.radius_m for roller in paper_problem.press.rollers}
        k1, force = paper_data["tensioner_stiffness"], paper_data["tensioner_force_up"]
        cos_b, cos_g = math.cos(paper_data["beta"]), math.cos(paper_data["gamma"])
        T2 = (k1 * paper_data["tensioner_travel_up"] + force - pull["3"] * cos_b) / (1.0 + cos_b)
        T13 = (k1 * paper_data["tensioner_travel_down"] + force - pull["13"]) / (1.0 + cos_g)
        T4, T14 = T2 + pull["3"], T13 + pull["13"]
        half = 0.5 * sum(pull[name] for name in "56789")
        press_zone = T4 + T14 + np.cumsum([pull[name] for name in "5678"])
        wanted = [T2 - pull["2"], T2, T4, T4, *press_zone, T4 + half, T14 + half, T13, T13, T13, T14]
        assert tensions(paper_problem, [effect]) == pytest.approx(wanted, rel=1e-12), effect


def test_what_only_a_start_up_has_asks_for_one(paper_problem):
    for name in MOVING:
        effect = SYSTEM.effects[name]
        assert effect.needs(paper_problem) == ("start_up",), name
        with pytest.raises(InputError, match=f"{name} cannot be simulated without start_up"):
            make_plan(SYSTEM, paper_problem, accuracy=0.01, effects=(name,))


def test_a_start_up_asks_for_every_mass_and_stiffness_at_once(paper_problem):
    for name in MOVING:
        task = {"speed": DRIVE_LAWS["ramp"](speed_m_s=0.9, duration_s=1.0),
                "time_s": np.linspace(0.0, 2.0, 5), "slip": False, "loads": "constant"}  # fmt: skip
        started = replace(paper_problem, start_up=task)
        missing = SYSTEM.effects[name].needs(started)
        assert {"belts.upper.axial_stiffness", "belts.lower.span_lengths", "rollers.2.inertia",
                "rollers.3.tensioner.mass"} <= set(missing), name  # fmt: skip
        assert "rollers.1.inertia" not in missing, "a driver's speed is given"
