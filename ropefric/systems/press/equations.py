"""The balances of a press, assembled from its graph: matrices that every steady and transient solution shares.

With the incidence matrix D (+1 where a span leaves a roller, −1 where it arrives) and the pull matrix P of the
tensioners the equations (10)-(22) are, for all rollers and tensioners at once,

    J θ̈ = diag(R) D T − M,        m ẍ + C1 ẋ + k1 x = P T' − F,        T' = T − v² w,

with w the mass per length of all belts of a span; the drivers' rows of the first give the torque their motors must
supply. By virtual work the same matrices give what a span is stretched by: e = −Dᵀ (R θ) − Pᵀ x.

Examples
--------
>>> from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
>>> drive = Roller(name="drive", radius_m=0.1, wrap_angle_rad=3.0, role="driver")
>>> load = Roller(name="load", radius_m=0.2, wrap_angle_rad=3.0, role="tensioner", gravity_torque_N_m=5.0,
...     tensioner=Tensioner(spring_N_m=0.0, travel_m=0.0, force_N=1000.0))
>>> belt = Belt(name="belt", loop=("drive", "load"), linear_density_kg_m=15, thickness_m=0.005, width_m=1)
>>> press = Press(rollers=(drive, load), belts=(belt,), speed_m_s=1.0)
>>> spans_out_of(press).tolist(), spans_into(press).tolist()
([[1.0, 0.0], [0.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]])
>>> incidence(press).tolist(), pull_matrix(press).tolist(), carried_belts(press).tolist()
([[1.0, -1.0], [-1.0, 1.0]], [[1.0, 1.0]], [[1.0, 1.0]])
>>> radii_m(press).tolist(), load_torques_N_m(press).tolist(), has_balance(press).tolist()
([0.1, 0.2], [0.0, 5.0], [False, True])
>>> span_density_kg_m(press).tolist()
[15.0, 15.0]
"""

import math

import numpy as np
import numpy.typing as npt

from ropefric.systems.press.machine import Press

__all__ = [
    "carried_belts",
    "has_balance",
    "incidence",
    "load_torques_N_m",
    "pull_matrix",
    "radii_m",
    "span_density_kg_m",
    "spans_into",
    "spans_out_of",
]

FloatArray = npt.NDArray[np.float64]


def spans_into(press: Press) -> FloatArray:
    """Return 1 where a span arrives at a roller, else 0; shape (n_rollers, n_spans)."""
    return np.array([[float(span.end == roller.name) for span in press.spans] for roller in press.rollers])


def spans_out_of(press: Press) -> FloatArray:
    """Return 1 where a span leaves a roller, else 0; shape (n_rollers, n_spans)."""
    return np.array([[float(span.start == roller.name) for span in press.spans] for roller in press.rollers])


def incidence(press: Press) -> FloatArray:
    """Return D, shape (n_rollers, n_spans): D T is the net pull of the belts on each roller's rim [N]."""
    return spans_out_of(press) - spans_into(press)


def pull_matrix(press: Press) -> FloatArray:
    """Return P, shape (n_tensioners, n_spans): P T' is the belts' pull along each travel, eqs. (21), (22) [N]."""
    rows = []
    for roller in press.tensioners:
        tensioner = roller.tensioner
        if tensioner is None:
            continue
        arriving, leaving = math.cos(tensioner.upstream_angle_rad), math.cos(tensioner.downstream_angle_rad)
        rows.append(
            [
                arriving * (span.end == roller.name) + leaving * (span.start == roller.name)
                for span in press.spans
            ]
        )
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(press.spans))


def carried_belts(press: Press) -> FloatArray:
    """Return 1 where a belt runs in a span, else 0; shape (n_belts, n_spans)."""
    return np.array([[float(belt.name in span.belts) for span in press.spans] for belt in press.belts])


def span_density_kg_m(press: Press) -> FloatArray:
    """Return w, shape (n_spans,): mass per length of all belts in each span [kg/m]; v² w is their ρAv²."""
    return np.array([belt.linear_density_kg_m for belt in press.belts]) @ carried_belts(press)


def radii_m(press: Press) -> FloatArray:
    """Return R, shape (n_rollers,) [m]."""
    return np.array([roller.radius_m for roller in press.rollers])


def load_torques_N_m(press: Press) -> FloatArray:
    """Return M = M_G + M_F, shape (n_rollers,) [N m]."""
    return np.array([roller.torque_N_m for roller in press.rollers])


def has_balance(press: Press) -> npt.NDArray[np.bool_]:
    """Return which rollers obey a torque balance, shape (n_rollers,): all but the drivers."""
    return np.array([roller.role != "driver" for roller in press.rollers])
