"""What the three papers print, where no test of a room checks it: the bundled scenes are their machines, item by item.

Their tables and the tensions, slip factors and example series are checked beside what computes them. The notebooks show
all of it.
"""

import math
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ropefric as rf

ROOT = Path(__file__).parents[2]
PUBLISHED, SCENES = ROOT / "data" / "published", ROOT / "data" / "scenes"


def published(name):
    return pd.read_csv(PUBLISHED / name).set_index("quantity")["value"]


def written(name):
    return tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))


def number(text):
    return float(text.split()[0])


def agrees(value, printed):
    """Whether a number is the printed one to its last digit."""
    return abs(value - float(printed)) <= 0.5 * 10.0 ** -len(printed.partition(".")[2]) + 1e-9


# The rope on a wheel.


def test_what_another_F_0_makes_of_a_lift_force():
    """(15), (17), F_B = 20 N over 10 rad: with forces counted in F_0 = 10 N, ln F_A is 4.8418, not 4.4507."""
    theta = {"a": 0.2, "b": -0.5, "c": 0.1}
    wrap_rad = np.linspace(1.0, 10.0, 12)
    at = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": wrap_rad}
    trials = pd.DataFrame(at | {"end_tension_N": 20.0, "peak_N": 20.0 * np.exp(0.2 * wrap_rad)})
    fit = rf.fit(trials, "wrap-power", fixed=theta)
    for F_0, printed in ((1.0, "4.4507"), (10.0, "4.8418")):
        end = {"wheel_radius_m": 0.04, "wrap_angle_rad": 10.0, "end_tension_N": 20.0 / F_0}
        assert agrees(math.log(rf.predict(fit, **end).lift_force_N[0] * F_0), printed), F_0


def test_the_exponential_law_of_size_is_the_better_one_and_on_one_wheel_16_is_15():
    trials = pd.read_csv(ROOT / "fits" / "prth-trials.csv", low_memory=False)
    kept = trials[trials["kept"]]
    is_series = np.isclose(kept["wrap_angle_rad"], 3.0 * math.pi) & np.isclose(kept["end_tension_N"], 60.0)
    power, exponential = (
        rf.fit(kept[is_series], law).statistics.aicc for law in ("size-power", "size-exponential")
    )
    assert exponential < power

    coupled = (0.46, -0.22, -0.3, -0.48, 0.055)
    mu_R = coupled[0] * -math.expm1(coupled[1] * 0.03 / 0.005 + coupled[2])
    wrap_rad, end_N = (one.ravel() for one in np.meshgrid([1.5, 3.0, 6.0, 12.0, 19.0], [10.0, 60.0, 200.0]))
    a, b, c = mu_R / (1.0 + coupled[3]), 1.0 + coupled[3], coupled[4]
    # ∫μ from 0 is aφ^b + cφ; F_B is the wrap φ0 over which it is ln(F_B/F_0).
    many = np.linspace(0.0, 80.0, 800001)
    start_rad = np.interp(np.log(end_N), a * many**b + c * many, many)
    peak_N = np.exp(a * (start_rad + wrap_rad) ** b + c * (start_rad + wrap_rad))
    at = {"wheel_radius_m": 0.03, "rope_radius_m": 0.005, "wrap_angle_rad": wrap_rad}
    fit = rf.fit(pd.DataFrame(at | {"end_tension_N": end_N, "peak_N": peak_N}), "wrap-power")
    assert [one.value for one in fit.parameters] == pytest.approx([mu_R, *coupled[3:]], rel=1e-4)


# The belt press.


def test_the_scene_is_the_press_of_the_paper():
    scene, machine = written("belt-press"), published("belt_press_machine.csv")
    table = pd.read_csv(PUBLISHED / "belt_press_rollers.csv", dtype={"roller": str}).set_index("roller")
    keys = ("radius", "wrap", "gravity_torque", "squeeze_torque")
    found = {name: [number(one.get(key, "nan")) for key in keys] for name, one in scene["rollers"].items()}
    np.testing.assert_array_equal([found[name] for name in table.index], table.to_numpy())
    assert len(found) == len(table)
    for belt in scene["belts"].values():
        data = [number(belt[key]) for key in ("density", "width", "thickness")]
        assert data == machine[["belt_density", "belt_width", "belt_thickness"]].tolist()
    ends = (("3", "up", "downstream_angle", "beta"), ("13", "down", "upstream_angle", "gamma"))
    for name, way, key, angle in ends:
        at = scene["rollers"][name]["tensioner"]
        wanted = machine[["tensioner_stiffness", f"tensioner_travel_{way}", angle]].tolist()
        assert [number(at[one]) for one in ("spring", "travel", key)] == wanted
        assert number(scene["press"]["preload"]) == machine[f"tensioner_force_{way}"]
    assert number(scene["press"]["rotation"]) == machine["driver_speed"]
    assert scene["friction"]["mu"] == machine["mu"]


