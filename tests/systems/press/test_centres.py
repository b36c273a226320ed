"""Belts between fixed centres keep their unstretched length: against finite elements, and traced arc by arc."""

import math
from dataclasses import replace

import numpy as np
import pytest
from paper import law_of
from thinned import thinned

import ropefric as rf
from ropefric.errors import DataError, InputError, SolverError
from ropefric.scenes.scene_templates import scene_text
from ropefric.systems.press.creep import rim_speed_ratios
from ropefric.systems.press.critical import critical
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.statics import solve_statics, steady_state
from ropefric.systems.press.transient.motion import settled_press

MU, TURN = 0.5, math.pi
SPANS = [1.5, 2.0, 1.0, 1.0, 0.6, 0.6, 0.5, 0.5, 1.0], [0.8, 1.5, 2.0, 1.0, 1.2, 0.6, 0.6, 0.5, 0.5]


def machine(*loads_N, span_m=TURN / 10.0, stiffness_N=8000.0, pretension_N=400.0, wrap_rad=TURN, **belt):
    """A driver and as many driven rollers as there are loads on one belt; two have the numbers of the finding."""
    rollers = [Roller(name="drive", radius_m=0.1, wrap_angle_rad=wrap_rad, role="driver")]
    rollers += [Roller(name=str(i), radius_m=0.1, wrap_angle_rad=wrap_rad, gravity_torque_N_m=0.1 * load_N)
                for i, load_N in enumerate(loads_N)]  # fmt: skip
    loop = tuple(one.name for one in rollers)
    belt = {"linear_density_kg_m": 0.0, "thickness_m": 0.005, "width_m": 0.1} | belt
    ring = Belt(name="belt", loop=loop, axial_stiffness_N=stiffness_N, pretension_N=pretension_N,
                span_lengths_m=(span_m,) * len(loop), **belt)  # fmt: skip
    return Press(rollers=tuple(rollers), belts=(ring,), speed_m_s=1.2)


def tensions_N(press, mu=MU, **at):
    return steady_state(solve_statics(press), friction=mu, **at).tension_N


@pytest.fixture
def fixed_press(paper_press):
    """The paper's press with both belts between fixed centres in place of their tensioners."""
    rollers = tuple(
        replace(one, role="driven", tensioner=None) if one.tensioner else one for one in paper_press.rollers
    )
    belts = tuple(
        replace(belt, axial_stiffness_N=stiffness_N, pretension_N=pretension_N, span_lengths_m=tuple(spans))
        for belt, spans, stiffness_N, pretension_N in zip(
            paper_press.belts, SPANS, (2e6, 8e5), (1800.0, 1500.0), strict=True
        )
    )
    return replace(paper_press, rollers=rollers, belts=belts)


def test_a_belt_of_finite_elements_has_the_same_tensions():
    """The elements have 187.38 and 665.87 N; 186.4 and 663.2 N keep the length, as those of the belt drive do."""
    found = tensions_N(machine(476.8))
    assert found == pytest.approx([186.4, 663.2], abs=0.05)
    assert found == pytest.approx([187.38, 665.87], rel=6e-3)


def unstretched_m(press, tension_N, mu, belt):
    """Return the unstretched length of a belt, from the passage of mass: v_b (1 + strain) is the speed of its span."""
    spans, stiffness_N = (
        {(one.start, one.end): i for i, one in enumerate(press.spans)},
        belt.axial_stiffness_N,
    )
    rims = dict(zip((one.name for one in press.rollers), rim_speed_ratios(press, tension_N), strict=True))
    way, rollers = [spans[step] for step in belt.steps], {one.name: one for one in press.rollers}
    alone = next(i for i, place in enumerate(way) if len(press.spans[place].belts) == 1)
    pace = rims[belt.steps[alone][1]] / (1.0 + tension_N[way[alone]] / stiffness_N)
    strain = np.array([rims[end] for _, end in belt.steps]) / pace - 1.0
    total_m = np.sum(belt.span_lengths_m / (1.0 + strain))
    for i, (_, end) in enumerate(belt.steps):
        before_N, after_N = press.into @ tension_N, press.out_of @ tension_N
        place = [one.name for one in press.rollers].index(end)
        grows, wrap = math.log(after_N[place] / before_N[place]), rollers[end].wrap_angle_rad
        slips = abs(grows) / mu
        angle = np.linspace(0.0, slips, 20001)
        total_N = before_N[place] * np.exp(math.copysign(mu, grows) * angle)
        gone = (total_N - before_N[place]) / ((after_N - before_N)[place] or 1.0)
        along = strain[i] + (strain[(i + 1) % len(way)] - strain[i]) * gone
        total_m += rollers[end].radius_m * (
            np.trapezoid(1.0 / (1.0 + along), angle) + (wrap - slips) / (1.0 + strain[i])
        )
    return total_m


