"""The parameters of a law: what they are called, where they may lie, and how they travel as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.physics import Columns
from ropefric.registry import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One parameter of a law."""

    name: str
    unit: str
    start: float
    lower: float
    upper: float
    meaning: str
    fixed: bool = False


def vector_from(mapping: Mapping[str, float], parameters: Sequence[Parameter], law: str) -> FloatArray:
    """Return the values of a mapping in the order of the parameters; a fixed one may be left out."""
    names = [parameter.name for parameter in parameters]
    for name in mapping:
        if name not in names:
            raise UnknownNameError(f"{law} has no parameter {name!r}", fix=did_you_mean(name, names))
    values = {parameter.name: parameter.start for parameter in parameters if parameter.fixed} | dict(mapping)
    missing = [name for name in names if name not in values]
    if missing:
        raise InputError(f"{law}: no value for {', '.join(missing)}", fix=f"it needs {', '.join(names)}")
    return np.array([float(values[name]) for name in names])


def columns_of(theta: npt.ArrayLike, names: Sequence[str], law: str) -> Columns:
    """Return theta, shape (p,) or (m, p), as p columns of shape () or (m, 1)."""
    try:
        array = np.asarray(theta, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{law}: theta is not an array of numbers", key="theta") from None
    p = len(names)
    if array.ndim not in {1, 2} or array.shape[-1] != p:
        raise InputError(
            f"{law}: theta has shape {array.shape}; it needs ({p},) or (m, {p})",
            key="theta",
            fix=f"its parameters are {', '.join(names)}",
        )
    if not np.isfinite(array).all():
        raise InputError(f"{law}: a parameter is not finite", key="theta", fix="give finite numbers")
    return tuple(array[..., i] if array.ndim == 1 else array[:, i, np.newaxis] for i in range(p))
