"""Belt drives, capstans and band brakes: printed numbers, both closures, creep, what is left out, bad input."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import ropefric as rf
from ropefric.errors import DataError
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.plan import make_plan
from ropefric.scenes.scene_templates import scene_text, write_scenes
from ropefric.section import as_text
from ropefric.systems.beltdrive.drive import (
    DriveModel,
    DriveProblem,
    best_speed_m_s,
    needed_width_m,
    solve_drive,
)
from ropefric.systems.beltdrive.effects import SYSTEM
from ropefric.systems.friction import WrapFriction

RPM = 2.0 * math.pi / 60.0


def problem_of(mu, **values):
    radius_m = values.pop("radius_m", 0.15)
    fixed = {"closure": "limit", "belt_count": 1.0, "rope_radius_m": 0.005, "wheel_radius_m": radius_m}
    return DriveProblem(friction=WrapFriction.constant(mu), **(fixed | values))


def solved(problem, effects=tuple(SYSTEM.effects)):
    return solve_drive(DriveModel(problem=problem, effects=frozenset(effects)))


def test_a_rope_on_a_drum():
    """2.5 turns at 20 rpm; the printed 2.772 kW take 300 mm for the drum's diameter."""
    rope = solved(problem_of(0.25, wrap_angle_rad=5.0 * math.pi, tension_N=9000.0, speed_rad_s=20.0 * RPM))
    assert rope.full_slack_N[0] == pytest.approx(177.33, abs=0.005)
    assert rope.full_power_W[0] == pytest.approx(2772.0, abs=0.5)


def test_a_flat_belt_at_its_best_speed():
    flat = {"wrap_angle_rad": math.radians(120.0), "tension_N": 1200.0, "linear_density_kg_m": 0.6}
    best = best_speed_m_s(problem_of(0.3, **flat))
    assert best[0] == pytest.approx(25.82, abs=0.005)
    around = best / 0.15 * np.array([0.99, 1.0, 1.01])
    power_W = solved(problem_of(0.3, **flat, speed_rad_s=around)).full_power_W
    assert (power_W[1], power_W.argmax()) == (pytest.approx(9640.0, abs=5.0), 1)


def test_what_a_textbook_of_machine_design_prints_of_its_belts():
    """Examples 20-1, 20-2 and 21-1 of its companion, to the last digit that it prints."""
    flat = {"linear_density_kg_m": 1.95, "speed_rad_s": 20.0 / 0.15, "driven_radius_m": 0.45,
            "centre_distance_m": 5.8, "crossed": True}  # fmt: skip
    crossed = solved(problem_of(0.4, **flat, wrap_angle_rad=math.pi, tension_N=4167.4))
    assert crossed.model.problem.wrap_angle_rad[0] == pytest.approx(3.35, abs=0.005)
    assert crossed.full_slack_N[0] == pytest.approx(1667.4, abs=0.05)
    assert crossed.full_power_W[0] == pytest.approx(50e3, abs=5.0)
    wedge = {"wrap_angle_rad": math.pi + 2.0 * math.asin(1.0 / 3.0), "tension_N": 483.0,
             "linear_density_kg_m": 0.253, "speed_rad_s": 1500.0 * RPM}  # fmt: skip
    v_belt = solved(problem_of(0.22, **wedge))
    assert v_belt.circling_N[0] == pytest.approx(140.5, abs=0.05)
    assert v_belt.full_slack_N[0] == pytest.approx(288.2, abs=0.05)
    assert v_belt.full_power_W[0] == pytest.approx(4589.0, abs=0.5)
    sized = {"radius_m": 0.1, "rope_radius_m": 0.004, "density_kg_m3": 950.0, "linear_density_kg_m": 0.6,
             "speed_rad_s": 1500.0 * RPM, "driven_radius_m": 0.25, "centre_distance_m": 2.0,
             "stress_Pa": 2e6}  # fmt: skip
    belt = solved(problem_of(0.38, **sized, wrap_angle_rad=math.pi, tension_N=2000.0, power_W=12e3))
    assert needed_width_m(belt)[0] == pytest.approx(79.64e-3, abs=5e-6)


CLOSED = {"wrap_angle_rad": 3.0, "tension_N": 1000.0, "linear_density_kg_m": 0.5, "speed_rad_s": 100.0}


