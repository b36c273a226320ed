"""Elastic creep of a press: limits, mass continuity, the power it takes, the belt drive's two pulleys, closures."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.scenes.plan import make_plan
from ropefric.systems.beltdrive.drive import DriveModel, DriveProblem, solve_drive
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.statics import solve_statics, steady_state

CONSTANT = WrapFriction.constant(1.2)
LOADS = ("gravity-load", "squeeze-load", "belt-inertia")
BOTH = (*LOADS, "elastic-creep")
SPEED = 3.0


def problem_of(press, closure="share", **operation):
    return PressProblem(press=press, closure=closure, friction=CONSTANT,
                        **{"speed_m_s": SPEED, "load_factor": 1.0} | operation)  # fmt: skip


def solved(problem, effects=BOTH):
    model = assemble(SYSTEM, problem, effects)
    return SYSTEM.solve(model, SYSTEM.method(model, 0.01))


def with_stiffness(press, *stiffness_N):
    belts = [replace(belt, axial_stiffness_N=one) for belt, one in zip(press.belts, stiffness_N, strict=True)]
    return replace(press, belts=tuple(belts))


def two_rollers(stiffness_N=4e5, *, pull_N=1000.0, radius_m=0.2):
    """A driver and a roller on a take-up of constant force that holds the tight side."""
    load = Roller(name="load", radius_m=radius_m, wrap_angle_rad=3.0, role="tensioner",
                  gravity_torque_N_m=pull_N * radius_m,
                  tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=5000.0))  # fmt: skip
    belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=2.0, thickness_m=0.005,
                width_m=0.1, axial_stiffness_N=stiffness_N)  # fmt: skip
    drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
    return Press(rollers=(drive, load), belts=(belt,), speed_m_s=SPEED)


def belt_tensions_N(answer):
    """Each belt's own share of T in every span it runs in, from how fast its rollers run."""
    press, spans = answer.state.press, answer.state.press.spans
    rims = dict(zip((one.name for one in press.rollers), answer.rim_speed_m_s[0], strict=True))
    tension = dict(zip((span.name for span in spans), answer.state.tension_N[0], strict=True))
    found = {}
    for belt in press.belts:
        own = [span for span in spans if belt.name in span.belts]
        alone = next(span for span in own if len(span.belts) == 1)
        pace = rims[alone.end] / (1.0 + tension[alone.name] / belt.axial_stiffness_N)
        for span in own:
            found[belt.name, span.name] = belt.axial_stiffness_N * (rims[span.end] / pace - 1.0)
    return found, tension


def test_two_rollers_are_the_belt_drive():
    press = two_rollers()
    found = solved(problem_of(press))
    tight_N, slack_N = found.state.tension_N[0][[1, 0]]
    assert tight_N - slack_N == pytest.approx(1000.0, rel=1e-12)
    belt = DriveProblem(friction=CONSTANT, closure="limit", wheel_radius_m=0.1, wrap_angle_rad=3.0,
                        tension_N=tight_N, rope_radius_m=0.0025, belt_count=1.0, speed_rad_s=SPEED / 0.1,
                        driven_radius_m=0.2, driven_wrap_rad=3.0, linear_density_kg_m=2.0,
                        axial_stiffness_N=4e5, power_W=1000.0 * SPEED)  # fmt: skip
    drive = solve_drive(DriveModel(problem=belt, effects=frozenset({"centrifugal", "creep"})))
    assert drive.slack_N[0] == pytest.approx(slack_N, rel=1e-12)
    ratio = drive.speed_ratio[0]
    assert ratio == pytest.approx((1.0 + slack_N / 4e5) / (1.0 + tight_N / 4e5), rel=1e-15)
    assert found.rim_speed_m_s[0] == pytest.approx([SPEED, SPEED * ratio], rel=1e-14)
    assert found.creep_loss_W[0] == pytest.approx(1000.0 * SPEED * (1.0 - ratio), rel=1e-9)


def test_without_loads_nothing_creeps_and_existing_numbers_do_not_know_of_creep(paper_press):
    found = solved(problem_of(two_rollers()), ("elastic-creep",))
    assert found.rim_speed_m_s[0] == pytest.approx([SPEED, SPEED], rel=1e-14)
    assert found.creep_loss_W[0] == pytest.approx(0.0, abs=1e-11)
    problem = problem_of(with_stiffness(paper_press, 5e5, 8e5))
    creeping, rigid = solved(problem), solved(problem, LOADS)
    assert (creeping.state.effective_tension_N == rigid.state.effective_tension_N).all()
    assert (creeping.slip.utilisation == rigid.slip.utilisation).all()
    assert (rigid.rim_speed_m_s == SPEED).all()
    assert rigid.creep_loss_W[0] == 0.0


