"""Steady tensions: the paper's numbers, what its equations leave open, other machines, and what speed does."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper import with_roller
from scipy.optimize import fsolve

from ropefric.errors import InputError, SolverError
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.statics import solve_statics, speed_shift_kg_m, steady_state

AT_REST = {"1": 821.382, "2": 1170.716, "3": 1520.049, "4": 1520.049, "5": 3615.793, "6": 3783.793,
           "7": 3951.793, "8": 4119.793, "11": 1639.743, "12": 1639.743, "13": 1639.743, "14": 1699.743}  # fmt: skip
SPLIT = {"share": (2054.05, 2233.74), "equal": (2143.90, 2143.90), "equal-torque": (1734.72, 2553.08)}
CROSS_SECTION = {"linear_density_kg_m": 2.0, "thickness_m": 0.005, "width_m": 1.0}


def of_span(state, name):
    return state.effective_tension_N[..., [span.name for span in state.press.spans].index(name)]


def spring(**changes):
    return Tensioner(**{"spring_N_m": 2e4, "travel_m": 0.03, "force_N": 800.0} | changes)


def one_belt(n_driven, **tensioner):
    rollers = [Roller(name="drive", radius_m=0.2, wrap_angle_rad=3.0, role="driver")]
    rollers += [
        Roller(name=f"r{i}", radius_m=0.05 + 0.01 * i, wrap_angle_rad=1.0, gravity_torque_N_m=1.0 + i)
        for i in range(n_driven)
    ]
    rollers.append(Roller(name="take-up", radius_m=0.1, wrap_angle_rad=3.0, role="tensioner",
                          tensioner=spring(**tensioner)))  # fmt: skip
    loop = tuple(roller.name for roller in rollers)
    return Press(rollers=tuple(rollers), belts=(Belt(name="b", loop=loop, **CROSS_SECTION),), speed_m_s=1.5)


def test_the_printed_machine_at_rest(paper_press):
    for closure, split_N in SPLIT.items():
        statics = solve_statics(paper_press, closure=closure)
        state = steady_state(statics, speed_m_s=0.0)
        found = dict(zip((span.name for span in paper_press.spans), state.tension_N, strict=True))
        for name, wanted in AT_REST.items():
            assert found[name] == pytest.approx(wanted, abs=1e-3), name
        assert (found["9"], found["10"]) == pytest.approx(split_N, abs=5e-3), closure
        assert found["9"] + found["10"] == pytest.approx(4287.793, abs=1e-3), closure


def test_one_belt_less_than_two_would_break_the_balance_of_roller_5(paper_press):
    """(39) holds for a belt: with ρAv² taken once from the spans of two belts the primed balances do not close."""
    state = steady_state(solve_statics(paper_press))
    c = 15.0 * paper_press.speed_m_s**2
    assert c == pytest.approx(12.5940, abs=5e-5)
    np.testing.assert_allclose(state.tension_N - state.effective_tension_N, [c] * 4 + [2 * c] * 4 + [c] * 6)
    literal = state.tension_N - c
    loads_N = paper_press.rim_load_N
    gap_N = (paper_press.incidence @ literal - loads_N)[[4, 8]]
    np.testing.assert_allclose(gap_N, [c, -c], rtol=1e-9)


def test_what_the_balances_leave_open_is_said_and_closed(paper_press):
    """Without driver 10 its torque balance replaces the closure; one belt leaves nothing open."""
    dragged = solve_statics(with_roller(paper_press, "10", role="driven"))
    for statics, wanted in ((solve_statics(paper_press), (13, ("T9 may rise while T10 falls as much",), "share")),
                            (dragged, (14, (), "")), (solve_statics(one_belt(3)), (5, (), ""))):  # fmt: skip
        assert (statics.rank, statics.undetermined, statics.closure) == wanted
    T = partial(of_span, steady_state(dragged))
    assert float(T("10")) == pytest.approx(float(T("11")))


def test_what_settles_no_tensions_is_refused_by_name(paper_press):
    loose = with_roller(paper_press, "13", role="driven", tensioner=None)
    twice = with_roller(paper_press, "4", role="tensioner", tensioner=spring())
    statics = solve_statics(paper_press)
    for refuses, words in (
        (partial(solve_statics, loose), "leave 2 thing"),
        (partial(solve_statics, twice), "travel of tensioner 3, travel of tensioner 4"),
        (partial(solve_statics, paper_press, closure="speed-ratio"),
         r"belts\.upper\.axial_stiffness_N, belts\.lower\.axial_stiffness_N"),
        (partial(steady_state, statics, tensioner="elastic"),
         r"belts\.upper\.axial_stiffness_N.*belts\.lower\.span_lengths_m"),
        (partial(steady_state, statics, speed_m_s=[1.0, -1.0]), "speed_m_s is -1"),
        (partial(steady_state, statics, preload_N=float("nan")), "preload_N is nan"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words) as found:
            refuses()
        assert "torque of roller 6" not in str(found.value)
        if "upper" in words and "span" not in words:
            keys = [problem.key for problem in found.value.problems]
            assert keys[2:] == ["rollers.1.overspeed", "rollers.10.overspeed"]


def test_closures_say_what_they_mean(paper_press):
    at = steady_state(solve_statics(paper_press), speed_m_s=0.0)
    share = partial(of_span, at)
    assert float(share("9") - share("4")) == pytest.approx(float(share("10") - share("14")))
    machine = with_roller(paper_press, "10", radius_m=0.35)
    T = partial(of_span, steady_state(solve_statics(machine, closure="equal-torque")))
    assert 0.175 * float(T("9") - T("1")) == pytest.approx(0.35 * float(T("10") - T("11")))


def with_speeds(press, stiffness_N=(2e6, 2e6), overspeed=(0.0, 0.0)):
    rollers = tuple(replace(r, overspeed=overspeed[0 if r.name == "1" else 1]) if r.role == "driver" else r
                    for r in press.rollers)  # fmt: skip
    belts = tuple(replace(b, axial_stiffness_N=EA) for b, EA in zip(press.belts, stiffness_N, strict=True))
    return replace(press, rollers=rollers, belts=belts)


def test_speed_ratio_solves_steady_creep(paper_press):
    """Against the nonlinear statement: v_b (1 + T/EA) is the speed of the roller where a belt arrives."""
    equal, share = solve_statics(with_speeds(paper_press), closure="speed-ratio"), solve_statics(paper_press)
    np.testing.assert_allclose(equal.given_N, share.given_N, rtol=1e-12)
    np.testing.assert_allclose(equal.by_load_N, share.by_load_N, rtol=1e-12)
    EA, over = (2e6, 5e6), (1e-4, 3e-4)
    press = with_speeds(paper_press, EA, over)
    T = partial(of_span, steady_state(solve_statics(press, closure="speed-ratio"), speed_m_s=0.0))
    T4, T14, total = float(T("4")), float(T("14")), float(T("9") + T("10"))

    def residuals(unknown):
        v_upper, v_lower, V5, T9 = unknown * [1.0, 1.0, 1.0, 1e3]
        return [v_upper * (1 + T9 / EA[0]) - (1 + over[0]),
                v_lower * (1 + (total - T9) / EA[1]) - (1 + over[1]), v_upper * (1 + T4 / EA[0]) - V5,
                v_lower * (1 + T14 / EA[1]) - V5]  # fmt: skip

    exact = fsolve(residuals, [1.0, 1.0, 1.0, 2.0], xtol=1e-13)[3] * 1e3
    # Linear in the strain, of order 1e-3: the pick-up of some hundred newtons is met to a few tenths of one.
    assert float(T("9")) == pytest.approx(exact, abs=0.5)
    slower = with_speeds(paper_press, EA, (1e-4, 0.0))
    behind = steady_state(solve_statics(slower, closure="speed-ratio"))
    assert float(of_span(behind, "10")) < float(T("10"))


# --- other machines --------------------------------------------------------------------------------------


@st.composite
def machines(draw):
    """Two belts with any number of loaded rollers before, in and after the run they share."""
    counts = draw(st.lists(st.integers(0, 3), min_size=5, max_size=5))
    load, radius = st.floats(0.0, 5.0), st.floats(0.05, 0.3)
    rollers, parts = [], []
    for group, n in zip(
        ("a1", "a2", "s", "b1", "b2"), (*counts[:2], counts[2] + 1, *counts[3:]), strict=True
    ):
        names = tuple(f"{group}-{i}" for i in range(n))
        parts.append(names)
        rollers += [
            Roller(name=name, radius_m=draw(radius), wrap_angle_rad=1.0, squeeze_torque_N_m=draw(load))
            for name in names
        ]
    angle = draw(st.floats(0.0, 1.2))
    for k in "ab":
        rollers.append(Roller(name=f"d{k}", radius_m=draw(radius), wrap_angle_rad=3, role="driver"))
        take_up = spring(force_N=draw(st.floats(500, 5000)), upstream_angle_rad=angle)
        rollers.append(
            Roller(name=f"t{k}", radius_m=0.1, wrap_angle_rad=3, role="tensioner", tensioner=take_up)
        )
    a1, a2, shared, b1, b2 = parts
    belts = (Belt(name="a", loop=(*shared, *a1, "da", "ta", *a2), **CROSS_SECTION),
             Belt(name="b", loop=(*shared, *b1, "db", *b2, "tb"), **CROSS_SECTION))  # fmt: skip
    return Press(rollers=tuple(rollers), belts=belts, speed_m_s=1.0)


@given(press=machines(), closure=st.sampled_from(sorted(SPLIT)))
@settings(max_examples=20, deadline=None)
def test_any_machine_of_two_belts_is_balanced(press, closure):
    statics = solve_statics(press, closure=closure)
    assert statics.rank == len(press.spans) - 1
    T = steady_state(statics, on_slack="flag").tension_N
    driven = np.array([roller.role != "driver" for roller in press.rollers])
    loads_N = press.rim_load_N
    np.testing.assert_allclose((press.incidence @ T)[driven], loads_N[driven], atol=1e-8)
    acting_N = [600.0 + tensioner.force_N for tensioner in press.tensioners.values()]
    np.testing.assert_allclose(press.pull @ T, acting_N, rtol=1e-10)
    assert float((press.incidence @ T)[~driven].sum()) == pytest.approx(-loads_N.sum(), abs=1e-8)


def test_three_belts_need_two_statements():
    rollers = [Roller(name="x", radius_m=0.1, wrap_angle_rad=3, squeeze_torque_N_m=9.0)]
    for k in "abc":
        rollers.append(Roller(name=f"d{k}", radius_m=0.1, wrap_angle_rad=3, role="driver"))
        rollers.append(
            Roller(name=f"t{k}", radius_m=0.1, wrap_angle_rad=3, role="tensioner", tensioner=spring())
        )
    belts = tuple(Belt(name=k, loop=("x", f"d{k}", f"t{k}"), **CROSS_SECTION) for k in "abc")
    press = Press(rollers=tuple(rollers), belts=belts, speed_m_s=0.0)
    assert len(press.spans) == 9
    assert press.incidence[0].tolist() == [1, 0, -1] * 3
    statics = solve_statics(press)
    assert len(statics.undetermined) == 2
    T = steady_state(statics)
    np.testing.assert_allclose([float(of_span(T, s.name)) for s in press.spans if s.start == "x"], 730.0)


def test_two_drivers_of_one_belt():
    rollers = (Roller(name="d1", radius_m=0.1, wrap_angle_rad=3, role="driver"),
               Roller(name="m", radius_m=0.1, wrap_angle_rad=3, squeeze_torque_N_m=10.0),
               Roller(name="d2", radius_m=0.1, wrap_angle_rad=3, role="driver"),
               Roller(name="t", radius_m=0.1, wrap_angle_rad=3, role="tensioner", tensioner=spring()))  # fmt: skip
    belt = Belt(name="b", loop=("d1", "m", "d2", "t"), **CROSS_SECTION)
    press = Press(rollers=rollers, belts=(belt,), speed_m_s=0.0)
    torque = steady_state(solve_statics(press, closure="equal-torque")).tension_N
    np.testing.assert_allclose(torque, [650.0, 750.0, 700.0, 700.0])
    share = steady_state(solve_statics(press)).tension_N  # equal speed: equal strain where the belt arrives
    np.testing.assert_allclose(share, [600.0, 700.0, 700.0, 700.0])
    with pytest.raises(InputError, match="the closure 'equal' does not settle: T1, T2 may rise together"):
        solve_statics(press, closure="equal")


# --- operating points ------------------------------------------------------------------------------------


def test_grids_are_the_points_by_themselves(paper_press):
    statics = solve_statics(paper_press)
    preload, speed, load = np.array([1500.0, 2500.0])[:, None], np.array([0.0, 1.0, 3.0]), 0.7
    grid = steady_state(statics, preload_N=preload, speed_m_s=speed, load_factor=load)
    assert grid.tension_N.shape == (2, 3, 14)
    for i, F in enumerate(preload.ravel()):
        for j, v in enumerate(speed):
            moved = replace(paper_press,
                            rollers=tuple(replace(r, gravity_torque_N_m=load * r.gravity_torque_N_m,
                                                  squeeze_torque_N_m=load * r.squeeze_torque_N_m,
                                                  tensioner=r.tensioner and replace(r.tensioner, force_N=F))
                                          for r in paper_press.rollers),
                            speed_m_s=v)  # fmt: skip
            point = steady_state(solve_statics(moved))
            np.testing.assert_allclose(grid.tension_N[i, j], point.tension_N, rtol=1e-12)


def test_each_tensioner_can_have_its_own_preload(paper_press):
    tighter = replace(paper_press.tensioners["3"], force_N=3000.0)
    both = steady_state(solve_statics(with_roller(paper_press, "3", tensioner=tighter)))
    base = steady_state(solve_statics(paper_press))
    rise = both.effective_tension_N - base.effective_tension_N
    moved = 1000.0 / (1 + math.cos(math.radians(19.9)))
    np.testing.assert_allclose(rise, moved * np.array([1.0] * 9 + [0.0] * 5), atol=1e-9)


def test_a_slack_span_is_refused_by_name_or_flagged(paper_press):
    statics = solve_statics(paper_press)
    with pytest.raises(
        SolverError, match=r"span 1 \(roller 1 to 2\) goes slack at point 0 of 2: T' = -"
    ) as found:
        steady_state(statics, preload_N=[0.0, 2000.0])
    assert found.value.where == "span 1"
    flagged = steady_state(statics, preload_N=[0.0, 2000.0], on_slack="flag")
    assert flagged.slack.tolist() == [True, False]
    assert np.isfinite(flagged.effective_tension_N).all()


# --- speed -----------------------------------------------------------------------------------------------


def elastic(press, EA=2e6, spring_N_m=None):
    belts = (replace(press.belts[0], axial_stiffness_N=EA,
                     span_lengths_m=(1.0, 1.2, 0.8, 1.5, 0.6, 0.6, 0.6, 0.6, 1.1)),
             replace(press.belts[1], axial_stiffness_N=EA,
                     span_lengths_m=(0.9, 2.0, 1.0, 0.7, 1.3, 0.6, 0.6, 0.6, 0.6)))  # fmt: skip
    rollers = tuple(replace(r, tensioner=replace(r.tensioner, spring_N_m=spring_N_m)) if r.tensioner
                    and spring_N_m is not None else r for r in press.rollers)  # fmt: skip
    return replace(press, belts=belts, rollers=rollers)


def loop_lengths_m(press):
    arcs_m = {r.name: r.radius_m * r.wrap_angle_rad for r in press.rollers}
    return np.array([sum(b.span_lengths_m) + sum(arcs_m[name] for name in b.loop) for b in press.belts])


def test_the_elastic_speed_effect_in_closed_form(paper_press, paper_data):
    for EA in [1e6, 2e6, 1e7]:
        press = elastic(paper_press, EA)
        shift = speed_shift_kg_m(solve_statics(press), "elastic")
        lengths_m = loop_lengths_m(press)
        cosines = np.array([1 + math.cos(paper_data["beta"]), 1 + math.cos(paper_data["gamma"])])
        s = cosines**2 * (EA / lengths_m) / paper_data["tensioner_stiffness"]
        upper, lower = -15.0 / (1 + s)
        np.testing.assert_allclose(
            shift, [upper] * 4 + [upper + lower] * 4 + [upper] + [lower] * 5, rtol=1e-12
        )


def test_the_elastic_speed_effect_between_its_limits(paper_press):
    """A stiff spring is the paper's locked tensioner; a spring of no stiffness keeps the tension T'."""
    locked = speed_shift_kg_m(solve_statics(paper_press), "locked")
    stiff = speed_shift_kg_m(solve_statics(elastic(paper_press, spring_N_m=1e13)), "elastic")
    np.testing.assert_allclose(stiff, locked, rtol=1e-6)
    loose = speed_shift_kg_m(solve_statics(elastic(paper_press, spring_N_m=0.0)), "elastic")
    np.testing.assert_allclose(loose, 0.0, atol=1e-9)


def test_the_elastic_run_obeys_the_translation_of_the_tensioners(paper_press):
    """(21), (22) at rest in x: k1 x + F = P T' with the travel that the belts' length allows."""
    for closure in SPLIT:
        press = elastic(paper_press)
        statics = solve_statics(press, closure=closure)
        v = 6.0
        state = steady_state(statics, speed_m_s=v, tensioner="elastic")
        travel_m = (press.pull @ state.effective_tension_N - 2000.0) / 20000.0
        assert (travel_m < 0.03).all(), closure
        shift = speed_shift_kg_m(statics, "elastic")
        np.testing.assert_allclose(
            state.effective_tension_N, steady_state(statics, speed_m_s=0.0).tension_N + v**2 * shift
        )
        upper = shift[0]  # belt 1 alone: its length changes as its tensioner gives way
        longer_m = loop_lengths_m(press)[0] / 2e6 * (upper + 15.0) * v**2
        assert longer_m == pytest.approx(
            (0.03 - travel_m[0]) * (1 + math.cos(math.radians(19.9))), rel=1e-9
        ), closure
