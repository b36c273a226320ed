"""A measuring campaign: what was measured with what, and how the recordings are to be read."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

from ropefric.errors import Problem
from ropefric.traces.chain import Adc, ForceCell
from ropefric.traces.readers.profile import ImportProfile
from ropefric.trials.trial_spec import TrialSpec
from ropefric.trials.workers import Limits

SCHEMA = "ropefric.campaign/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class RopeSpec:
    """The rope: radius [m], mass per length [kg/m] where it is known, and what it is made of."""

    radius_m: float
    linear_density_kg_m: float | None = None
    material: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSpec:
    """A wheel that trials can name: radius [m] and what its surface is made of."""

    radius_m: float
    material: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolSpec:
    """What happens in a recording."""

    name: str = "breakaway"
    start_s: float | None = None
    stop_s: float | None = None
    min_step_N: float | None = None
    side: str = "slack"
    ending: str = "sliding"

    @property
    def needs_lift_force(self) -> bool:
        """Return whether trials give the tight side and the sensor measures the slack one."""
        return self.name == "held" and self.side == "slack"


@dataclass(frozen=True, slots=True, kw_only=True)
class SmoothingSpec:
    """How recordings are smoothed."""

    mode: str = "auto"
    window_s: float | None = None
    peak: str = "smoothed"


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSpec:
    """A wheel whose lift force is to be predicted: radius [m], wrap angle [rad], end tension [N]."""

    wheel_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """A campaign file and its trial list, checked, with every default filled in, in SI.

    Attributes
    ----------
    path : Path
        The campaign file.
    folder : Path
        The folder that the `file` column is relative to.
    name, schema : str
        Title, and version of the file format.
    rope, wheels, cells, adc
        What was measured with what; wheels and cells by name; `adc` is None without `[adc]`.
    protocol, smoothing
        How F_A is to be picked.
    profile : ImportProfile
        How recordings are to be read; its `sampling_rate_Hz` includes `[sampling] rate`.
    sampling_rate_Hz : float, optional
        Nominal sampling rate [Hz].
    tare_interval_s : tuple of float, optional
        The idle interval [s]; None for no tare.
    rejection : str
        Name of an outlier rule.
    weights_tolerance : float
        Limit of error of the end tension, as a fraction of it [-].
    design : DesignSpec, optional
        The wheel to predict.
    trials : tuple of TrialSpec
        A row each, in the order of the table.
    limits : Limits
        What reading one recording may take.
    warnings : tuple of Problem
        What is doubtful, but does not stop the work.
    """

    path: Path
    folder: Path
    name: str
    rope: RopeSpec
    trials: tuple[TrialSpec, ...]
    schema: str = SCHEMA
    wheels: Mapping[str, WheelSpec] = field(default_factory=dict)
    cells: Mapping[str, ForceCell] = field(default_factory=dict)
    adc: Adc | None = None
    protocol: ProtocolSpec = field(default_factory=ProtocolSpec)
    sampling_rate_Hz: float | None = None
    tare_interval_s: tuple[float, float] | None = None
    smoothing: SmoothingSpec = field(default_factory=SmoothingSpec)
    rejection: str = "two-sigma"
    weights_tolerance: float = 0.0
    design: DesignSpec | None = None
    profile: ImportProfile = field(default_factory=ImportProfile)
    limits: Limits = field(default_factory=Limits)
    warnings: tuple[Problem, ...] = ()

    def settings_fingerprint(self) -> str:
        """Return the SHA-256 of all settings that every recording's extraction depends on.

        Cells, converter, protocol, sampling, tare, smoothing, weights and import profile count; names, the
        rope, wheels, rejection, design, limits and the trial list do not: what differs between trials (cell, sample,
        interval, end tension) is in their `TrialSpec`.
        """
        names = (
            *("cells", "adc", "protocol", "sampling_rate_Hz", "tare_interval_s", "smoothing"),
            *("weights_tolerance", "profile"),
        )
        settings = {name: _plain(getattr(self, name)) for name in names}
        text = json.dumps(settings, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()

    def resolved(self) -> dict[str, Any]:
        """Return the whole campaign, defaults included, as JSON-able data without absolute paths."""
        skipped = {"path", "folder", "warnings", "trials", "limits"}
        tree = {f.name: _plain(getattr(self, f.name)) for f in fields(self) if f.name not in skipped}
        tree["path"] = self.path.name
        tree["folder"] = self._relative(self.folder)
        tree["trials"] = []
        for trial in self.trials:
            row = _plain(trial) | {"file": self._relative(trial.path)}
            tree["trials"].append({key: row[key] for key in row if key not in ("path", "line")})
        tree["warnings"] = [problem.message for problem in self.warnings]
        return tree

    def _relative(self, path: Path) -> str:
        try:
            return Path(os.path.relpath(path, self.path.parent)).as_posix()
        except ValueError:  # another drive on Windows
            return path.name


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return value.as_posix() if isinstance(value, Path) else value