def given_N(tight_N, slack_N, closure):
    """Return what a closure keeps, whatever is carried: the mean where the length of an elastic belt does not change."""
    return {"limit": tight_N, "tensioner": slack_N, "fixed": 0.5 * (tight_N + slack_N)}[closure][0]


@pytest.mark.parametrize("closure", ["limit", "tensioner", "fixed"])
def test_every_closure_slips_by_eytelwein_keeps_what_is_given_and_uses_its_share(closure):
    full = solved(problem_of(0.3, closure=closure, **CLOSED))
    tight_N, slack_N, circling_N = full.full_tight_N[0], full.full_slack_N[0], 0.5 * 15.0**2
    assert (tight_N - circling_N) / (slack_N - circling_N) == pytest.approx(math.exp(0.9), rel=1e-12)
    assert given_N(full.full_tight_N, full.full_slack_N, closure) == pytest.approx(1000.0, rel=1e-12)
    half = solved(problem_of(0.3, closure=closure, **CLOSED, power_W=0.5 * full.full_power_W))
    assert half.pull_N == pytest.approx(0.5 * full.full_pull_N, rel=1e-12)
    assert half.utilisation[0] == pytest.approx(0.5, rel=1e-12)
    assert half.tight_N - half.slack_N == pytest.approx(half.pull_N, rel=1e-12)
    assert given_N(half.tight_N, half.slack_N, closure) == pytest.approx(1000.0, rel=1e-12)
    assert 0.0 < half.slip_arc_rad[0, 0] < 3.0
    assert full.slip_arc_rad[0, 0] == pytest.approx(3.0, rel=1e-9), "at the largest pull it slips all round"
    beyond = solved(problem_of(0.3, closure=closure, **CLOSED, power_W=1.1 * full.full_power_W))
    assert np.isnan(beyond.slip_arc_rad[0, 0])


def test_creep_against_the_belt_followed_round_the_driving_pulley():
    """Mass flow ρ/(1 + T/EA) v is the same everywhere; over the slip arc dT/dφ = -μ (T - m v2)."""
    stiff_N = 2e5
    belt = {**CLOSED, "driven_radius_m": 0.3, "driven_wrap_rad": 3.2, "axial_stiffness_N": stiff_N}
    found = solved(problem_of(0.3, **belt, power_W=4000.0))
    slip, circling_N = found.slip_arc_rad[0, 0], found.circling_N[0]
    leaves = solve_ivp(lambda _, tension_N: -0.3 * (tension_N - circling_N), (0.0, slip), found.tight_N,
                       rtol=1e-11, atol=1e-9).y[0, -1]  # fmt: skip
    assert leaves == pytest.approx(found.slack_N[0], rel=1e-9)
    ratio = (1.0 + leaves / stiff_N) / (1.0 + found.tight_N[0] / stiff_N)
    assert found.speed_ratio[0] == pytest.approx(ratio, rel=1e-12)
    assert 0.99 < ratio < 1.0
    rigid = solved(problem_of(0.3, **belt), effects=("centrifugal", "wedge"))
    assert rigid.speed_ratio[0] == 1.0


def test_the_pulley_with_the_smaller_wrap_slips_first():
    small = solved(problem_of(0.3, **CLOSED, driven_radius_m=0.05, driven_wrap_rad=2.0))
    ratio = (small.full_tight_N - small.circling_N) / (small.full_slack_N - small.circling_N)
    assert ratio[0] == pytest.approx(math.exp(0.6), rel=1e-12)
    assert small.slip_arc_rad[:, 0] == pytest.approx([2.0, 2.0], rel=1e-9)


def test_a_law_that_feels_the_tension_is_told_what_presses_on_the_slack_side():
    law = ALL_LAWS["howell"]
    friction = WrapFriction(
        law=law, theta=np.array([0.3, 0.9]), reference=one_condition(0.15, 0.005, 3.0, 500.0)
    )
    problem = DriveProblem(friction=friction, closure="limit", belt_count=1.0, rope_radius_m=0.005,
                           wheel_radius_m=0.15, wrap_angle_rad=3.0, tension_N=1000.0)  # fmt: skip
    found = solved(problem)
    exponent = friction.exponent(
        wheel_radius_m=0.15, rope_radius_m=0.005, wrap_angle_rad=3.0, slack_tension_N=found.full_slack_N,
        regressors=frozenset({"wrap", "end-tension", "size"}),
    )  # fmt: skip
    assert found.full_slack_N[0] == pytest.approx(1000.0 * np.exp(-exponent)[0], rel=1e-12)


