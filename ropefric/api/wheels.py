"""From a friction law to the lift force of a wheel, and back."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from ropefric.api.campaigns import PathLike, as_campaign
from ropefric.api.inputs import as_fit
from ropefric.arrays import FloatArray
from ropefric.fitting.design import Design, SolveFor
from ropefric.fitting.design import design as find_design
from ropefric.fitting.predict import Method, Prediction
from ropefric.fitting.predict import predict as predict_lift
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions
from ropefric.pipeline.run import CampaignRun, campaign_folder, run_campaign
from ropefric.trials.campaign_model import Campaign


def predict(
    fit: FitResult | PathLike,
    *,
    wheel_radius_m: npt.ArrayLike,
    wrap_angle_rad: npt.ArrayLike,
    end_tension_N: npt.ArrayLike,
    rope_radius_m: npt.ArrayLike | None = None,
    level: float = 0.95,
    method: Method = "linear",
    linear_density_kg_m: float | None = None,
    speed_m_s: float | None = None,
) -> Prediction:
    """Return the lift force of a fitted law for n wheels, with confidence and prediction intervals.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    wheel_radius_m, wrap_angle_rad, end_tension_N : array_like, scalar or shape (n,)
        R_w [m], φ [rad], F_B [N].
    rope_radius_m : array_like, optional
        R_r [m]; that of the trials where they had one rope only.
    level, method, linear_density_kg_m, speed_m_s
        As `ropefric.fitting.predict.predict`.
    """
    stored = as_fit(fit)
    wheels = Conditions(
        wheel_radius_m=np.asarray(wheel_radius_m, dtype=np.float64),
        rope_radius_m=_rope(stored, rope_radius_m),
        wrap_angle_rad=np.asarray(wrap_angle_rad, dtype=np.float64),
        end_tension_N=np.asarray(end_tension_N, dtype=np.float64),
    )
    return predict_lift(
        stored,
        wheels,
        level=level,
        method=method,
        linear_density_kg_m=linear_density_kg_m,
        speed_m_s=speed_m_s,
    )


def design(
    fit: FitResult | PathLike,
    *,
    lift_N: npt.ArrayLike,
    solve_for: SolveFor = "wrap",
    wheel_radius_m: npt.ArrayLike | None = None,
    wrap_angle_rad: npt.ArrayLike | None = None,
    end_tension_N: npt.ArrayLike | None = None,
    rope_radius_m: npt.ArrayLike | None = None,
    probability: float | None = 0.95,
) -> Design:
    """Return the smallest wrap, wheel radius or end tension that lifts a load with a probability.

    Parameters
    ----------
    fit : FitResult or path-like
        The fit or its file.
    lift_N, solve_for, wheel_radius_m, wrap_angle_rad, end_tension_N, probability
        As `ropefric.fitting.design.design`.
    rope_radius_m : array_like, optional
        R_r [m]; that of the trials where they had one rope only.
    """
    stored = as_fit(fit)
    return find_design(
        stored, lift_N=lift_N, rope_radius_m=_rope(stored, rope_radius_m), wheel_radius_m=wheel_radius_m,
        wrap_angle_rad=wrap_angle_rad, end_tension_N=end_tension_N, solve_for=solve_for, probability=probability,
    )  # fmt: skip


def run(
    campaign: Campaign | PathLike,
    folder: PathLike,
    *,
    law: str = "",
    jobs: int = 1,
    cache_dir: PathLike | None = None,
    overwrite: bool = False,
) -> CampaignRun:
    """Return a campaign's result, from recordings to the lift force of its wheel, and write its files into a folder.

    Parameters
    ----------
    campaign : Campaign or path-like
        The campaign or its file.
    folder : path-like
        Where trials.csv, fits/, comparison.csv, … go; what an earlier run wrote there and no longer fits is removed.
    law : str
        The law to use; "" for the best whose fit may be used as it stands.
    jobs, cache_dir
        As `extract`.
    overwrite : bool
        Replace files in the folder that ropefric did not write; the campaign's own are never replaced.
    """
    kept = None if cache_dir is None else Path(cache_dir)
    loaded = as_campaign(campaign)
    with campaign_folder(loaded, folder, force=overwrite) as target:
        result = run_campaign(loaded, target, law=law, jobs=jobs, cache_dir=kept)
        target.publish("answer")
    return result


def _rope(fit: FitResult, given_m: npt.ArrayLike | None) -> FloatArray:
    if given_m is None:
        given_m = fit.only_rope_radius_m()
    return np.asarray(given_m, dtype=np.float64)
