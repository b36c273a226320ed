"""A rope through elements: against its differential equation, from both ends, its effects, its failures, bad input."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import ropefric.systems.line.elements as kinds
from ropefric.errors import DataError
from ropefric.scenes.draws import draw_scene
from ropefric.scenes.explain import explain_scene
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import parse_axis, sweep_scene
from ropefric.systems.line.tendon import anchored, stressed

BEND = {"kind": "bend", "angle": "70 deg", "radius": "300 mm"}
DUCT = {"kind": "bend", "angle": "1.2 rad", "length": "3 m", "wobble": "0.05 rad/m", "radius": "2 m"}
HILL = {"kind": "run", "length": "40 m", "slope": "20 deg", "wobble": "0.02 rad/m"}
WHEEL = {"kind": "wheel", "efficiency": 0.9, "drag": "12 N", "angle": "180 deg"}
ROPE = {"linear_density": "2 kg/m", "axial_stiffness": "300 kN", "diameter": "12 mm"}
LAWS = [{"mu": 0.3}, {"law": "wrap-power", "parameters": {"a": 0.2, "b": -0.5, "c": 0.1}},
        {"law": "howell", "parameters": {"A": 0.4, "n": 0.85}},
        {"law": "size-exponential", "parameters": {"mu_inf": 0.3, "a": -0.2, "b": -0.1}},
        {"law": "constant-offset", "parameters": {"mu": 0.2, "k": 0.1}},
        {"law": "coupled", "parameters": {"mu_inf": 0.46, "a": -0.22, "b": -0.3, "c": -0.48, "d": 0.055}}]  # fmt: skip


def pulled(start="400 N", **more):
    return {"start_tension": start, **more}


def test_a_duct_and_a_hill_follow_their_differential_equation(answer_of):
    """dT/ds = μ T (θ/L + k) in the duct, μ k T + w (sin α + μ cos α) on the hill; the elongation is ∫T ds/EA."""
    found = answer_of(DUCT, HILL, line=pulled(), rope=ROPE, friction={"mu": 0.3})
    weight = 2.0 * 9.80665 * (math.sin(math.radians(20.0)) + 0.3 * math.cos(math.radians(20.0)))
    tension, stretch = 400.0, 0.0
    for length, slope, gain in ((3.0, 0.0, 0.3 * (0.4 + 0.05)), (40.0, weight, 0.3 * 0.02)):
        one = solve_ivp(lambda _, y, gain=gain, slope=slope: (gain * y[0] + slope, y[0]), (0.0, length), (tension, 0.0),
                        rtol=1e-12, atol=1e-9, method="DOP853")  # fmt: skip
        tension, stretch = one.y[0, -1], stretch + one.y[1, -1]
    assert found["hand_tension_N"] == pytest.approx(tension, rel=1e-10)
    assert found["elongation_m"] == pytest.approx(stretch / 300e3, rel=1e-10)


@pytest.mark.parametrize("friction", LAWS, ids=str)
@pytest.mark.parametrize("direction", ["pull", "pay-out"])
def test_solved_backwards_it_comes_back_to_its_start(answer_of, friction, direction):
    elements = (BEND, HILL, DUCT, WHEEL, BEND)
    there = answer_of(*elements, line=pulled("2 kN", direction=direction), rope=ROPE, friction=friction)
    end = f"{there['hand_tension_N']!r} N"
    back = answer_of(
        *elements, line={"end_tension": end, "direction": direction}, rope=ROPE, friction=friction
    )
    assert back["tension_N"] == pytest.approx(there["tension_N"], rel=1e-12)
    assert back["elongation_m"] == pytest.approx(there["elongation_m"], rel=1e-12)


def test_friction_helps_a_rope_that_is_paid_out_by_as_much_as_it_resists(answer_of):
    there = answer_of(BEND, DUCT, line=pulled(), friction={"mu": 0.3})
    back = answer_of(DUCT, BEND, line={"start_tension": f"{there['hand_tension_N']!r} N", "direction": "pay-out"},
                     friction={"mu": 0.3})  # fmt: skip
    assert back["hand_tension_N"] == pytest.approx(400.0, rel=1e-13)


@pytest.mark.parametrize("friction", LAWS[1:3], ids=str)
def test_the_elongation_of_a_law_that_looks_at_the_wrap(line_of, friction):
    scene = line_of(BEND, line=pulled(), rope=ROPE, friction=friction)
    law = scene.problem.friction

    def tension_N(angle):
        return 400.0 * math.exp(float(law.exponent(0.3, 0.006, angle, 400.0)))

    angle = math.radians(70.0)
    expected = 0.3 * quad(tension_N, 0.0, angle, epsabs=0.0, epsrel=1e-11)[0] / 300e3
    assert solve_scene(scene).to_dict()["elongation_m"] == pytest.approx(expected, rel=1e-9)


def test_a_slope_is_uphill_in_the_direction_from_start_to_end(answer_of):
    up, down = (answer_of({**HILL, "slope": slope}, line=pulled(), rope=ROPE, friction={"mu": 0.0})["hand_tension_N"]
                for slope in ("20 deg", "-20 deg"))  # fmt: skip
    lifted = 2.0 * 9.80665 * 40.0 * math.sin(math.radians(20.0))
    assert (up, down) == pytest.approx((400.0 + lifted, 400.0 - lifted), rel=1e-14)
    # Beyond the vertical the floor carries the rope as on the other side of it.
    steep, overhung = (answer_of({**HILL, "slope": slope}, line=pulled(), rope=ROPE, friction={"mu": 0.3})["tension_N"]
                       for slope in ("80 deg", "100 deg"))  # fmt: skip
    assert overhung == pytest.approx(steep, rel=1e-13)


def test_the_other_end_is_the_same_line_written_in_reverse(answer_of):
    one = answer_of(BEND, HILL, WHEEL, line=pulled(), rope=ROPE, friction={"mu": 0.3})
    other = answer_of(
        WHEEL, {**HILL, "slope": "-20 deg"}, BEND, line=pulled(), rope=ROPE, friction={"mu": 0.3}
    )
    assert one["from_other_end"]["hand_tension_N"] == pytest.approx(other["hand_tension_N"], rel=1e-14)
    assert other["from_other_end"]["hand_tension_N"] == pytest.approx(one["hand_tension_N"], rel=1e-14)


def test_a_cycle_of_a_bowden_cable(answer_of):
    """Over 180° at 0.1 the hand pulls with T e^M and pays out with T e^-M; lost is ∫(difference) ds/EA."""
    sheath = {"kind": "bend", "angle": "180 deg", "length": "1 m"}
    cycle = answer_of(sheath, line=pulled("100 N"), rope={"axial_stiffness": "20 kN"}, friction={"mu": 0.1})[
        "cycle"
    ]
    M = 0.1 * math.pi
    assert cycle["dead_band_N"] == pytest.approx(200.0 * math.sinh(M), rel=1e-13)
    stroke = 100.0 / 20e3 * (math.expm1(M) / M + math.expm1(-M) / M)
    assert cycle["lost_stroke_m"] == pytest.approx(stroke, rel=1e-12)


def test_where_a_law_has_no_answer_to_the_other_way_the_rest_is_answered(answer_of):
    """Paid out from 3 N the slack side falls below the 1 N from which such a law counts."""
    found = answer_of({**BEND, "angle": "3 turn"}, BEND, line=pulled("3 N"), friction=LAWS[1])
    assert found["hand_tension_N"] > 3.0
    assert "cycle" not in found


def test_a_stiff_rope_in_a_bend_is_that_of_the_hoist(answer_of, line_of):
    from ropefric.files.toml import TomlDocument
    from ropefric.scenes.scene import read_scene

    bend = {"kind": "bend", "angle": "400 deg", "radius": "16 mm"}
    rope = {"diameter": "9.8 mm", "bending_stiffness": "4e-3 N*m^2"}
    mine = answer_of(bend, line=pulled("60 N"), rope=rope, friction={"mu": 0.2})
    hoist = {"system": "hoist", "wheel": {"radius": "16 mm", "wrap": "400 deg"}, "rope": rope, "effects": "all",
             "load": {"end_tension": "60 N"}, "friction": {"mu": 0.2}}  # fmt: skip
    theirs = solve_scene(read_scene(TomlDocument(path="h.toml", data=hoist, lines={}), Path())).to_dict()
    assert mine["hand_tension_N"] == pytest.approx(theirs["lift_force_N"], rel=1e-13)
    back = answer_of(
        bend, line={"end_tension": f"{mine['hand_tension_N']!r} N"}, rope=rope, friction={"mu": 0.2}
    )
    assert back["start_tension_N"] == pytest.approx(60.0, rel=1e-12)


def test_two_drums_share_a_pull_and_the_take_up_serves_both(answer_of):
    """The first needs T3 ≥ s1 F/(e^M1 − 1) behind it, the second T2 ≥ s2 F/(e^M2 − 1); T2 = T3 − s2 F between them."""
    drums = [{"kind": "drum", "angle": "200 deg", "share": 0.6, "radius": "400 mm"}, {"kind": "run", "length": "5 m"},
             {"kind": "drum", "angle": "190 deg", "share": 0.4}]  # fmt: skip
    found = answer_of(*drums, line={"pull": "20 kN"}, friction={"mu": 0.3})
    M1, M2 = 0.3 * math.radians(200.0), 0.3 * math.radians(190.0)
    needed = max(12e3 / math.expm1(M1) - 8e3, 8e3 / math.expm1(M2))
    assert found["needed_end_tension_N"] == found["hand_tension_N"] == pytest.approx(needed, rel=1e-13)
    assert found["start_tension_N"] == pytest.approx(needed + 20e3, rel=1e-13)
    assert max(found["elements"][i]["utilisation"] for i in (0, 2)) == pytest.approx(1.0, rel=1e-12)
    assert found["elements"][0]["torque_N_m"] == pytest.approx(4800.0)
    assert not found["failures"]
    less = answer_of(
        *drums, line={"pull": "20 kN", "end_tension": f"{0.99 * needed!r} N"}, friction={"mu": 0.3}
    )
    assert any("slips on the drum" in one for one in less["failures"])


def test_a_winch_of_three_drums_lowers_the_tension_by_each_grip(answer_of):
    drums = [{"kind": "drum", "angle": "180 deg", "radius": "0.25 m", "mu": 0.15}] * 3
    found = answer_of(*drums, line=pulled("50 kN"))
    assert found["hand_tension_N"] == pytest.approx(50e3 * math.exp(-0.45 * math.pi), rel=1e-13)
    torques = [one["torque_N_m"] for one in found["elements"]]
    assert sum(torques) == pytest.approx(0.25 * (50e3 - found["hand_tension_N"]), rel=1e-13)
    assert all(one["utilisation"] == 1.0 for one in found["elements"])
    hardly = answer_of({**drums[0], "angle": "1 rad", "radius": "1 m", "mu": 1e-13}, line=pulled("1 kN"))
    assert hardly["elements"][0]["torque_N_m"] == pytest.approx(1e-10, rel=1e-12), "it keeps its digits"
    braked = answer_of({**drums[0], "braked": True}, line=pulled("50 kN"))
    assert braked["hand_tension_N"] == pytest.approx(50e3 * math.exp(0.15 * math.pi), rel=1e-13)


def test_a_hauling_system_with_the_efficiencies_of_each_wheel(answer_of):
    """3:1 of climbers: the wheel at the load 84.2 %, that at the anchor 74.7 %: 1 + 0.747 (1 + 0.842)."""
    strand = {"kind": "run", "length": "10 m", "carries": True, "slope": "90 deg"}
    wheels = [{"kind": "wheel", "efficiency": one} for one in (0.842, 0.747)]
    found = answer_of(
        strand, wheels[0], strand, wheels[1], strand, line={"end_tension": "300 N"}, friction={"mu": 0.1}
    )
    assert found["advantage"] == pytest.approx(1.0 + 0.747 * (1.0 + 0.842), rel=1e-13)
    assert found["load_N"] == pytest.approx(300.0 * found["advantage"], rel=1e-13)


PROFILE = np.array([1000.0, 950.0, 950.0, 800.0, 760.0])
LENGTHS = np.array([10.0, 5.0, 20.0, 0.0])


def along(tensions, lengths):
    """Return T(x) with ln T linear within each element."""
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    return lambda x: math.exp(np.interp(x, places, np.log(tensions)))


@pytest.mark.parametrize("slip_N_m", [300.0, 2500.0, 6000.0])
def test_an_anchored_tendon_lost_as_much_length_as_its_anchorage_slipped(slip_N_m):
    profile = PROFILE[:4]
    found = anchored(profile[:, None], LENGTHS[:3], np.array([slip_N_m]))
    before, turns = along(profile, LENGTHS[:3]), float(found.largest_N[0])

    def lost(x):
        return before(x) - min(before(x), turns**2 / before(x)) if found.affected_m[0] < 35.0 else 0.0

    if found.affected_m[0] < 35.0:
        area = quad(lost, 0.0, 35.0, points=[10.0, 15.0, float(found.affected_m[0])], epsabs=1e-9)[0]
        assert area == pytest.approx(slip_N_m, rel=1e-6)
    else:
        after = along(found.tension_N[:, 0], LENGTHS[:3])
        area = quad(lambda x: before(x) - after(x), 0.0, 35.0, points=[10.0, 15.0], epsabs=1e-9)[0]
        assert area == pytest.approx(slip_N_m, rel=1e-9)
        assert found.tension_N[-1, 0] > found.tension_N[0, 0]
    assert (found.tension_N <= profile[:, None]).all()


def test_from_both_ends_the_larger_tension_holds_and_they_meet_at_the_least(answer_of):
    duct = {"kind": "bend", "angle": "0.4 rad", "length": "40 m", "wobble": "0.008 rad/m"}
    rope, jack = {"axial_stiffness": "400 MN"}, {"end_tension": "3 MN", "both_ends": True}
    both = answer_of(duct, duct, line=jack, rope=rope, friction={"mu": 0.2})
    M = 0.2 * (0.4 + 0.32)
    assert both["tension_N"] == pytest.approx([3e6, 3e6 * math.exp(-M), 3e6], rel=1e-13)
    assert both["least_tension_N"] == pytest.approx(3e6 * math.exp(-M), rel=1e-12)
    assert both["both_ends"]["least_at_m"] == pytest.approx(40.0)
    drawn = 3e6 / 400e6 * 40.0 * -math.expm1(-M) / M
    assert both["elongation_m"] == pytest.approx(2.0 * drawn, rel=1e-12)
    uneven = answer_of({**duct, "angle": "0.8 rad", "length": "80 m"}, line={**jack, "start_tension": "2.8 MN"},
                       rope=rope, friction={"mu": 0.2})  # fmt: skip
    assert uneven["least_tension_N"] == pytest.approx(math.sqrt(3e6 * 2.8e6) * math.exp(-M), rel=1e-12)
    slipped = answer_of(duct, duct, line={**jack, "anchorage_slip": "6 mm"}, rope=rope, friction={"mu": 0.2})
    one = answer_of(
        duct, duct, line={"end_tension": "3 MN", "anchorage_slip": "6 mm"}, rope=rope, friction={"mu": 0.2}
    )
    anchors_N = [found["anchor_N"] for found in slipped["anchored"]]
    assert anchors_N == pytest.approx([one["anchored"][0]["anchor_N"]] * 2)
    behind = slice(1, None), slice(0, 2)  # out of reach of the slip nothing changes
    for found, place, unchanged in zip(slipped["anchored"], (0, 2), behind, strict=True):
        assert found["tension_N"][place] == found["anchor_N"]
        assert found["tension_N"][unchanged] == pytest.approx(both["tension_N"][unchanged], rel=1e-12)


def test_two_jacks_of_which_one_does_all():
    own, other = np.array([[1000.0], [900.0]]), np.array([[500.0], [520.0]])
    found = stressed(own, other, np.array([10.0]))
    assert (found.least_N[0], found.least_at_m[0]) == pytest.approx((900.0, 10.0))
    assert found.elongation_N_m[1, 0] == 0.0


def test_a_rope_that_would_have_to_push_is_a_failure_with_its_place(line_of):
    down = {"kind": "run", "length": "40 m", "slope": "-60 deg", "name": "shaft"}
    solution = solve_scene(line_of(down, BEND, line=pulled("100 N"), rope=ROPE, friction={"mu": 0.2}))
    assert not solution.stands
    assert re.search(r"shaft: the rope would have to push: lowest tension in N -\d+", solution.failures[0])
    assert solution.to_dict()["elements"][1]["normal_N_m"] == 0.0


def test_limits_of_side_pressure_and_tension_are_kept_or_said(answer_of):
    over = answer_of(
        {**BEND, "normal_limit": "1 kN/m"}, line=pulled(tension_limit="500 N"), friction={"mu": 0.3}
    )
    assert len(over["failures"]) == 2
    assert "presses on the bend by more than its limit" in over["failures"][0]
    under = answer_of(
        {**BEND, "normal_limit": "10 kN/m"}, line=pulled(tension_limit="5 kN"), friction={"mu": 0.3}
    )
    assert under["failures"] == []
    assert under["elements"][0]["utilisation"] == pytest.approx(under["elements"][0]["normal_N_m"] / 10e3)


def test_every_effect_is_worth_what_leaving_it_out_changes(line_of):
    """Where a list leaves effects out, every tension is within the bound; without any a limp, light rope runs free."""
    rope = {**ROPE, "bending_stiffness": "0.05 N*m^2"}
    tables = {"line": pulled(), "rope": rope, "friction": LAWS[1]}
    told = explain_scene(line_of(DUCT, HILL, WHEEL, **tables)).plan.decisions
    assert all(one.fate == "simulated" for one in told)
    assert all(one.worth > 0.0 for one in told if one.name not in {"size", "stretch"})
    whole = solve_scene(line_of(DUCT, HILL, WHEEL, **tables, effects="all"))
    for left_out in ("weight", "bending-stiffness", "wrap-dependence"):
        names = [one.name for one in told if one.name != left_out]
        some = solve_scene(line_of(DUCT, HILL, WHEEL, **tables, effects=names))
        assert some.plan.left_out == (left_out,)
        for one, all_in in zip(some.answer.tension_N, whole.answer.tension_N, strict=True):
            assert abs(one / all_in - 1.0).max() <= some.plan.error_bound + 1e-12


def test_what_an_effect_lacks_is_said(line_of):
    plan = explain_scene(line_of(BEND, line=pulled(), friction={"mu": 0.2})).plan
    told = {one.name: one.missing for one in plan.decisions}
    assert told["weight"] == ("rope.linear_density", "element.length of a run")
    assert told["wobble"] == ("element.wobble",)
    assert told["bearing"] == ("element.efficiency",)
    assert told["stretch"] == ("rope.axial_stiffness",)


def test_a_fit_gives_every_tension_its_interval(answer_of):
    found = answer_of(BEND, BEND, line=pulled(), rope=ROPE, friction={"fit": "../../fits/prth-coupled.json"})
    assert found["interval_N"][0] < found["hand_tension_N"] < found["interval_N"][1]
    for one in found["elements"]:
        low, high = one["tension_out_interval_N"]
        assert low < one["tension_out_N"] < high


def test_numbers_of_elements_can_be_swept_and_drawn(line_of):
    scene = line_of(BEND, HILL, line=pulled(), rope=ROPE, friction={"mu": 0.3},
                    tolerances={"element": {"0": {"angle": "5 deg"}}})  # fmt: skip
    swept = sweep_scene(scene, (parse_axis(scene, "element.0.angle=0.5rad:1.5rad:3"),))
    single = [solve_scene(line_of({**BEND, "angle": f"{one} rad"}, HILL, line=pulled(), rope=ROPE, friction={"mu": 0.3}))
              for one in (0.5, 1.0, 1.5)]  # fmt: skip
    single_N = [one.to_dict()["hand_tension_N"] for one in single]
    assert swept.columns["hand_tension_N"] == pytest.approx(single_N)
    assert "elements.0.tension_out_N" in swept.columns
    draws = draw_scene(scene, 80, seed=1)
    drawn = draws.columns["hand_tension_N"]
    assert draws.numbers["start_tension_N"] == (400.0, 400.0, 0.0, (400.0,) * 3)
    tables = {"line": pulled(), "rope": ROPE, "friction": {"mu": 0.3}}
    ends = [solve_scene(line_of({**BEND, "angle": f"{one} deg"}, HILL, **tables)) for one in (65.0, 75.0)]
    low, high = (one.to_dict()["hand_tension_N"] for one in ends)
    assert low < drawn.min() < low + 0.1 * (high - low)
    assert high - 0.1 * (high - low) < drawn.max() < high


LINE = """system = "line"
[line]
start_tension = "90 N"
[friction]
mu = 0.3
[[element]]
kind = "bend"
angle = "90 deg"
[[element]]
kind = "run"
length = "30 m"
"""


def test_a_bend_that_is_too_tight_for_a_stiff_rope_is_refused_with_its_key(tmp_path):
    path = tmp_path / "line.toml"
    text = LINE.replace('angle = "90 deg"', 'angle = "90 deg"\nradius = "10 mm"')
    path.write_text(text + '[rope]\nbending_stiffness = "1 N*m^2"\n', encoding="utf-8")
    with pytest.raises(DataError, match=r"line\.toml.*too stiff to follow"):
        solve_scene(load_scene(path))


def test_what_an_element_makes_of_the_tension_is_said_at_its_line(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(LINE + '[[element]]\nkind = "bend"\nangle = "90 turn"\n', encoding="utf-8")
    with pytest.raises(DataError, match=r"line\.toml:12 element\[2\]: the tension grows beyond any rope"):
        solve_scene(load_scene(path))


@pytest.mark.slow
def test_a_stranger_adds_a_kind_of_element_by_one_file(tmp_path):
    """A copy of the package with one file more knows the element, its key, its unit and its meaning."""
    import shutil
    import subprocess
    import sys

    package = Path(kinds.__file__).parents[3]
    shutil.copytree(package, tmp_path / "ropefric", ignore=shutil.ignore_patterns("*.npz"))
    page = (package / "../docs/extend.md").read_text(encoding="utf-8")
    _, _, capstan = page.partition("```python\n")
    element = tmp_path / "ropefric/systems/line/elements/capstan.py"
    element.write_text(capstan.partition("```")[0], encoding="utf-8")
    scene = tmp_path / "wound.toml"
    table = '[[element]]\nkind = "capstan"\nangle = "90 deg"\ngroove = "60 deg"\nmu = 0.2\n'
    scene.write_text(LINE + table, encoding="utf-8")
    code = f"import ropefric as rf; print(rf.solve({str(scene)!r}).to_dict()['tension_N'])"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False,
                          env={"PYTHONPATH": str(tmp_path), "PATH": ""})  # fmt: skip
    assert done.returncode == 0, done.stderr
    tensions = [float(one) for one in done.stdout.strip("[]\n").split(",")]
    assert tensions[-1] / tensions[-2] == pytest.approx(math.exp(0.2 * 0.5 * math.pi / 0.5))