def test_all_of_it_is_solved_because_that_is_quicker_than_to_find_out_what_matters():
    slow = problem_of(0.3, **(CLOSED | {"speed_rad_s": 1.0}))
    plan, _ = make_plan(SYSTEM, slow, accuracy=0.01, effects="auto")
    assert plan.simulated == ("centrifugal", "wrap-dependence", "size")


def scene(tmp_path, name="belt-drive", old="", new=""):
    path = tmp_path / f"{name}.toml"
    path.write_text(scene_text(name).replace(old, new, 1), encoding="utf-8")
    return path


def test_the_template_is_the_printed_drive(tmp_path):
    path = next(path for path in write_scenes(tmp_path, ["belt-drive"]) if path.suffix == ".toml")
    solution = rf.solve(path)
    tree = solution.to_dict()
    assert solution.stands
    assert tree["full_power_W"] == pytest.approx(171_690.0, abs=5.0)
    assert tree["best"]["rotation_rad_s"] / RPM == pytest.approx(2807.0, abs=0.5)
    assert tree["belts"] == 2
    assert tree["initial_tension_N"] == pytest.approx(0.5 * (tree["full_tight_N"] + tree["full_slack_N"]))
    driven = tree["pulleys"]["driven"]
    assert driven["speed_rad_s"] == pytest.approx(750.0 * RPM * tree["creep"]["speed_ratio"], rel=1e-12)
    assert tree["creep"]["power_lost_W"] == pytest.approx(
        120e3 * (1.0 - tree["creep"]["speed_ratio"]), rel=1e-9
    )
    assert driven["slip_arc_rad"] + driven["adhesion_arc_rad"] == pytest.approx(math.pi)
    json.dumps(tree, allow_nan=False)


def test_too_much_power_slips(tmp_path):
    solution = rf.solve(scene(tmp_path, old='"120 kW"', new='"200 kW"'))
    assert not solution.stands
    assert any("the belts slip" in words for words in solution.warnings)
    tree = solution.to_dict()
    assert tree["belts"] == 3
    # How fast a slipping pulley turns, creep does not say.
    assert tree["creep"] == {"speed_ratio": None, "power_lost_W": None}
    assert tree["pulleys"]["driven"]["speed_rad_s"] is None
    said = as_text(solution.scene.kind.sections(tree))
    assert "for the power asked for: T1 = 5250 N" in said
    assert "creep:" not in said
    idle = rf.solve(scene(tmp_path, old='"120 kW"', new='"0 W"')).to_dict()
    assert idle["utilisation"] == 0.0
    assert idle["at_work"]["slack_N"] == idle["at_work"]["tight_N"] == 5250.0


def test_a_band_brake_both_ways(tmp_path):
    tree = rf.solve(scene(tmp_path, "band-brake")).to_dict()["at_work"]
    grip = math.exp(0.25 * 1.5 * math.pi)
    assert tree["torque_N_m"] == pytest.approx(500.0 * (grip - 1.0) * 0.15, rel=1e-12)
    assert tree["reversed_torque_N_m"] == pytest.approx(500.0 * (1.0 - 1.0 / grip) * 0.15, rel=1e-12)


def test_a_sweep_and_a_fit(tmp_path):
    found = rf.sweep(scene(tmp_path), "driving.speed=2000rpm,2807.23rpm,3500rpm")
    assert found.columns["full_power_W"].argmax() == 1
    write_scenes(tmp_path, ["hoist"])
    tree = rf.solve(scene(tmp_path, old="mu = 0.12 ", new='fit = "fits/prth-coupled.json" #')).to_dict()
    low, high = tree["full_power_W_interval"]
    assert low < tree["full_power_W"] < high


