"""Start-ups near what decides: the planned one tells of the same slips, at the same moments, with the same tensions.

Presses of one belt are drawn from slack to stiff, with short ramps, kinks and starts at full speed, of every law, and
half of them with a coefficient at which a roller just slips.
"""

import numpy as np
import pytest
from test_every_number import friction, near_one, with_unit

from ropefric.errors import RopefricError
from ropefric.scenes.plan import solve_planned
from ropefric.systems.press.answer import settles
from ropefric.systems.press.transient.start_up import largest_difference


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


def press(rng):
    """Return a press of a driver, one to three loaded rollers and a take-up."""
    force_N, speed_m_s = log_uniform(rng, 50, 3000), log_uniform(rng, 0.1, 10.0)

    def inertia():
        return with_unit(log_uniform(rng, 0.03, 5.0), "kg*m^2")

    rollers = {
        "drive": {
            "radius": "100 mm", "wrap": with_unit(rng.uniform(1.5, 3.6), "rad"), "role": "driver", "inertia": inertia()
        }
    }  # fmt: skip
    for place in range(int(rng.integers(1, 4))):
        radius_m = rng.uniform(0.05, 0.2)
        pull_N = force_N * float(rng.choice([0.0, rng.uniform(0.0, 0.6), 10.0 ** rng.uniform(-3, 0)]))
        rollers[f"load{place}"] = {
            "radius": with_unit(radius_m, "m"), "wrap": with_unit(rng.uniform(0.3, 3.6), "rad"),
            "inertia": inertia(), "squeeze_torque": with_unit(pull_N * radius_m, "N*m"),
        }  # fmt: skip
    rollers["take"] = {
        "radius": "80 mm", "wrap": with_unit(rng.uniform(1.5, 3.4), "rad"), "role": "tensioner", "inertia": inertia(),
        "tensioner": {
            "spring": with_unit(log_uniform(rng, 30, 1e5), "N/m"), "mass": with_unit(log_uniform(rng, 1, 160), "kg"),
            "damping": with_unit(log_uniform(rng, 1, 5e3), "N*s/m"),
        },
    }  # fmt: skip
    return {
        "system": "press",
        "press": {"speed": with_unit(speed_m_s, "m/s"), "preload": with_unit(force_N, "N"), "closure": "share"},
        "rollers": rollers,
        "belts": {
            "belt": {
                "loop": list(rollers), "width": "1 m", "thickness": "5 mm",
                "linear_density": with_unit(log_uniform(rng, 0.1, 20), "kg/m"),
                "axial_stiffness": with_unit(log_uniform(rng, 30, 1e5), "kN"),
                "damping": with_unit(log_uniform(rng, 1e-5, 0.05), "s"),
                "span_lengths": [with_unit(rng.uniform(0.3, 2.0), "m") for _ in rollers],
            }
        },
        "friction": friction(rng),
        "start_up": drive(rng, speed_m_s),
    }  # fmt: skip


def solved(scene_of, tree, effects, accuracy=0.02):
    scene = scene_of(**tree | {"accuracy": accuracy, "effects": effects})
    return solve_planned(scene, scene.problem)


def just_slipping(rng, scene_of, tree):
    """Return the press with a coefficient at which one roller more, or one less, just slips."""
    low, high = 0.02, 3.0

    def count(mu):
        told = solved(scene_of, tree | {"friction": {"mu": mu}}, "auto")[1].start_up.summary()
        return len(told["first_slip_s"])

    wanted = int(rng.integers(0, max(1, count(low))))
    for _ in range(20):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if count(middle) > wanted else (low, middle)
    return tree | {"friction": {"mu": high * near_one(rng)}}


def check(scene_of, seed):
    """Return whether a drawn press has a start-up with all effects, after that was compared with the planned one."""
    rng = np.random.default_rng([20, seed])
    tree = press(rng)
    try:
        if seed % 2:
            tree = just_slipping(rng, scene_of, tree)
        whole = solved(scene_of, tree, "all")[1]
    except RopefricError:
        return False
    plan, planned = solved(scene_of, tree, "auto")
    assert plan.keeps_accuracy
    assert largest_difference(planned.start_up, whole.start_up) <= plan.error_bound
    peaks_N = whole.start_up.tension_N.max(axis=0)
    apart_N = np.abs(planned.start_up.tension_N - whole.start_up.tension_N).max(axis=0)
    assert (apart_N / peaks_N).max() <= plan.error_bound
    assert settles(planned)["steady"] == settles(whole)["steady"]
    found, wanted = (one.start_up.summary()["first_slip_s"] for one in (planned, whole))
    later = np.diff([wanted[name] for name in found])
    assert (later >= -1e-9).all(), "rollers slip in the same order"
    return True


@pytest.mark.parametrize("seed", [0, 3, 4, 5, 8, 11])
def test_planned_start_ups_near_what_decides(scene_of, seed):
    assert check(scene_of, seed)


@pytest.mark.slow
def test_three_hundred_planned_start_ups_near_what_decides(scene_of):
    assert sum(check(scene_of, seed) for seed in range(300)) > 250
