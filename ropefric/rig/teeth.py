"""Stick-slip: the rope is carried along and the force rises, slips and snaps back, again and again."""

from dataclasses import dataclass

import numpy as np

from ropefric.traces.trace import FloatArray

__all__ = ["Snap", "Teeth", "lay_teeth"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Snap:
    """How the force falls when the rope slips: a mass on a spring, released.

    Attributes
    ----------
    natural_Hz : float
        Undamped natural frequency [Hz].
    damping_ratio : float
        Damping ratio [-], below 1.

    Examples
    --------
    >>> Snap(natural_Hz=100.0, damping_ratio=0.3).remaining(np.array([0.0, 0.005])).round(3).tolist()
    [1.0, -0.368]
    """

    natural_Hz: float
    damping_ratio: float

    def remaining(self, elapsed_s: FloatArray) -> FloatArray:
        """Return the part of the fall still to come: 1 at the slip, with slope 0, then a decaying overshoot.

        Solves x'' + 2ζω x' + ω² x = 0, x(0) = 1, x'(0) = 0.
        """
        omega = 2.0 * np.pi * self.natural_Hz
        zeta = self.damping_ratio
        root = np.sqrt(1.0 - zeta**2)
        phase = omega * root * elapsed_s
        answer = np.exp(-zeta * omega * elapsed_s) * (np.cos(phase) + zeta / root * np.sin(phase))
        return np.asarray(answer, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Teeth:
    """Stick-slip teeth after break-away, as deviations from the kinetic level.

    Tooth 0 is the break-away itself: its top is reached by the loading, not by a reload.

    Attributes
    ----------
    time_s : ndarray, shape (n,)
        When each top is reached [s] after break-away; the first is 0.
    top_N, bottom_N : ndarray, shape (n,)
        The top of each tooth and the level it slips back to, as deviations from the kinetic level [N].

    Examples
    --------
    >>> teeth = lay_teeth(top_N=np.array([9.0, 1, 2]), bottom_N=np.array([-1.0, -1, -1]), reload_N_s=20.0)
    >>> teeth.force_N(np.array([0.0, 0.1, 0.25]), Snap(natural_Hz=100.0, damping_ratio=0.3)).round(6).tolist()
    [9.0, 1.0, 2.0]
    """

    time_s: FloatArray
    top_N: FloatArray
    bottom_N: FloatArray

    def force_N(self, elapsed_s: FloatArray, snap: Snap) -> FloatArray:
        """Return the deviation from the kinetic level at times after break-away [N].

        Continuous: what an earlier snap still rings with when the next top is due is taken off the reload.

        Parameters
        ----------
        elapsed_s : ndarray, shape (m,)
            Times after break-away [s], from 0 to the last tooth.
        snap : Snap
            How each slip falls.
        """
        period_s = np.diff(self.time_s)
        fall_N = (self.top_N - self.bottom_N)[:-1]
        left = snap.remaining(period_s)
        slope_N_s = (self.top_N[1:] - self.bottom_N[:-1] - fall_N * left) / (period_s * (1.0 - left))
        tooth = np.clip(np.searchsorted(self.time_s, elapsed_s, side="right") - 1, 0, period_s.size - 1)
        since_s = elapsed_s - self.time_s[tooth]
        left = snap.remaining(since_s)
        # The reload sets in as the fall does its work, so that no top is passed after its slip has begun.
        reload_N = slope_N_s[tooth] * since_s * (1.0 - left)
        return self.bottom_N[tooth] + reload_N + fall_N[tooth] * left


def lay_teeth(*, top_N: FloatArray, bottom_N: FloatArray, reload_N_s: float) -> Teeth:
    """Return teeth that follow each other as the reload allows: stiffness times speed, the same for all.

    Parameters
    ----------
    top_N, bottom_N : ndarray, shape (n,)
        Tops and bottoms as deviations from the kinetic level [N], n >= 2.
    reload_N_s : float
        Rate at which the force rises between slips [N/s].

    Examples
    --------
    >>> lay_teeth(top_N=np.array([9.0, 1, 2]), bottom_N=np.array([-1.0, -1, -1]), reload_N_s=20.0).time_s
    array([0.  , 0.1 , 0.25])
    """
    period_s = (top_N[1:] - bottom_N[:-1]) / reload_N_s
    return Teeth(time_s=np.concatenate(([0.0], np.cumsum(period_s))), top_N=top_N, bottom_N=bottom_N)