def test_the_charts_show_power_and_arcs(tmp_path):
    from ropefric.plotting.machines import scene_figures

    figures = dict(scene_figures(rf.solve(scene(tmp_path))))
    assert set(figures) == {"belt_power", "belt_arcs"}
    rows = figures["belt_arcs"].tables[0].rows
    round_one = [tension_N for name, _, tension_N in rows if name == "driving pulley"]
    assert (round_one[0], round_one[-1]) == pytest.approx((5250.0, 5250.0 - 120e3 / 23.5619449 / 2.0))
    for figure in figures.values():
        figure.figure.canvas.draw()


FE = {"wrap_angle_rad": math.pi, "driven_radius_m": 0.1, "driven_wrap_rad": math.pi, "tension_N": 400.0,
      "span_m": math.pi / 10.0, "axial_stiffness_N": 8000.0, "closure": "fixed", "radius_m": 0.1,
      "speed_rad_s": 12.0}  # fmt: skip


def lengths_m(found, problem):
    """Return the unstretched length of the belt at work, followed round arc by arc."""
    stiff_N = np.inf if problem.axial_stiffness_N is None else problem.axial_stiffness_N[0]
    circling_N, total = found.circling_N[0], 0.0
    ends = found.tight_N[0], found.slack_N[0]
    for (radius_m, wrap), slips, arrives, grows in zip(
        problem.pulleys, found.slip_arc_rad[:, 0], ends, (-1.0, 1.0), strict=True
    ):
        mu = found.coefficients[0, 0]
        angle = np.linspace(0.0, slips, 20001)
        tension_N = circling_N + (arrives - circling_N) * np.exp(grows * mu * angle)
        total += radius_m * (np.trapezoid(1.0 / (1.0 + tension_N / stiff_N), angle)
                             + (wrap - slips) / (1.0 + arrives / stiff_N))  # fmt: skip
    return total + problem.span_m[0] * sum(1.0 / (1.0 + one / stiff_N) for one in ends)


def test_fixed_centres_against_a_finite_element_belt():
    """Load 25 + 2 ω2 N m; the finite elements have 665.87 and 187.38 N, the length kept 663.2 and 186.4 N, 2.538 rad."""
    pull_N = 476.8
    for _ in range(20):
        problem = problem_of(0.5, **FE, power_W=pull_N * 1.2)
        found = solved(problem)
        pull_N = (25.0 + 2.0 * 12.0 * found.speed_ratio[0]) / 0.1
    assert found.tight_N[0] == pytest.approx(663.2, abs=0.05)
    assert found.slack_N[0] == pytest.approx(186.4, abs=0.05)
    assert found.slip_arc_rad[0, 0] == pytest.approx(2.538, abs=5e-4)
    assert found.tight_N[0] == pytest.approx(665.87, rel=0.006)
    assert found.slack_N[0] == pytest.approx(187.38, rel=0.006)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("stiff_N", [2e3, 8e3, 1e6])
def test_a_belt_between_fixed_centres_keeps_its_unstretched_length(share, stiff_N):
    belt = FE | {"axial_stiffness_N": stiff_N, "linear_density_kg_m": 30.0, "driven_radius_m": 0.16}
    full = solved(problem_of(0.5, **belt))
    problem = problem_of(0.5, **belt, power_W=share * full.full_power_W)
    found = solved(problem)
    at_rest = problem.belt_length_m[0] / (1.0 + 400.0 / stiff_N)
    assert lengths_m(found, problem) == pytest.approx(at_rest, rel=3e-9)
    assert found.tight_N - found.slack_N == pytest.approx(found.pull_N, abs=1e-9)
    if share == 1.0:
        assert found.tight_N == pytest.approx(full.full_tight_N, rel=1e-11)


def test_a_belt_that_hardly_stretches_keeps_the_mean_of_its_tension_along_its_length():
    belt = {name: one for name, one in FE.items() if name != "axial_stiffness_N"}
    limp, stiff = solved(problem_of(0.5, **belt)), solved(problem_of(0.5, **FE | {"axial_stiffness_N": 1e12}))
    assert limp.full_tight_N == pytest.approx(stiff.full_tight_N, rel=1e-8)
    long = solved(problem_of(0.5, **belt | {"span_m": 1e6}))
    assert long.full_tight_N + long.full_slack_N == pytest.approx(800.0, rel=1e-5)


