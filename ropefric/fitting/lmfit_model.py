"""A friction law as an `lmfit.Model`, for fits and plots of one's own; ropefric itself fits without lmfit."""

from inspect import Parameter, Signature

import lmfit
import numpy as np
import numpy.typing as npt

from ropefric.arrays import FloatArray
from ropefric.friction.condition import SETTINGS, Conditions
from ropefric.friction.law import FrictionLaw
from ropefric.friction.laws import ALL_LAWS


def lmfit_model(law: str | FrictionLaw) -> lmfit.Model:
    """Return a friction law as an `lmfit.Model` of ln(F_A / 1 N), with its start values and bounds.

    The scatter of break-away forces is a part of the force, so the logarithm is what least squares should see.
    lmfit takes derivatives by differences and knows nothing of repeats of a condition: for a law with honest
    uncertainty use `fit`.

    Parameters
    ----------
    law : str or FrictionLaw
        "constant", "wrap-power", "coupled", …

    Returns
    -------
    lmfit.Model
        Its independent variables are `wheel_radius_m`, `rope_radius_m` [m], `wrap_angle_rad` [rad] and
        `end_tension_N` [N], numbers or arrays of one length; its parameters are those of the law. `make_params()`
        gives them the law's start values and bounds, and holds those that a fit of the law holds.

    Raises
    ------
    UnknownNameError
        If there is no such law.
    InputError
        RF420 on evaluation, where the law has no answer.

    Examples
    --------
    >>> import numpy as np
    >>> import ropefric as rf
    >>> model = rf.lmfit_model("constant")
    >>> pulls = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": np.array([3.0, 6.0, 9.0]),
    ...     "end_tension_N": 20.0}
    >>> found = model.fit(np.log([36.6, 66.1, 121.7]), **pulls)
    >>> round(found.best_values["mu"], 3)
    0.2
    """
    chosen = ALL_LAWS[law] if isinstance(law, str) else law

    def log_lift(**values: npt.ArrayLike) -> FloatArray:
        conditions = Conditions(**{name: np.asarray(values[name], np.float64) for name in SETTINGS})
        return chosen.log_lift([float(values[name]) for name in chosen.parameter_names], conditions)  # type: ignore[arg-type]

    # lmfit reads the names of a model from its signature.
    names = (*SETTINGS, *chosen.parameter_names)
    log_lift.__signature__ = Signature([Parameter(name, Parameter.KEYWORD_ONLY) for name in names])  # type: ignore[attr-defined]
    model = lmfit.Model(log_lift, independent_vars=list(SETTINGS), name=chosen.name)
    for item in chosen.parameters:
        model.set_param_hint(item.name, value=item.start, min=item.lower, max=item.upper, vary=not item.fixed)
    return model
