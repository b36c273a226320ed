"""What a list of conditions can tell, against known designs and against simulated campaigns."""

import numpy as np
import pytest
from scipy import stats

from ropefric.fitting.resolution import SCALE, LawOutlook, law_outlook
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS


def grid(radii, loads, wraps_deg):
    R, F, phi = (a.ravel() for a in np.meshgrid(radii, loads, np.radians(wraps_deg), indexing="ij"))
    return Conditions(wheel_radius_m=R, rope_radius_m=0.005, wrap_angle_rad=phi, end_tension_N=F)


def outlook(law, at, std=0.012):
    return law_outlook(LAWS[law], at, np.full(len(at), std**2))


def test_one_tension_tells_no_parameter_of_a_wrap_law():
    found = outlook("wrap-power", grid([0.03], [20.0], (90, 180, 360, 540, 720, 1080)))
    assert found.untold == ("a", "b", "c")
    assert found.power["constant"] < 0.8
    three = outlook("wrap-power", grid([0.03], [2.0, 20, 80], (90, 180, 360, 720, 1080)))
    assert three.power["constant"] > 0.99


def test_one_wheel_tells_no_size_effect():
    at = grid([0.03], [5.0, 20, 80], (90, 360, 720))
    found = outlook("size-exponential", at)
    # What the test finds where there is nothing.
    assert found.power["constant"] == pytest.approx(0.05, abs=1e-3)
    assert all(np.isinf(std) for std in found.expected_std.values())
    assert outlook("coupled", at).power["wrap-power"] == pytest.approx(0.05, abs=0.01)
    assert "not distinguishable from constant" in found.text
    two = outlook("size-exponential", grid([0.015, 0.03, 0.06], [20.0], (90, 360, 720)))
    assert two.power["constant"] > 0.99


def test_the_words_go_with_the_number_beside_them():
    words = {0.1949: "not", 0.2: "rarely", 0.79: "probably", 0.796: "", 1.0: ""}
    for power, how in words.items():
        found = LawOutlook(law="howell", expected_std={}, untold=(), power={"constant": power})
        text = f"howell: {how} distinguishable from constant (in {100 * power:.0f} % of campaigns)"
        assert found.text == text.replace(":  ", ": ")
        # The words begin at the share that the scale names.
        limits = {part.partition(": in ")[0]: float(part.split()[-6]) for part in SCALE.split(", ")}
        assert 100 * power >= limits.get(f"{how} distinguishable".strip(), 0.0) - 0.5


def test_too_few_conditions_judge_nothing():
    found = outlook("coupled", grid([0.02, 0.05], [20.0], (90, 360, 720)))
    assert "6 conditions for 5 parameters, and 8 are needed" in found.reason
    assert "F_0 = 1 N" in outlook("wrap-power", grid([0.03], [0.5], np.arange(90, 900, 90))).reason


def test_the_power_is_that_of_simulated_campaigns():
    """An offset of 0.1 on five wraps, by ordinary regression in 4000 campaigns; the rate is known to 0.8 %."""
    wraps = (90, 180, 360, 540, 720)
    at, std = grid([0.03], [20.0], wraps), 0.06
    power = outlook("constant-offset", at, std).power["constant"]
    rng, phi = np.random.default_rng(5), at.wrap_angle_rad
    y = 0.2 * phi + 0.1 + std * rng.standard_normal((4000, 5))
    ends = [y - np.outer(y @ phi / (phi @ phi), phi)]
    X = np.stack([phi, np.ones(5)])
    ends.append(y - y @ X.T @ np.linalg.inv(X @ X.T) @ X)
    rss = [(end**2).sum(axis=1) for end in ends]
    F = (rss[0] - rss[1]) / (rss[1] / 3)
    assert power == pytest.approx(np.mean(stats.f.isf(0.05, 1, 3) < F), abs=0.025)