@pytest.mark.parametrize("closure", ["share", "equal", "equal-torque"])
def test_both_belts_of_a_press_keep_their_lengths(fixed_press, closure):
    state = steady_state(solve_statics(fixed_press, closure=closure), friction=1.2, speed_m_s=0.0)
    for belt in fixed_press.belts:
        arcs_m = sum(
            one.radius_m * one.wrap_angle_rad for one in fixed_press.rollers if one.name in belt.loop
        )
        laid_m = sum(belt.span_lengths_m) + arcs_m
        strained = 1.0 + belt.pretension_N / belt.axial_stiffness_N
        length_m = unstretched_m(fixed_press, state.tension_N, 1.2, belt)
        # An error of the length of 1e-9 is one of the tension of some mN.
        assert length_m == pytest.approx(laid_m / strained, rel=2e-9)


def test_without_loads_it_has_its_pretension_at_any_speed(fixed_press):
    idle = replace(fixed_press, rollers=tuple(
        replace(one, gravity_torque_N_m=0.0, squeeze_torque_N_m=0.0) for one in fixed_press.rollers))  # fmt: skip
    for speed in (0.0, 5.0):
        found = tensions_N(idle, 1.2, speed_m_s=speed)
        wanted = [
            sum(belt.pretension_N for belt in idle.belts if belt.name in span.belts) for span in idle.spans
        ]
        assert found == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(("mu", "slack_N"), [(5.0, 6.554e-4), (20.0, 1.918e-6)])
def test_a_slack_side_next_to_nothing(mu, slack_N):
    """With much grip the belt slips nearly all round before its slack side pushes."""
    pull_N = 1500.0 if mu == 5.0 else 1000.0
    press = machine(pull_N)
    found = tensions_N(press, mu)
    assert found == pytest.approx([slack_N, pull_N + slack_N], rel=1e-3)
    strained = 1.0 + 400.0 / 8000.0
    assert unstretched_m(press, found, mu, press.belts[0]) == pytest.approx(0.4 * TURN / strained, rel=1e-7)


def at_critical(statics, change, value):
    """Return the utilisation of all rollers with one setting changed."""
    press = statics.press
    if change == "preload":
        belts = [
            replace(one, pretension_N=one.pretension_N + value - press.preload_N.mean())
            for one in press.belts
        ]
        statics = solve_statics(replace(press, belts=tuple(belts)))
    at = {"speed": {"speed_m_s": value}, "load": {"load_factor": value}}.get(change, {})
    state = steady_state(statics, friction=0.9, on_slack="flag", **at)
    return SlipTable(press, state.effective_tension_N, 0.9).utilisation


@pytest.mark.parametrize("change", ["preload", "speed", "load"])
def test_the_utilisation_is_one_where_a_roller_begins_to_slip(fixed_press, change):
    statics = solve_statics(fixed_press)
    found = critical(statics, 0.9, change)
    use = at_critical(statics, change, found.value)
    assert use.max() == pytest.approx(1.0, abs=1e-8)
    assert fixed_press.rollers[int(np.argmax(use))].name == found.roller


def test_the_critical_friction_is_where_it_slips_with_the_tensions_that_it_then_has(fixed_press):
    statics = solve_statics(fixed_press)
    found = critical(statics, 0.9, "friction")
    state = steady_state(statics, friction=found.value)
    slip = SlipTable(fixed_press, state.effective_tension_N, found.value)
    assert slip.of(found.roller) == pytest.approx(1.0, abs=1e-9)
    assert slip.utilisation.max() == slip.of(found.roller)


def test_a_belt_that_has_lifted_off_is_held_where_more_grip_keeps_it_on():
    statics = solve_statics(machine(1500.0))
    found = critical(statics, 1.0, "friction")
    assert (found.state, found.direction) == ("slips", "rises")
    state = steady_state(statics, friction=found.value, on_slack="flag")
    slip = SlipTable(statics.press, state.effective_tension_N, found.value)
    assert slip.utilisation.max() == pytest.approx(1.0, rel=1e-6)


def test_a_start_up_begins_with_the_pretension_and_settles(fixed_press):
    settled = settled_press(fixed_press, 0.5)
    assert settled.travel_m.size == 0
    # Belts that stick change their spans, and each loop keeps the sum of its spans' stretch.
    own_N_m = np.array([sum(belt.axial_stiffness_N for belt in fixed_press.belts if belt.name in span.belts)
                        for span in fixed_press.spans]) / [*SPANS[0], *SPANS[1][:5]]  # fmt: skip
    rest_N = [
        sum(one.pretension_N for one in fixed_press.belts if one.name in span.belts)
        for span in fixed_press.spans
    ]
    stretch_m = (settled.tension_N - rest_N) / own_N_m
    for belt in fixed_press.carried:
        assert stretch_m @ belt == pytest.approx(0.0, abs=1e-12)


