"""Every number, every yes or no of a planned answer is that of all effects, within the accuracy asked for.

What is quick is solved whole: what is left are saws, drawn wide and near what decides, the critical speed or a
resonance, and start-ups of one belt from slack to stiff, with short ramps, kinks and starts at full speed, half of them
with a coefficient at which a roller just slips.
"""

import math
import tomllib

import numpy as np
import pytest

from ropefric.errors import RopefricError
from ropefric.scenes.explain import explain_scene
from ropefric.scenes.plan import solve_planned
from ropefric.scenes.scene_templates import bundled_scenes
from ropefric.scenes.solve import solve_scene
from ropefric.systems.press.answer import settles
from ropefric.systems.press.transient.start_up import largest_difference

FITS = ("constant", "size-exponential", "wrap-power", "coupled", "howell")
ABOUT_THE_PLAN = {"effects", "error_bound", "method", "accuracy"}


def near_one(rng):
    """A factor near 1, from a millionth to a tenth away, on either side."""
    return 1.0 + float(rng.choice([-1.0, 1.0])) * 10.0 ** rng.uniform(-6.0, -1.0)


def with_unit(value, unit):
    return f"{value:.9g} {unit}"


def friction(rng):
    return {"fit": f"../../fits/prth-{rng.choice(FITS)}.json"}


def saw(rng, scene_of):
    tree = tomllib.loads(
        bundled_scenes()[str(rng.choice(["band-saw", "fast-band-saw", "band-saw-fixed-axles"]))]
    )
    length, preload, rho = rng.uniform(0.3, 3.0), rng.uniform(500, 2e4), rng.uniform(0.05, 2.0)
    gap = 10.0 ** rng.uniform(-3.0, 0.0)
    speed = (1.0 - gap) * math.sqrt(preload / rho)
    stiffness = 10.0 ** rng.uniform(-8.0, -1.0) * preload * length**2
    tree["blade"] = {"free_span": with_unit(length, "m"), "linear_density": with_unit(rho, "kg/m"),
                     "bending_stiffness": with_unit(stiffness, "N*m^2"), "modes": int(rng.integers(1, 7)),
                     "ends": str(rng.choice(["clamped", "pinned"]))}  # fmt: skip
    tree["tension"] = {"preload": with_unit(preload, "N"),
                       "mounting_factor": float(rng.choice([0.0, 1.0, rng.uniform()]))}  # fmt: skip
    tree["wheel"] = {"radius": "0.35 m", "speed": with_unit(speed / 0.35, "rad/s")}
    tree["drive"] = {"tension_difference": with_unit(rng.uniform(0, 0.2) * preload * gap, "N")}
    tree.pop("excitation", None)
    if rng.random() < 0.15:
        tree["effects"] = "all"
        first_Hz = solve_scene(scene_of(**tree)).to_dict()["slack"]["frequencies_Hz"][0]
        tree["excitation"] = {
            "wheel_harmonics": 2, "frequencies": [with_unit(first_Hz * near_one(rng), "Hz")], "margin": 0.1,
            "preload_range": [with_unit(0.9 * preload, "N"), with_unit(1.5 * preload, "N")]
        }  # fmt: skip
    return tree


def leaves(tree, path=""):
    """Every number, word, yes and no of an answer, by its place."""
    if isinstance(tree, dict):
        return {k: v for name, one in tree.items() for k, v in leaves(one, f"{path}.{name}").items()}
    if isinstance(tree, list):
        return {k: v for place, one in enumerate(tree) for k, v in leaves(one, f"{path}.{place}").items()}
    return {path: tree}


def check(scene_of, tree, accuracy):
    """Return whether something was left out, after both answers were compared leaf by leaf."""
    found = []
    for effects in ("auto", "all"):
        solution = solve_scene(scene_of(**tree | {"accuracy": accuracy, "effects": effects}))
        told = {key: one for key, one in solution.to_dict().items() if key not in ABOUT_THE_PLAN}
        found.append((leaves(told), solution.plan))
    (planned, plan), (whole, _) = found
    assert plan.keeps_accuracy
    assert planned.keys() == whole.keys()
    for place, wanted in whole.items():
        value = planned[place]
        if isinstance(wanted, float) and isinstance(value, float):
            assert abs(value - wanted) <= accuracy * abs(wanted) + 1e-300, place
        else:
            assert value == wanted, place
    return bool(plan.left_out)


def check_many(draw, scene_of, count, seed):
    """Return how many scenes had an answer, and in how many something was left out."""
    solved = spared = 0
    for one in range(count):
        rng = np.random.default_rng([seed, one])
        try:
            tree = draw(rng, scene_of)
            solve_scene(scene_of(**tree | {"accuracy": 0.1, "effects": "all"}))
        except RopefricError:
            continue
        spared += check(scene_of, tree, float(rng.choice([0.1, 0.05, 0.01, 0.001])))
        solved += 1
    return solved, spared


def test_every_number_of_some_saws(scene_of):
    solved, spared = check_many(saw, scene_of, 6, 20)
    assert solved >= 3
    assert spared


@pytest.mark.release
def test_every_number_of_many_saws(scene_of):
    solved, spared = check_many(saw, scene_of, 200, 21)
    assert solved > 90
    assert spared


def log_uniform(rng, low, high):
    return float(10.0 ** rng.uniform(np.log10(low), np.log10(high)))


