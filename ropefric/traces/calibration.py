"""ADC counts -> volts -> newtons, tare, and where the converter sat at its limits."""

from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, field, fields, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ropefric.errors import DataError, InputError, Problem, UnknownNameError
from ropefric.registry import did_you_mean
from ropefric.traces.chain import Adc, ForceCell, require_floats
from ropefric.traces.counts import as_counts
from ropefric.traces.saturation import Saturation, find_saturation
from ropefric.traces.tare import Tare, measure_tare

__all__ = ["Adc", "Calibration", "ForceCell", "Saturation", "as_counts", "tare_from_interval"]

SCHEMA = "ropefric.calibration/1"

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """How counts become newtons: converter, cell and tare."""

    cell: ForceCell
    adc: Adc = field(default_factory=Adc)
    tare_N: float = 0.0
    tare_std_N: float = 0.0

    def __post_init__(self) -> None:
        require_floats(self, "calibration")
        if self.tare_std_N < 0:
            raise InputError(
                f"calibration: tare_std_N = {self.tare_std_N:g} is negative", code="RF210", key="tare_std_N"
            )

    @property
    def lsb_N(self) -> float:
        """Return the force of one count [N]."""
        return self.adc.lsb_V * self.cell.line.gain_N_V

    @property
    def ceiling_N(self) -> float:
        """Return the force at the converter's largest count [N], tare taken off."""
        gain_N, offset_N = self._gain_and_offset()
        return gain_N * self.adc.max_count + offset_N

    @property
    def floor_N(self) -> float:
        """Return the force at count 0 [N], tare taken off."""
        return self._gain_and_offset()[1]

    def _gain_and_offset(self) -> tuple[float, float]:
        line = self.cell.line
        return self.adc.lsb_V * line.gain_N_V, (self.adc.low_V - line.zero_V) * line.gain_N_V - self.tare_N

    def apply(self, counts: Any) -> tuple[NDArray[np.float64], Saturation]:
        """Return the forces of raw counts, and where the converter sat at its limits."""
        counts = as_counts(counts)
        gain_N, offset_N = self._gain_and_offset()
        max_count = self.adc.max_count
        top = int(counts.max(initial=0))
        if top > max_count:
            index = int(np.argmax(counts > max_count))
            raise DataError(
                f"sample {index} (the first is 0) has count {counts[index]}, above the {max_count} of a "
                f"{self.adc.bits}-bit converter; the largest count is {top}",
                code="RF211",
                key="bits",
                fix=f"set bits = {top.bit_length()} or more, or check which column holds the counts",
            )
        force_N = counts * gain_N
        force_N += offset_N
        missing = counts < 0
        if missing.any():
            force_N[missing] = np.nan
        return force_N, find_saturation(counts, max_count)

    def with_tare(self, counts: Any, interval: NDArray[np.bool_]) -> "Calibration":
        """Return this calibration with the tare that makes the mean force over an idle interval zero."""
        tare = self.tare_of(counts, interval)
        return replace(self, tare_N=tare.force_N, tare_std_N=tare.std_N)

    def tare_of(self, counts: Any, interval: NDArray[np.bool_]) -> Tare:
        """Return the reading of the unloaded rig over an idle interval, with what is doubtful about it.

        Parameters and errors are those of `with_tare`.
        """
        counts = as_counts(counts)
        if counts.shape != np.shape(interval):
            raise InputError(
                f"{counts.size} counts and an interval mask of shape {np.shape(interval)}", code="RF212"
            )
        return self._tare_of_all(counts[np.asarray(interval, dtype=bool)])

    def _tare_of_all(self, counts: Any) -> Tare:
        force_N, saturation = replace(self, tare_N=0.0).apply(counts)
        return measure_tare(force_N, saturation, lsb_N=self.lsb_N)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as JSON-able values, under schema `ropefric.calibration/1`."""
        cell = asdict(self.cell)
        cell |= {"points": [list(point) for point in self.cell.points], "assumed": list(self.cell.assumed)}
        return {
            "schema": SCHEMA,
            "adc": asdict(self.adc),
            "cell": cell,
            "tare_N": self.tare_N,
            "tare_std_N": self.tare_std_N,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> "Calibration":
        """Return the calibration that `to_dict` described."""
        rest = dict(data)
        schema = rest.pop("schema", None)
        if schema != SCHEMA:
            raise DataError(f"schema {schema!r} is not {SCHEMA!r}", code="RF210", key="schema")
        for key, kind in (("adc", Adc), ("cell", ForceCell)):
            rest[key] = _build(kind, rest.get(key, {}), key)
        return _build(cls, rest, "calibration")


def tare_from_interval(
    time_s: NDArray[np.float64], counts: Any, calibration: Calibration, start_s: float, end_s: float
) -> tuple[Calibration, tuple[Problem, ...]]:
    """Return the calibration with the tare of an idle interval, and what is doubtful about it."""
    if not start_s < end_s:
        raise InputError(
            f"the tare interval from {start_s:g} s to {end_s:g} s is empty",
            code="RF212",
            key="tare",
            fix="write its start before its end",
        )
    time_s = np.asarray(time_s, dtype=np.float64)
    slack_s = 0.1 * (end_s - start_s)
    if time_s.size == 0 or start_s < time_s[0] - slack_s or end_s > time_s[-1] + slack_s:
        covered = f"{time_s[0]:g} s to {time_s[-1]:g} s" if time_s.size else "which is empty"
        raise DataError(
            f"the tare interval from {start_s:g} s to {end_s:g} s is not in the recording, {covered}",
            code="RF212",
            key="tare",
            fix="name an interval inside the recording",
        )
    counts = np.asarray(counts)
    if counts.shape != time_s.shape:
        raise InputError(f"{counts.size} counts for {time_s.size} time stamps", code="RF212")
    first, stop = np.searchsorted(time_s, start_s, side="left"), np.searchsorted(time_s, end_s, side="right")
    tare = calibration._tare_of_all(counts[first:stop])  # noqa: SLF001  (a function of this class's module)
    return replace(calibration, tare_N=tare.force_N, tare_std_N=tare.std_N), tare.problems


def _build(kind: type[T], values: Any, key: str) -> T:
    """Make a dataclass from a mapping, with messages instead of a TypeError."""
    if not isinstance(values, Mapping):
        raise InputError(f"{key}: {values!r} is not a table of values", code="RF210", key=key)
    items = fields(kind)  # type: ignore[arg-type]  # only dataclasses come here
    known = [item.name for item in items]
    for name in values:
        if name not in known:
            raise UnknownNameError(
                f"{key}: unknown key '{name}'", code="RF120", fix=did_you_mean(name, known)
            )
    needed = [item.name for item in items if item.default is item.default_factory is MISSING]
    missing = [name for name in needed if name not in values]
    if missing:
        raise InputError(f"{key}: {', '.join(missing)} is missing", code="RF210", key=key)
    return kind(**values)