def test_what_the_drivers_supply_less_what_the_loads_take_is_lost_by_creep(paper_press):
    """As much belt passes every place: shares of belts that run together, each from its own v/(1 + T/EA), add up."""
    for closure in ["share", "equal", "equal-torque"]:
        for factor in [0.4, 1.0]:
            press = with_stiffness(paper_press, 2e5, 9e5)
            answer = solved(problem_of(press, closure, load_factor=factor))
            rims = dict(zip((one.name for one in press.rollers), answer.rim_speed_m_s[0], strict=True))
            pulls_N = -answer.state.effective_tension_N[0] @ press.incidence.T
            supplied_W = sum(
                (pull_N + factor * one.torque_N_m / one.radius_m) * rims[one.name]
                for one, pull_N in zip(press.rollers, pulls_N, strict=True)
                if one.role == "driver"
            )
            taken_W = sum(factor * one.torque_N_m * rims[one.name] / one.radius_m for one in press.rollers)
            assert answer.creep_loss_W[0] == pytest.approx(supplied_W - taken_W, rel=1e-9), (closure, factor)
            # Round each loop it is v_b/(2 EA) Σ (T_i − T_i−1)², which cannot be negative.
            own_N, whole_N = belt_tensions_N(answer)
            for span in press.spans:
                shares_N = sum(own_N[name, span.name] for name in span.belts)
                assert shares_N == pytest.approx(whole_N[span.name], rel=1e-8), (closure, factor)
            lost_W = 0.0
            for belt in press.belts:
                steps = {(span.start, span.end): span.name for span in press.spans}
                along_N = np.array([own_N[belt.name, steps[step]] for step in belt.steps])
                pace = rims[belt.loop[1]] / (1.0 + along_N[0] / belt.axial_stiffness_N)
                lost_W += 0.5 * pace / belt.axial_stiffness_N * np.sum((along_N - np.roll(along_N, 1)) ** 2)
            assert answer.creep_loss_W[0] == pytest.approx(lost_W, rel=1e-8), (closure, factor)


def test_the_drivers_differ_as_the_closures_say(paper_press):
    """To first order in the strain: equal speeds for `share`, the given ones for `speed-ratio`."""
    names = [one.name for one in paper_press.rollers]
    drivers = [names.index("1"), names.index("10")]
    one, other = solved(problem_of(with_stiffness(paper_press, 2e6, 2e6))).rim_speed_m_s[0][drivers]
    assert other == pytest.approx(one, rel=1e-6)
    overspeed = {"1": 2e-4, "10": -1e-4}
    rollers = tuple(replace(roller, overspeed=overspeed.get(roller.name)) for roller in paper_press.rollers)
    press = replace(with_stiffness(paper_press, 2e6, 3e6), rollers=rollers)
    one, other = solved(problem_of(press, "speed-ratio")).rim_speed_m_s[0][drivers]
    assert one / other - 1.0 == pytest.approx(3e-4, rel=1e-2)


def test_without_ea_creep_is_not_to_be_had(paper_press):
    effect, problem = SYSTEM.effects["elastic-creep"], problem_of(paper_press)
    assert effect.needs(problem) == ("belts.upper.axial_stiffness", "belts.lower.axial_stiffness")
    with pytest.raises(InputError, match="elastic-creep cannot be simulated without"):
        make_plan(SYSTEM, problem, accuracy=0.01, effects=("elastic-creep",))


def test_many_points_are_the_single_ones_side_by_side(paper_press):
    press, speeds = with_stiffness(paper_press, 2e5, 9e5), np.array([0.0, 1.0, 3.0])
    many = solved(problem_of(press, speed_m_s=speeds))
    for i, speed in enumerate(speeds):
        single = solved(problem_of(press, speed_m_s=speed))
        assert many.rim_speed_m_s[i] == pytest.approx(single.rim_speed_m_s[0], rel=1e-14)
        assert many.creep_loss_W[i] == pytest.approx(single.creep_loss_W[0], rel=1e-10)


def machine_of(**loops):
    """Belts by their loops of one-letter rollers: a and d drive, c and t tighten, b and e are loaded."""
    carrier = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0)
    roles = {"a": "driver", "d": "driver", "c": "tensioner", "t": "tensioner"}
    rollers = [Roller(name=name, radius_m=0.1, wrap_angle_rad=2.0, role=roles.get(name, "driven"),
                      squeeze_torque_N_m=20.0 * (name in "be"), tensioner=carrier if name in "ct" else None,
                      overspeed={"a": 0.0, "d": 3e-4}.get(name))
               for name in sorted(set("".join(loops.values())))]  # fmt: skip
    belts = [Belt(name=name, loop=tuple(loop), linear_density_kg_m=1.0, thickness_m=0.005, width_m=1.0,
                  axial_stiffness_N=1e6 * place)
             for place, (name, loop) in enumerate(loops.items(), start=1)]  # fmt: skip
    return Press(rollers=tuple(rollers), belts=tuple(belts), speed_m_s=1.0)


def test_creep_says_nothing_of_belts_that_never_meet():
    for closure in ["share", "speed-ratio"]:
        with pytest.raises(InputError, match=f"'{closure}' does not settle"):
            solve_statics(machine_of(one="abc", other="def"), closure=closure)


def test_belts_that_meet_and_part_twice_creep_alike_at_both_places():
    press = machine_of(one="abefc", other="dehft")
    state = steady_state(solve_statics(press, closure="speed-ratio"), speed_m_s=0.0)
    spans = {
        (span.start, span.end): tension for span, tension in zip(press.spans, state.tension_N, strict=True)
    }
    behind_e, behind_f = ([(spans[driver, way] - spans[place, by]) / (1e6 * EA)
                           for driver, way, place, by, EA in two]
                          for two in ((("c", "a", "b", "e", 1), ("t", "d", "d", "e", 2)),
                                      (("c", "a", "e", "f", 1), ("t", "d", "h", "f", 2))))  # fmt: skip
    for one, other in (behind_e, behind_f):
        assert one - other == pytest.approx(-3e-4, rel=1e-9)
