"""What an identification of preload and mounting hands over, and what it is worth."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ropefric.friction.condition import FloatArray

__all__ = ["Identification", "IdentificationStatus"]


class IdentificationStatus(StrEnum):
    """What an identification is worth."""

    OK = "ok"
    ON_BOUND = "on-bound"
    NO_SPARE = "no-spare"
    MISFIT = "misfit"
    BEYOND_BOUND = "beyond-bound"
    UNIDENTIFIABLE = "unidentifiable"

    @property
    def advice(self) -> str:
        """Return what the status means and what to do.

        Examples
        --------
        >>> IdentificationStatus.NO_SPARE.advice[:27]
        'As many points as unknowns:'
        """
        return {
            IdentificationStatus.OK: "Preload and mounting factor are determined by the data.",
            IdentificationStatus.ON_BOUND: (
                "The mounting factor lies on its bound, and its uncertainty reaches there: within what the points "
                "can tell, the wheels are mounted like that."
            ),
            IdentificationStatus.NO_SPARE: (
                "As many points as unknowns: they are met exactly, whatever they are. Measure more modes or "
                "speeds, or give the points' uncertainties."
            ),
            IdentificationStatus.MISFIT: (
                "The points are further off than their uncertainties allow: the model leaves something out, or a "
                "mode is taken for another. Check the modes, or doubt the uncertainties."
            ),
            IdentificationStatus.BEYOND_BOUND: (
                "The mounting factor lies on its bound, and that is not a measurement of it: the points ask for a "
                "value no mounting has (see free_mounting_factor). Look for what the model leaves out before using "
                "the preload."
            ),
            IdentificationStatus.UNIDENTIFIABLE: (
                "The points cannot tell preload and mounting factor apart. Measure at rest and running, or at "
                "different speeds."
            ),
        }[self]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Identification:
    """Preload and mounting factor with what is known of their errors.

    Attributes
    ----------
    preload_N, mounting_factor : float
        F_0 [N] and κ [-], κ within [0, 1].
    covariance : ndarray, shape (2, 2), or None
        Of (F_0, κ): from the points' uncertainties where all have one, else from the residuals; a κ on its bound is
        held there and has zeros. None where nothing tells the errors.
    free_mounting_factor : float or None
        What κ would be without its bounds; None where it lies within them.
    status : IdentificationStatus
        What this is worth.
    residual_Hz : ndarray, shape (n,)
        Measured less model.
    n, dof : int
        Points, and points less the free unknowns.
    """

    preload_N: float
    mounting_factor: float
    covariance: FloatArray | None
    free_mounting_factor: float | None
    status: IdentificationStatus
    residual_Hz: FloatArray
    n: int
    dof: int

    @property
    def std(self) -> tuple[float, float] | None:
        """Return the standard uncertainties of F_0 [N] and κ, or None where they are not known."""
        if self.covariance is None:
            return None
        spread = np.sqrt(np.diag(self.covariance))
        return float(spread[0]), float(spread[1])
