"""A scene's friction may be a number, a law or a fit; a fit brings its uncertainty and its tested range."""

import numpy as np
import pytest

from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.fitting.store import load_fit, save_fit
from ropefric.friction.condition import one_condition
from ropefric.scenes.solve import solve_scene
from ropefric.trials.table import TrialTable


@pytest.fixture(scope="module")
def stored(scenes_folder):
    return load_fit(scenes_folder.parents[1] / "fits" / "prth-coupled.json")


@pytest.mark.parametrize("speed_m_s", [None, 5.0])
def test_a_fit_gives_the_lift_force_and_the_interval_that_predict_gives(hoist_of, stored, speed_m_s):
    """Of a running rope friction sees F − ρv² alone, so ρv² moves the force and both ends of its interval."""
    circling_N = 0.062 * (speed_m_s or 0.0) ** 2
    speed = speed_m_s and f"{speed_m_s} m/s"
    solution = solve_scene(hoist_of(effects="all", wheel={"speed": speed}))
    told = predict(stored, one_condition(0.04, 0.0049, 3.0 * np.pi, 80.0 - circling_N), method="linear")
    lift = solution.quantities[0]
    assert lift.value[0] == pytest.approx(circling_N + told.lift_force_N[0], rel=1e-10)
    assert lift.std[0] == pytest.approx(told.std_N[0], rel=1e-5)
    assert lift.interval[0].tolist() == pytest.approx((circling_N + told.interval_N[0]).tolist(), rel=1e-6)


def fit_of(gain, wraps=(1.0, 2.0, 4.0, 6.0, 9.0), law="constant"):
    """A fit of two pulls a wrap, whose cell may be wrong by a gain: μ = 0.2, scatter of 2 %, seed 3."""
    wrap_rad, rng = np.repeat(wraps, 2), np.random.default_rng(3)
    force_N = 50.0 * np.exp(0.2 * wrap_rad + 0.02 * rng.standard_normal(wrap_rad.size))
    same = np.ones(wrap_rad.size)
    table = TrialTable(
        trial=tuple(map(str, range(wrap_rad.size))), wheel_radius_m=0.04 * same, rope_radius_m=0.0049 * same,
        wrap_angle_rad=wrap_rad, end_tension_N=50.0 * same, peak_N=force_N, cell_std_N=gain * force_N if gain else None,
    )  # fmt: skip
    return fit_law(table, law)


@pytest.mark.parametrize("gain", [0.0, 0.005, 0.05])
def test_the_interval_has_the_degrees_of_freedom_of_its_own_number(hoist_of, tmp_path, gain):
    """Those of `predict`: 4 of the scatter, more by a gain known beforehand; a large one is told from the data, by 1."""
    path = tmp_path / "fit.json"
    save_fit(fit_of(gain), path)
    told = predict(load_fit(path), one_condition(0.04, 0.0049, 3.0 * np.pi, 80.0))
    lift = solve_scene(
        hoist_of(friction={"fit": str(path)}, effects="all", rope={"linear_density": "0.1 mg/m"})
    )
    assert lift.quantities[0].interval[0].tolist() == pytest.approx(told.interval_N[0].tolist(), rel=1e-6)
    low, high = {0.0: (3.99, 4.01), 0.005: (4.5, 20.0), 0.05: (3.0, 4.0)}[gain]
    assert low < told.dof[0] < high


def test_a_fit_that_leaves_nothing_to_estimate_an_interval_from_gives_none(hoist_of, tmp_path):
    path = tmp_path / "fit.json"
    save_fit(fit_of(0.0, (2.0, 6.0), "wrap-power"), path)
    assert np.isnan(predict(load_fit(path), one_condition(0.04, 0.0049, 3.0 * np.pi, 80.0)).interval_N).all()
    solution = solve_scene(hoist_of(friction={"fit": str(path)}))
    assert solution.to_dict()["interval_N"] == [None, None]
    assert np.isnan(solution.quantities[0].interval).all()


def test_a_number_or_a_bare_law_has_no_uncertainty(hoist_of):
    tree = solve_scene(hoist_of(friction={"mu": 0.2})).to_dict()
    assert "std_N" not in tree
    assert tree["extrapolated"] is False
    assert not any("extrapolated" in warning for warning in tree["warnings"])


def test_a_wheel_outside_the_tests_is_flagged(hoist_of):
    solution = solve_scene(hoist_of(wheel={"radius": "200 mm"}))
    assert solution.to_dict()["extrapolated"] is True
    assert any("wheel radius 200 mm" in warning for warning in solution.warnings)


def test_a_law_scaled_to_a_coefficient_has_that_average_there(hoist_of):
    friction = {"law": "wrap-power", "parameters": {"a": 0.2, "b": -0.5, "c": 0.1},
                "scale_to": {"mu": 0.3, "wrap": "540 deg"}, "reference": {"end_tension": "80 N"}}  # fmt: skip
    solution = solve_scene(hoist_of(friction=friction, effects=["wrap-dependence", "end-tension"]))
    assert solution.to_dict()["mu_average"] == pytest.approx(0.3, rel=1e-13)


def test_the_reference_of_a_fit_lies_amid_its_tests(hoist_of, stored):
    reference = hoist_of().source.friction.reference
    for name in ("wheel_radius_m", "wrap_angle_rad", "end_tension_N"):
        low, high = stored.validity[name]
        assert getattr(reference, name)[0] == pytest.approx(np.sqrt(low * high))


def test_a_doubtful_fit_says_so(hoist_of):
    solution = solve_scene(hoist_of(friction={"fit": "../../fits/prth-constant.json"}))
    warnings = solution.scene.source.warnings
    assert warnings[0] == "the fit's status is residual-structure"
    assert set(warnings) <= set(solution.warnings)
    assert not solution.stands
