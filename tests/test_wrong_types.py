"""Whatever is handed to a function of `import ropefric`, it answers or ends in an error of ropefric's own."""

import inspect
from contextlib import suppress
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
TIME_S = np.linspace(0.0, 2.0, 200)
FORCE_N = np.interp(TIME_S, [0.3, 1.3, 1.32], [0.0, 60.0, 48.0])
GOOD: dict[str, dict[str, Any]] = {
    "smooth": {"trace": {"time_s": TIME_S, "force_N": FORCE_N}, "window_s": 0.05},
    "find_breakaway": {"trace": TIME_S, "force_N": FORCE_N},
    "reject": {"values": [1.0, 2.0, 3.0]},
    "trial_table": {"trials": TABLE},
    "fit": {"trials": TABLE, "law": "constant", "intervals": "covariance"},
    "compare": {"trials": TABLE, "laws": ["constant"]},
    "predict": {"fit": FIT, **WHEEL},
    "design": {"fit": FIT, "lift_N": 200.0, "wheel_radius_m": 0.035, "end_tension_N": 10.0},
    "friction_table": {"fit": FIT},
    "budget": {"fit": FIT, "draws": 10_000, **WHEEL},
    "solve": {"scene": SCENE},
    "explain": {"scene": SCENE},
    "load_fit": {"path": FIT},
    "load_campaign": {"path": ROOT / "data" / "prth-bench" / "campaign.toml"},
    "load_scene": {"path": SCENE},
    "lmfit_model": {"law": "coupled"},
    "save_fit": {"fit": None, "path": "nowhere.json"},
    "read_trace": {"path": "nowhere.csv"},
    "read_trial": {"campaign": "nowhere.toml", "trial": "1"},
    "extract": {"campaign": "nowhere.toml"},
    "run": {"campaign": "nowhere.toml", "folder": "nowhere"},
}
STRANGE = (
    None,
    True,
    "abc",
    b"x",
    -1,
    3.5,
    [],
    {},
    object(),
    float("nan"),
    ["a"],
    np.ones((1, 1)),
    {"a": 1},
    1j,
)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", GOOD)
def test_wrong_arguments_end_in_own_errors(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One argument after the other is replaced by things it is not."""
    monkeypatch.chdir(tmp_path)
    function = getattr(rf, name)
    for parameter in inspect.signature(function).parameters:
        for strange in STRANGE if parameter not in {"executor", "progress"} else ():
            with suppress(rf.RopefricError):
                function(**GOOD[name] | {parameter: strange})


def test_the_message_says_what_is_meant() -> None:
    """Function, argument, what came and what is to come are named."""
    with pytest.raises(rf.RopefricError, match=r"fit: law cannot be None\s+Fix: give text"):
        rf.fit(TABLE, None)  # type: ignore[arg-type]
    with pytest.raises(
        rf.RopefricError, match=r"solve: scene cannot be 3 .*Fix: give a Scene or text or a path"
    ):
        rf.solve(3)  # type: ignore[arg-type]
    with pytest.raises(rf.RopefricError, match=r"sweep: axes cannot be {}"):
        rf.sweep(SCENE, {})  # type: ignore[arg-type]
    with pytest.raises(rf.RopefricError, match="wheel_radius_m: True is no number"):
        rf.predict(FIT, **WHEEL | {"wheel_radius_m": True})


def test_a_column_to_be_renamed_that_is_not_there() -> None:
    """A mistyped name is told in a mapping as in a frame."""
    with pytest.raises(rf.RopefricError, match="no column 'wrapp' to be renamed"):
        rf.trial_table(TABLE, columns={"wrapp": "wrap_angle_deg"})


@pytest.mark.parametrize("ends", [(0.0, 1.0, 2.0), (0.1,), []])
def test_bounds_are_two(ends: list[float]) -> None:
    """A lower and an upper one."""
    with pytest.raises(rf.RopefricError, match=r"mu is given as .* not as \(lower, upper\)"):
        rf.fit(TABLE, "constant", bounds={"mu": ends})  # type: ignore[dict-item]
