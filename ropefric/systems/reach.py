"""Numbers so large or small that no machine has them, and that squares and quotients of them are no floats."""

import numpy as np
import numpy.typing as npt

from ropefric.errors import InputError

__all__ = ["beyond_reach", "refuse_beyond_reach"]

_LARGEST, _SMALLEST = 1e30, 1e-30


def beyond_reach(values: npt.ArrayLike, *, may_vanish: bool) -> npt.NDArray[np.bool_]:
    """Return where a quantity is above 1e30 in amount, or below 1e-30 if it may not vanish.

    Arguments as in `refuse_beyond_reach`.

    Examples
    --------
    >>> beyond_reach([0.0, 1e31, -1e31], may_vanish=True).tolist()
    [False, True, True]
    """
    size = np.abs(np.asarray(values, dtype=np.float64))
    return np.asarray((size > _LARGEST) | ((size < _SMALLEST) & (not may_vanish)))


def refuse_beyond_reach(name: str, values: npt.ArrayLike, *, may_vanish: bool) -> None:
    """Refuse a quantity above 1e30 in amount, or below 1e-30 if it may not vanish.

    Parameters
    ----------
    name : str
        Its name, for the message.
    values : array_like
        Its values in SI units.
    may_vanish : bool
        Whether nothing is divided by it, so that it may come as near to zero as it likes.

    Raises
    ------
    InputError
        If a value is out of reach; the first is named.

    Examples
    --------
    >>> refuse_beyond_reach("speed_m_s", [0.0, 35.0], may_vanish=True)
    >>> try:
    ...     refuse_beyond_reach("free_span_m", 1e-31, may_vanish=False)
    ... except InputError as error:
    ...     print(error.problem.message)
    free_span_m is 1e-31, beyond anything from 1e-30 to 1e+30 in SI units
    """
    array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    beyond = beyond_reach(array, may_vanish=may_vanish)
    if beyond.any():
        raise InputError(
            f"{name} is {array[beyond][0]:g}, beyond anything from {_SMALLEST:g} to {_LARGEST:g} in SI units",
            key=name,
            fix="check the unit it was given in",
        )