def test_what_the_paper_says_of_the_tensions_in_figure_4_and_of_figure_7():
    press = rf.load_scene(SCENES / "belt-press.toml")
    rest = rf.solve(press).to_dict()["tension_N"]
    cos = np.cos(np.radians(published("belt_press_machine.csv")[["beta", "gamma"]])).to_numpy()
    pulls_N = np.array([rest["2"] + rest["3"] * cos[0], rest["14"] + rest["13"] * cos[1]])
    assert [agrees(x_mm, "30") for x_mm in (pulls_N - 2000.0) / 20.0] == [True, True]  # k1 x, (33), (34)
    grid = rf.sweep(press, "press.preload=1500N,2500N,4000N", "press.rotation=0rpm:100rpm:5")
    steady = {
        name: grid.columns[f"effective_tension_N.{name}"].reshape(grid.shape)
        for name in map(str, range(1, 15))
    }
    both = ("5", "6", "7", "8")
    others = max(one[0].max() for name, one in steady.items() if name not in both)
    assert min(steady[name][0].min() for name in both) > others
    np.testing.assert_allclose(steady["3"], steady["4"], rtol=1e-12)
    np.testing.assert_allclose([steady["11"], steady["12"]], [steady["13"]] * 2, rtol=1e-12)
    for roller in ("2", "5"):  # the preload matters more than the speed
        factor = grid.columns[f"slip.{roller}.as_plotted"].reshape(grid.shape)
        assert np.ptp(factor, axis=1).max() < np.ptp(factor, axis=0).min(), roller


# The band saw.


def test_the_saws_numbers_outside_its_tables():
    """A remark says why a number is not the printed one; without one it agrees to the last digit."""
    machine, scene = published("band_saw_machine.csv"), written("band-saw")
    at = (scene["blade"]["free_span"], scene["wheel"]["diameter"], scene["wheel"]["speed"])
    at += (scene["tension"]["preload"], scene["drive"]["power"])
    wanted = machine[["free_span", "wheel_diameter", "wheel_speed", "preload", "power"]].tolist()
    assert [number(text) for text in at] == wanted
    rho_A = number(scene["blade"]["linear_density"])
    assert rho_A == pytest.approx(machine["density"] * machine["cross_section"], rel=1e-12)

    fixed, pressed = (rf.solve(SCENES / f"band-saw{end}.toml").to_dict() for end in ("-fixed-axles", ""))
    v, cut, rounded = pressed["speed_m_s"], "cut off", "with the printed 761 N"
    for item, value, printed, remark in (
        ("(17)", pressed["tight"]["tension_N"] - pressed["slack"]["tension_N"], "211", ""),
        ("v", v, "35.5", cut),
        ("(10)", fixed["tight"]["wave_speed_m_s"], "76.8", ""),
        ("(11)", fixed["slack"]["wave_speed_m_s"], "74.4", ""),
        ("(12), tight", fixed["tight"]["first_frequency_Hz"], "19.0", "misprint"),
        ("(12), slack", fixed["slack"]["first_frequency_Hz"], "17.9", cut),
        ("ρA", rho_A, "0.60", ""),
        ("F_c", rho_A * v**2, "761", "rounded factors"),
        ("(13)", pressed["tight"]["wave_speed_m_s"], "84.7", rounded),
        ("(14)", pressed["slack"]["wave_speed_m_s"], "82.6", rounded),
        ("(15), tight", pressed["tight"]["first_frequency_Hz"], "21.8", ""),
        ("(15), slack", pressed["slack"]["first_frequency_Hz"], "21.0", ""),
    ):
        assert agrees(value, printed) != bool(remark), (item, value)
        exact = {
            cut: math.floor(10 * value) / 10,
            rounded: math.sqrt(value**2 + (761 - rho_A * v**2) / rho_A),
        }
        assert agrees(exact.get(remark, float(printed)), printed), (item, value)


def test_no_string_explains_what_was_measured_on_the_tight_side():
    machine = published("band_saw_machine.csv")
    fixed, pressed = (rf.solve(SCENES / f"band-saw{end}.toml").to_dict() for end in ("-fixed-axles", ""))
    v, length_m, rho_A = (
        pressed["speed_m_s"],
        machine["free_span"],
        machine["density"] * machine["cross_section"],
    )
    assert agrees(100.0 * (fixed["rest"]["first_frequency_Hz"] / machine["measured_rest"] - 1.0), "0.13")
    for side, off, kappa in (("tight", ("-24.3", "-12.6"), "2.21"), ("slack", ("-16.9", "-2.8"), "1.22")):
        measured_Hz = machine[f"measured_{side}"]
        for solved, printed in zip((fixed, pressed), off, strict=True):
            assert agrees(100.0 * (solved[side]["first_frequency_Hz"] / measured_Hz - 1.0), printed), side
        c = length_m * measured_Hz + math.hypot(length_m * measured_Hz, v)  # of a string with that frequency
        needed = (rho_A * c**2 - fixed[side]["tension_N"]) / (rho_A * v**2)
        assert agrees(needed, kappa), side