def geometry(driving, driven, **more):
    return {"system": "beltdrive", "driving": {"diameter": driving}, "driven": {"diameter": driven},
            "belt": {"thickness": "5 mm", **more}, "tension": {"closure": "limit", "force": "1 kN"},
            "friction": {"mu": 0.25}}  # fmt: skip


def test_the_length_of_an_open_belt(scene_of):
    """sarthaks.com 509872: open belt of pulleys of 1600 and 500 mm, 12 m apart."""
    found = rf.solve(scene_of(**geometry("1600 mm", "500 mm", centre_distance="12 m"))).to_dict()
    assert found["belt_length_m"] == pytest.approx(27.32, abs=0.0055)


@pytest.mark.parametrize("crossed", [True, False])
def test_wraps_and_belt_length_follow_from_where_the_belt_touches_its_pulleys(scene_of, crossed):
    """The span is a tangent of both circles, so it is square to the radii at both its ends."""
    R, r, apart = 0.225, 0.1, 1.95
    tree = geometry("450 mm", "200 mm", centre_distance="1.95 m", crossed=crossed)
    tree["driving"]["speed"] = "200 rpm"
    found = rf.solve(scene_of(**tree)).to_dict()
    side = -1.0 if crossed else 1.0

    def ends(angle):
        outward = np.array([math.cos(angle), math.sin(angle)])
        return R * outward, np.array([apart, 0.0]) + side * r * outward, outward

    def off_square(angle):
        start, end, outward = ends(angle)
        return (end - start) @ outward

    angle = brentq(off_square, 0.5, 2.0)
    start, end, _ = ends(angle)
    span, wraps = (
        math.dist(start, end),
        (2.0 * (math.pi - angle), 2.0 * (math.pi - angle if crossed else angle)),
    )
    assert found["span_m"] == pytest.approx(span, rel=1e-12)
    assert found["belt_length_m"] == pytest.approx(2.0 * span + R * wraps[0] + r * wraps[1], rel=1e-12)
    for name, wrap in zip(("driving", "driven"), wraps, strict=True):
        assert found["pulleys"][name]["wrap_angle_rad"] == pytest.approx(wrap, rel=1e-12)
    slack_N = 1000.0 / pieces_of_band(0.25, min(wraps))
    assert found["full_power_W"] == pytest.approx((1000.0 - slack_N) * R * 200.0 * math.pi / 30.0, rel=1e-8)


def pieces_of_band(mu, wrap_rad, n=20_000):
    """Return the ratio of the end tensions of a band cut in small pieces, each in balance with the friction under it."""
    half = 0.5 * mu * wrap_rad / n
    return ((1.0 + half) / (1.0 - half)) ** n


def test_a_wrap_beside_a_centre_distance_is_one_too_many(scene_of):
    for table, key, value, said in (
        ("driving", "wrap", "180 deg", r"driving\.wrap and belt\.centre_distance are both given"),
        ("belt", "span_length", "1 m", r"centre_distance and belt\.span_length are both given"),
        ("belt", "centre_distance", "0.3 m", "lets the pulleys touch"),
    ):
        tree = geometry(driving="450 mm", driven="200 mm", centre_distance="1.95 m")
        tree[table][key] = value
        with pytest.raises(DataError, match=said):
            scene_of(**tree)


@pytest.mark.parametrize("mu", [1e-11, 1e-14, 1e-300, 0.0])
@pytest.mark.parametrize("closure", ["limit", "tensioner", "fixed"])
def test_the_pull_at_almost_no_friction_keeps_its_digits(mu, closure):
    """A difference of two tensions is off by 2e-6 at 1e-11: the pull is T (1 - e^-M)."""
    found = solved(problem_of(mu, **CLOSED | {"closure": closure, "linear_density_kg_m": 0.0}))
    assert found.full_pull_N[0] == pytest.approx(1000.0 * mu * 3.0, rel=1e-10)
    assert found.utilisation[0] == (1.0 if mu else 0.0)