def test_refusals(fixed_press):
    with pytest.raises(InputError, match="depends on the friction, but none is given"):
        steady_state(solve_statics(machine(100.0)))
    with pytest.raises(DataError, match=r"a length that needs belts\.belt\.axial_stiffness_N"):
        machine(100.0, stiffness_N=None)
    press = machine(100.0)
    loose = replace(press.rollers[1], role="tensioner",
                    tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1.0))  # fmt: skip
    with pytest.raises(DataError, match="has a pretension, but tensioner '0' sets its tension"):
        replace(press, rollers=(press.rollers[0], loose))
    with pytest.raises(SolverError, match="goes slack"):
        tensions_N(machine(1500.0), 1.0)
    one_level = replace(
        fixed_press, belts=(fixed_press.belts[0], replace(fixed_press.belts[1], pretension_N=None))
    )
    with pytest.raises(InputError, match="does not settle"):
        solve_statics(one_level)


def test_a_scene_of_fixed_centres(tmp_path):
    text, path = scene_text("press-fixed"), tmp_path / "fixed.toml"
    path.write_text(text, encoding="utf-8")
    found = rf.solve(path).to_dict()
    belt = found["fixed_centres"]["upper"]
    assert belt["pretension_N"] == 1800.0
    assert belt["belt_length_m"] == pytest.approx(8.7 + belt["arcs_m"])
    assert found["critical"]["preload"]["value"] < 1650.0
    # A pretension is a stretch: EA counts whatever effects are named, and the answer is as near as it says.
    path.write_text(
        text.replace('effects  = "auto"', 'effects  = ["gravity-load", "squeeze-load", "belt-inertia"]'),
        encoding="utf-8",
    )
    named = rf.solve(path).to_dict()
    assert named["effective_tension_N"] == pytest.approx(
        found["effective_tension_N"], rel=named["error_bound"]
    )
    assert named["error_bound"] < 1e-3
    path.write_text(text.replace('"1800 N"', '"0 N"'), encoding="utf-8")
    with pytest.raises(DataError, match="not more than 0"):
        rf.load_scene(path)


def test_a_force_of_its_own_comes_before_the_preload_of_all(tmp_path):
    text = scene_text("belt-press")
    own = text.replace("[rollers.3.tensioner]\n", '[rollers.3.tensioner]\nforce = "4000 N"\n')
    path = tmp_path / "scene.toml"
    found = []
    for one in (text, own, own.replace('preload  = "2000 N"', 'preload  = "2500 N"')):
        path.write_text(one, encoding="utf-8")
        found.append(rf.solve(path).to_dict()["tension_N"])
    cosine = 1.0 + math.cos(math.radians(19.9))
    assert found[1]["2"] - found[0]["2"] == pytest.approx(2000.0 / cosine)
    assert found[1]["13"] == pytest.approx(found[0]["13"])
    assert found[2]["2"] == pytest.approx(found[1]["2"])
    assert found[2]["13"] > found[0]["13"]


@pytest.mark.parametrize("seed", thinned([3, 0, 1, 2, 6, 4, 5, 7], 4))
def test_any_machine_of_one_fixed_belt_says_where_it_slips(seed):
    """Stiff or soft belts, short or long spans, little or much grip; the reserve is spent where it says so."""
    rng = np.random.default_rng([11, seed])
    press = machine(*10.0 ** rng.uniform(0.5, 2.5, rng.integers(1, 4)), stiffness_N=10.0 ** rng.uniform(4.0, 8.0),
                    span_m=10.0 ** rng.uniform(-1.5, 1.5), pretension_N=10.0 ** rng.uniform(2.5, 3.5),
                    wrap_rad=rng.uniform(0.3, 6.0), linear_density_kg_m=rng.uniform(0.0, 10.0))  # fmt: skip
    law = law_of("wrap-power", [rng.uniform(0.2, 1.5), -0.3, 0.1], (0.1, 0.0025, 2.0, 500.0))
    statics = solve_statics(press)
    for friction in (10.0 ** rng.uniform(-1.0, 0.7), law):
        found = critical(statics, friction, "load")
        assert found.value is not None, "with much grip it slips just before a span is slack"
        state = steady_state(statics, load_factor=found.value, friction=friction, on_slack="flag")
        slip = SlipTable(press, state.effective_tension_N, friction)
        # What is known of a slack side next to nothing.
        known = 1e-12 * state.effective_tension_N.max() / state.effective_tension_N.min()
        assert slip.utilisation.max() == pytest.approx(1.0, abs=1e-6 + known)
