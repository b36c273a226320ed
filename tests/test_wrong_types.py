"""What is handed to a function of `import ropefric` and is of another kind ends in an error of its own that names it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ropefric as rf

ROOT = Path(__file__).parents[1]
FIT = ROOT / "fits" / "prth-coupled.json"
SCENE = ROOT / "data" / "scenes" / "hoist.toml"
TABLE = {
    "wheel_radius_mm": [40.0] * 8,
    "rope_radius_mm": [4.9] * 8,
    "wrap_angle_deg": [90.0, 90, 180, 180, 270, 270, 360, 360],
    "end_tension_N": [10.0] * 8,
    "peak_N": [14.1, 14.3, 20.0, 20.4, 28.0, 28.5, 40.1, 39.5],
}
WHEEL = {"wheel_radius_m": 0.035, "wrap_angle_rad": 3.0, "end_tension_N": 10.0}
RIG = {"wheels_m": [0.02], "wraps_rad": [3.0, 6.0], "end_tensions_N": [20.0, 40.0]}
TIME_S = np.linspace(0.0, 2.0, 200)
PULL = {"trace": TIME_S, "force_N": np.interp(TIME_S, [0.3, 1.3, 1.32], [0.0, 60.0, 48.0])}
STRANGE = (True, b"x", object(), ["a"], {"a": 1}, 1j, np.ones((1, 1)))
"""Neither a number nor text nor a path; what can be several of something is given a number."""

# Function, arguments that are in order, and those that are not to be of another kind.
CALLS: tuple[tuple[Callable[..., Any], dict[str, Any], str], ...] = (
    (rf.smooth, {"trace": {"time_s": TIME_S, "force_N": TIME_S}}, "window_s"),
    (rf.find_breakaway, PULL, "window_s start_s stop_s min_step_N pick_s ending"),
    (rf.reject, {"values": [1.0, 2.0, 3.0]}, "rule"),
    (rf.fit, {"trials": TABLE, "law": "constant", "intervals": "covariance"},
     "law of groups shared intervals n_starts seed"),
    (rf.compare, {"trials": TABLE, "laws": ["constant"]}, "of progress"),
    (rf.diagnose, {"trials": TABLE}, "comparison"),
    (rf.predict, {"fit": FIT, **WHEEL}, "fit level method wheel_radius_m"),
    (rf.design, {"fit": FIT, "lift_N": 200.0, **WHEEL | {"wrap_angle_rad": None}}, "fit solve_for probability"),
    (rf.budget, {"fit": FIT, **WHEEL}, "fit level draws seed u_wheel_radius_m"),
    (rf.plan_tests, {"known": FIT, **RIG, **WHEEL}, "known n_conditions repeats level"),
    (rf.solve, {"scene": SCENE}, "scene level"),
    (rf.explain, {"scene": SCENE}, "scene"),
    (rf.sweep, {"scene": SCENE}, "scene table progress"),
    (rf.monte_carlo, {"scene": SCENE}, "scene draws seed level table progress"),
    (rf.load_scene, {}, "path"),
    (rf.load_fit, {}, "path"),
    (rf.load_campaign, {}, "path"),
    (rf.load_campaign, {"path": "nowhere.toml"}, "missing_recordings"),
    (rf.load_plugin, {}, "source"),
    (rf.save_fit, {"path": "nowhere.json"}, "fit"),
    (rf.read_trace, {"path": "nowhere.csv"}, "path profile calibration"),
    (rf.read_trial, {"trial": "1"}, "campaign"),
    (rf.extract, {"campaign": "nowhere.toml"}, "campaign jobs progress"),
    (rf.run, {"campaign": "nowhere.toml", "folder": "nowhere"}, "campaign folder jobs"),
)  # fmt: skip


def outcome(function: Callable[..., Any], **arguments: Any) -> str:
    """Return what a call is refused with, or that it is not."""
    try:
        function(**arguments)
    except rf.RopefricError as error:
        return f"{error.where}: {error}"
    return "not refused"


def test_an_argument_of_another_kind_is_refused_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each of them, for each function."""
    monkeypatch.chdir(tmp_path)
    wrong = []
    for function, good, names in CALLS:
        for name in names.split():
            for strange in STRANGE if "_radius_m" not in name else STRANGE[:2]:
                said = outcome(function, **good | {name: strange})
                if name not in said:
                    wrong.append(f"{function.__name__}({name}={strange!r:.20}): {said}")
    assert wrong == []


def test_several_values_are_no_single_one() -> None:
    """A number where names or pairs are meant, and bounds that are not two."""
    for name in ("fixed", "bounds", "start", "columns"):
        with pytest.raises(rf.RopefricError, match=name):
            rf.fit(TABLE, "constant", **{name: 3.5})  # type: ignore[arg-type]
    with pytest.raises(rf.RopefricError, match=r"laws cannot be 3 Fix: give several values"):
        rf.compare(TABLE, 3)  # type: ignore[arg-type]
    with pytest.raises(rf.RopefricError, match=r"axes cannot be \{\}"):
        rf.sweep(SCENE, {})  # type: ignore[arg-type]
    for ends in ((0.0, 1.0, 2.0), (0.1,), []):
        with pytest.raises(rf.RopefricError, match=r"mu is given as .* not as \(lower, upper\)"):
            rf.fit(TABLE, "constant", bounds={"mu": ends})  # type: ignore[dict-item]


def test_the_message_says_what_is_meant() -> None:
    """Argument, what came and what is to come are named."""
    with pytest.raises(
        rf.RopefricError, match="scene cannot be 3 Fix: give a Scene, or the path of its file"
    ):
        rf.solve(3)  # type: ignore[arg-type]
    with pytest.raises(rf.RopefricError, match="wheel_radius_m: True is no number"):
        rf.predict(FIT, **WHEEL | {"wheel_radius_m": True})
    with pytest.raises(rf.RopefricError, match="no value for wrap_angle_rad"):
        rf.budget(FIT, **WHEEL | {"wrap_angle_rad": None})
    with pytest.raises(rf.RopefricError, match="no column 'wrapp' to be renamed"):
        rf.trial_table(TABLE, columns={"wrapp": "wrap_angle_deg"})