@pytest.mark.parametrize("closure", ["limit", "fixed"])
def test_without_friction_or_at_rest_a_drive_has_an_answer(scene_of, closure):
    tree = geometry(driving="300 mm", driven="200 mm", centre_distance="1 m")
    tree |= {"friction": {"mu": 0}, "load": {"power": "1 kW"}}
    tree["driving"]["speed"], tree["tension"]["closure"] = "600 rpm", closure
    slips = rf.solve(scene_of(**tree)).to_dict()
    assert slips["full_pull_N"] == 0.0
    assert slips["failures"]
    still = geometry(driving="300 mm", driven="200 mm", centre_distance="1 m")
    still["driving"]["speed"] = "0 rpm"
    found = rf.solve(scene_of(**still)).to_dict()
    assert (found["full_power_W"], found["belt_speed_m_s"]) == (0.0, 0.0)
    assert found["full_pull_N"] > 0.0
    with pytest.raises(DataError, match="carries no power"):
        rf.solve(scene_of(**still | {"load": {"power": "1 W"}}))


def test_a_belt_strained_by_more_than_a_tenth_is_said(scene_of):
    tree = geometry(driving="300 mm", driven="200 mm", centre_distance="1 m", axial_stiffness="2 kN")
    strained = rf.solve(scene_of(**tree)).to_dict()
    assert any("strained by more than 10 %" in one for one in strained["failures"])
    tree["belt"]["axial_stiffness"] = "20 kN"
    assert not rf.solve(scene_of(**tree)).to_dict()["failures"]


def test_no_arc_of_adhesion_is_below_zero():
    assert all(
        solved(problem_of(mu, **CLOSED)).slip_arc_rad[0, 0] <= 3.0 for mu in np.linspace(0.01, 1.0, 25)
    )


def brake(diameter, wrap, mu, effort="500 N", **more):
    return {"system": "beltdrive", "driving": {"diameter": diameter, "wrap": wrap}, "belt": {"thickness": "5 mm"},
            "tension": {"closure": "lever", "force": effort}, "friction": {"mu": mu}, "brake": more}  # fmt: skip


def test_a_simple_band_brake(scene_of):
    """mechdiploma.com: lever 40 cm, pin at 8 cm, 500 N, 5/8 of a drum of 40 cm at 0.25; e^(μθ) is printed as 2.67."""
    found = rf.solve(scene_of(**brake("40 cm", "225 deg", 0.25, lever="40 cm", tight_arm="8 cm"))).to_dict()
    assert found["at_work"]["tight_N"] == pytest.approx(2500.0, rel=1e-13)
    assert found["at_work"]["slack_N"] == pytest.approx(936.3, abs=0.5)
    assert found["brake"]["torque_N_m"] == pytest.approx(312.74, abs=0.1)


def test_a_simple_band_brake_that_holds_a_torque(scene_of):
    """transtutors.com, brake drum friction: 300 N m, 240 deg, 0.25; its numbers are those of a radius of 250 mm."""
    tree = brake("500 mm", "240 deg", 0.25, lever="300 mm", tight_arm="50 mm", torque="300 N*m")
    found = rf.solve(scene_of(**tree)).to_dict()["brake"]
    assert found["needed_effort_N"] == pytest.approx(308.13, abs=0.05)
    tree["tension"]["force"] = f"{found['needed_effort_N']!r} N"
    again = rf.solve(scene_of(**tree)).to_dict()
    assert again["brake"]["torque_N_m"] == pytest.approx(300.0, rel=1e-12)
    assert again["at_work"]["slack_N"] == pytest.approx(648.77, abs=0.05)
    assert again["at_work"]["tight_N"] == pytest.approx(1848.80, abs=0.05)


def test_a_band_brake_of_a_given_tight_side():
    """interviewmania.com, machine design: 400 N on the tight side, 0.5 m, 180 deg, 0.25: 182.375 N and 54.4 N m."""
    found = solved(problem_of(0.25, wrap_angle_rad=math.pi, tension_N=400.0, radius_m=0.25))
    assert found.full_slack_N[0] == pytest.approx(182.375, abs=0.02)
    assert found.full_pull_N[0] * 0.25 == pytest.approx(54.4, abs=0.05)


