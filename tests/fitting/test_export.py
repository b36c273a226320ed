"""A fit handed on to a simulator: the table is the law's, and no constant does better than the one that is named."""

import csv

import numpy as np
import pytest

import ropefric as rf
from ropefric.cli.app import main
from ropefric.fitting.predict import best_constant

COUPLED, WRAPS = "fits/prth-coupled.json", np.radians([90.0, 360.0, 1080.0])


def test_the_table_is_the_law():
    table = rf.friction_table(COUPLED, wrap_angle_rad=WRAPS, end_tension_N=[20, 80],
        wheel_radius_m=["20 mm", "40 mm"])  # fmt: skip
    frame = table.to_frame()
    assert len(frame) == 12
    predicted = rf.predict(COUPLED, frame)
    np.testing.assert_allclose(table.lift_force_N, predicted.lift_force_N, rtol=1e-12)
    ratio = np.log(frame["lift_force_N"] / frame["end_tension_N"]) / frame["wrap_angle_rad"]
    np.testing.assert_allclose(frame["mu_average"], ratio, rtol=1e-12)
    assert not table.extrapolated.any()
    # μ where the wrap ends is the slope of ln F_A over the wrap.
    h = 1e-5
    at = {"end_tension_N": 80, "wheel_radius_m": 0.04}
    beyond, before = (rf.friction_table(COUPLED, wrap_angle_rad=WRAPS * (1 + x), **at) for x in (h, -h))
    slope = np.log(beyond.lift_force_N / before.lift_force_N) / (2 * h * WRAPS)
    mine = (frame["end_tension_N"] == 80) & (frame["wheel_radius_m"] == 0.04)
    np.testing.assert_allclose(table.mu_local[mine], slope, rtol=1e-7)


def test_what_was_tested_is_the_default_and_beyond_is_said():
    fit = rf.load_fit(COUPLED)
    table = rf.friction_table(fit)
    for name in ("wheel_radius_m", "wrap_angle_rad", "end_tension_N"):
        values = getattr(table, name)
        assert (values.min(), values.max()) == pytest.approx(fit.validity[name], rel=1e-12)
    assert not table.extrapolated.any()
    assert rf.friction_table(fit, wheel_radius_m=0.2).extrapolated.all()
    with pytest.raises(rf.RopefricError, match="a wrap of zero"):
        rf.friction_table(fit, wrap_angle_rad=[0.0, 1.0])


def test_no_constant_does_better():
    table = rf.friction_table(COUPLED)
    rise = np.log(table.lift_force_N / table.end_tension_N)

    def worst(mu):
        return np.abs(np.exp(mu * table.wrap_angle_rad - rise) - 1.0).max()

    assert worst(table.constant_mu) == pytest.approx(table.constant_error, rel=1e-9)
    others = table.constant_mu * np.concatenate([np.linspace(0.5, 1.5, 401), 1 + np.array([-1e-6, 1e-6])])
    assert min(worst(mu) for mu in others) >= table.constant_error * (1 - 1e-9)
    mu, error = best_constant(np.array([0.6, 1.2]), np.array([3.0, 6.0]))
    assert (mu, error) == (pytest.approx(0.2), pytest.approx(0.0, abs=1e-15))
    # Two points that want 0.1 and 0.2 over one radian each: e^{μ−0.1} − 1 = 1 − e^{μ−0.2}.
    mu, _ = best_constant(np.array([0.1, 0.2]), np.array([1.0, 1.0]))
    assert mu == pytest.approx(np.log(2.0 / (np.exp(-0.1) + np.exp(-0.2))), rel=1e-12)


def test_the_command_writes_the_table(tmp_path, capsys):
    path = tmp_path / "mu.csv"
    wheels = ["--end-tension", "20 N, 80 N", "--wheel-radius", "30 mm"]
    line = ["export", COUPLED, "--wrap", "90 deg .. 1080 deg", *wheels]
    assert main([*line, "--out", str(path)]) == 0
    shown = capsys.readouterr()
    table = rf.friction_table(COUPLED, wrap_angle_rad=np.radians(np.arange(90, 1081, 90)), end_tension_N=[20, 80],
                              wheel_radius_m=0.03)  # fmt: skip
    assert f"μ = {table.constant_mu:.4g} is off by {100 * table.constant_error:.3g} %" in shown.out
    with path.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 24
    np.testing.assert_allclose([float(row["mu_average"]) for row in rows], table.mu_average, rtol=1e-8)
    assert main([*line, "--out", str(path)]) == 3, "somebody's file is not written over"
    assert main([*line, "--out", str(path), "--force"]) == 0
    assert main(["export", COUPLED, "--wrap", "90deg, x"]) == 2