def drive(rng, speed_m_s):
    """Return a `[start_up]` with a law of the drive."""
    law = str(rng.choice(["ramp", "s-curve", "constant", "table"], p=[0.35, 0.35, 0.1, 0.2]))
    rise_s = log_uniform(rng, 0.02, 3.0)
    table = {"law": law, "loads": str(rng.choice(["with-speed", "constant"]))}
    if law in {"ramp", "s-curve"}:
        table["duration"] = with_unit(rise_s, "s")
    if law == "table":
        times_s = [0.0, *np.sort(rng.uniform(0.05 * rise_s, rise_s, 3))]
        table["times"] = [with_unit(one, "s") for one in times_s]
        table["speeds"] = [
            with_unit(one, "m/s") for one in speed_m_s * np.array([0.0, *rng.uniform(0, 1.3, 3)])
        ]
    long_s = rise_s * rng.uniform(0.8, 2.0) + log_uniform(rng, 0.1, 1.0)
    return table | {"simulate": with_unit(long_s, "s"), "points": int(rng.choice([41, 201]))}


def starting_press(rng):
    """Return a press of a driver, one to three loaded rollers and a take-up."""
    force_N, speed_m_s = log_uniform(rng, 50, 3000), log_uniform(rng, 0.1, 10.0)

    def inertia():
        return with_unit(log_uniform(rng, 0.03, 5.0), "kg*m^2")

    rollers = {"drive": {"radius": "100 mm", "wrap": with_unit(rng.uniform(1.5, 3.6), "rad"),
                         "role": "driver", "inertia": inertia()}}  # fmt: skip
    for place in range(int(rng.integers(1, 4))):
        radius_m = rng.uniform(0.05, 0.2)
        pull_N = force_N * float(rng.choice([0.0, rng.uniform(0.0, 0.6), 10.0 ** rng.uniform(-3, 0)]))
        rollers[f"load{place}"] = {
            "radius": with_unit(radius_m, "m"), "wrap": with_unit(rng.uniform(0.3, 3.6), "rad"),
            "inertia": inertia(), "squeeze_torque": with_unit(pull_N * radius_m, "N*m"),
        }  # fmt: skip
    rollers["take"] = {"radius": "80 mm", "wrap": with_unit(rng.uniform(1.5, 3.4), "rad"),
                       "role": "tensioner", "inertia": inertia(),
                       "tensioner": {"spring": with_unit(log_uniform(rng, 30, 1e5), "N/m"),
                                     "mass": with_unit(log_uniform(rng, 1, 160), "kg"),
                                     "damping": with_unit(log_uniform(rng, 1, 5e3), "N*s/m")}}  # fmt: skip
    return {"system": "press",
            "press": {"speed": with_unit(speed_m_s, "m/s"), "preload": with_unit(force_N, "N"),
                      "closure": "share"},
            "rollers": rollers,
            "belts": {"belt": {"loop": list(rollers), "width": "1 m", "thickness": "5 mm",
                               "linear_density": with_unit(log_uniform(rng, 0.1, 20), "kg/m"),
                               "axial_stiffness": with_unit(log_uniform(rng, 30, 1e5), "kN"),
                               "damping": with_unit(log_uniform(rng, 1e-5, 0.05), "s"),
                               "span_lengths": [with_unit(rng.uniform(0.3, 2.0), "m") for _ in rollers]}},
            "friction": friction(rng), "start_up": drive(rng, speed_m_s)}  # fmt: skip


def plan_and_answer(scene_of, tree, effects, accuracy=0.02):
    scene = scene_of(**tree | {"accuracy": accuracy, "effects": effects})
    return solve_planned(scene, scene.problem)


def just_slipping(rng, scene_of, tree):
    """Return the press with a coefficient at which one roller more, or one less, just slips."""
    low, high = 0.02, 3.0

    def count(mu):
        told = plan_and_answer(scene_of, tree | {"friction": {"mu": mu}}, "auto")[1].start_up.summary()
        return len(told["first_slip_s"])

    wanted = int(rng.integers(0, max(1, count(low))))
    for _ in range(20):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if count(middle) > wanted else (low, middle)
    return tree | {"friction": {"mu": high * near_one(rng)}}


def check_start_up(scene_of, seed):
    """Return whether a drawn press has a start-up with all effects, after that was compared with the planned one."""
    rng = np.random.default_rng([20, seed])
    tree = starting_press(rng)
    try:
        if seed % 2:
            tree = just_slipping(rng, scene_of, tree)
        whole = plan_and_answer(scene_of, tree, "all")[1]
    except RopefricError:
        return False
    plan, planned = plan_and_answer(scene_of, tree, "auto")
    assert plan.keeps_accuracy
    assert largest_difference(planned.start_up, whole.start_up) <= plan.error_bound
    peaks_N = whole.start_up.tension_N.max(axis=0)
    apart_N = np.abs(planned.start_up.tension_N - whole.start_up.tension_N).max(axis=0)
    assert (apart_N <= plan.error_bound * peaks_N).all()
    assert settles(planned)["steady"] == settles(whole)["steady"]
    found, wanted = (one.start_up.summary()["first_slip_s"] for one in (planned, whole))
    later = np.diff([wanted[name] for name in found])
    assert (later >= -1e-9).all(), "rollers slip in the same order"
    return True


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 3, 4, 8, 11))]
)
def test_planned_start_ups_near_what_decides(scene_of, seed):
    assert check_start_up(scene_of, seed)


def test_of_a_start_up_nothing_is_left_out(scene_of):
    tree = starting_press(np.random.default_rng([20, 0]))
    tree["start_up"] = {"law": "ramp", "duration": "0.1 s", "simulate": "0.15 s", "points": 16}
    told = explain_scene(scene_of(**tree | {"friction": {"mu": 0.05}, "accuracy": 0.02})).plan.decisions
    assert not [one.name for one in told if one.fate == "left out"]
    named = {one.name: one for one in told}
    assert math.isnan(named["arc-inertia"].worth), "a belt without mass has no answer where it slips"
    assert named["transient-friction"].worth == 0.0