@pytest.mark.parametrize(
    ("tight", "slack"), [(80.0, 0.0), (0.0, 150.0), (-35.0, 150.0), (35.0, 150.0), (150.0, -20.0)]
)
def test_the_moments_about_the_fulcrum_of_a_lever_are_in_balance(scene_of, tight, slack):
    """Simple and differential brakes: effort and band ends, both ways round, from a band cut in pieces."""
    mu, wrap, radius, lever, torque = 0.3, math.radians(225.0), 0.175, 0.5, 350.0
    slack_N = torque / radius / (pieces_of_band(mu, wrap) - 1.0)
    tight_N = slack_N + torque / radius

    def effort_N(on_tight_m, on_slack_m):
        return (tight_N * on_tight_m + slack_N * on_slack_m) / lever

    tree = brake("350 mm", "225 deg", mu, lever="500 mm", tight_arm=f"{tight} mm", slack_arm=f"{slack} mm",
                 torque="350 N*m")  # fmt: skip
    wanted = effort_N(1e-3 * tight, 1e-3 * slack), effort_N(1e-3 * slack, 1e-3 * tight)
    found = rf.solve(scene_of(**tree)).to_dict()["brake"]
    assert found["needed_effort_N"] == pytest.approx(wanted[0], rel=1e-7)
    assert found["reversed_effort_N"] == pytest.approx(wanted[1], rel=1e-7)
    # With that effort it brakes with that torque.
    tree["tension"]["force"] = f"{found['needed_effort_N']!r} N"
    again = rf.solve(scene_of(**tree)).to_dict()
    assert again["brake"]["torque_N_m"] == pytest.approx(torque, rel=1e-12)
    assert again["at_work"]["tight_N"] == pytest.approx(tight_N, rel=1e-7)


def test_a_differential_brake_locks_by_itself(scene_of):
    """Where the tight end pulls the lever on by more than the slack end holds it: T1 a1 > T2 a2."""
    slack_mm, ratio = 150.0, pieces_of_band(0.3, math.radians(225.0))
    arms = {"lever": "500 mm", "slack_arm": f"{slack_mm} mm", "torque": "350 N*m"}
    holds, locks = (brake("350 mm", "225 deg", 0.3, **arms, tight_arm=f"{-share * slack_mm / ratio} mm")
                    for share in (0.99, 1.01))  # fmt: skip
    assert rf.solve(scene_of(**holds)).to_dict()["brake"]["needed_effort_N"] > 0.0
    with pytest.raises(DataError, match="locks by itself"):
        rf.solve(scene_of(**locks))
    turned = locks | {"brake": arms | {"tight_arm": "150 mm", "slack_arm": f"{-1.01 * slack_mm / ratio} mm"}}
    back = rf.solve(scene_of(**turned)).to_dict()["brake"]
    assert back["reversed_torque_N_m"] is None
    assert back["reversed_effort_N"] < 0.0


def test_the_width_that_a_stress_needs(scene_of):
    """GATE Agricultural Engineering 2018: 80 mm of 5 mm, 5 kW at 1500 rpm of 200 mm, 168 deg: 1.70 to 1.80 MPa."""
    tree = {"system": "beltdrive", "driving": {"diameter": "200 mm", "wrap": "168 deg", "speed": "1500 rpm"},
            "belt": {"thickness": "5 mm", "stress": "1.75 MPa"}, "friction": {"mu": 0.2},
            "tension": {"closure": "limit", "force": "5 kN"}, "load": {"power": "5 kW"}}  # fmt: skip
    assert rf.solve(scene_of(**tree)).to_dict()["needed_width_m"] == pytest.approx(0.080, abs=0.0024)


def test_the_stress_of_the_width_is_the_one_allowed(scene_of):
    """A belt of that width and mass, pulled with σ b h, just carries the power."""
    tree = {"system": "beltdrive", "driving": {"diameter": "0.3 m", "wrap": "160 deg", "speed": "1400 rpm"},
            "belt": {"thickness": "6 mm", "stress": "2 MPa", "density": "970 kg/m^3"}, "friction": {"mu": 0.3},
            "tension": {"closure": "limit", "force": "5 kN"}, "load": {"power": "10 kW"}}  # fmt: skip
    width = rf.solve(scene_of(**tree)).to_dict()["needed_width_m"]
    tree["belt"] = {"thickness": "6 mm", "linear_density": f"{970.0 * width * 0.006!r} kg/m"}
    tree["tension"]["force"] = f"{2e6 * width * 0.006!r} N"
    assert rf.solve(scene_of(**tree)).to_dict()["utilisation"] == pytest.approx(1.0, rel=1e-12)
