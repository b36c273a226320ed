"""The level of the tensions of a press's belts between fixed centres, that keeps their unstretched length."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError, SolverError
from ropefric.systems.fixed_centres import excess_of_length
from ropefric.systems.friction import EVERYTHING, WrapFriction
from ropefric.systems.press.creep import own_tensions_N
from ropefric.systems.press.machine import Belt, Press
from ropefric.systems.press.slip import contacts_of

_MAX_STEPS = 200
_SMALL = 1e-5
"""Share of the lowest tension by which levels are raised to find the slopes."""
_RECENT = 3
"""Steps among which one may leave more of the excess than the step before, to get past a bend of it."""
_LEAST_STEP, _LAST_STEP = 10.0, 100.0
"""Times the change that counts as settled: the least step for slopes, well above rounding, and the largest last one."""
_SETTLED = 1e-13
"""Of the largest tension, beside rounding."""
_LEAST = 1e-9
"""Of the largest tension: a span with less is slack."""


class _Way(NamedTuple):
    """A fixed belt on its way round: its spans with their lengths, and the rollers and arcs that they run onto."""

    belt: Belt
    place: int
    spans: list[int]
    span_m: FloatArray
    rollers: list[int]
    arc_m: FloatArray


def _ways(press: Press) -> list[_Way]:
    place = {(span.start, span.end): i for i, span in enumerate(press.spans)}
    names, found = [roller.name for roller in press.rollers], []
    arcs_m = press.radius_m * press.wrap_angle_rad
    for belt in press.fixed_belts:
        spans, rollers = [place[step] for step in belt.steps], [names.index(end) for _, end in belt.steps]
        span_m = np.array(belt.span_lengths_m)
        found.append(_Way(belt, press.belts.index(belt), spans, span_m, rollers, arcs_m[rollers]))
    return found


def level_rows(press: Press) -> FloatArray:
    """Return the mean tension of each fixed belt along its length as rows over the spans, shape (n_fixed, n_spans).

    Where belts run together each has its share of EA. This is the level at which a belt that adheres everywhere, and
    that is much stiffer than it is tight, keeps its length.
    """
    rows = np.zeros((len(press.fixed_belts), len(press.spans)))
    together_N = np.array([belt.axial_stiffness_N or 0.0 for belt in press.belts]) @ press.carried
    for row, way in zip(rows, _ways(press), strict=True):
        length_m = way.span_m + way.arc_m
        row[way.spans] = length_m / length_m.sum() * way.belt.axial_stiffness_N / together_N[way.spans]
    return rows


def _rounding_N(press: Press) -> float:
    """Return what rounding leaves of the shares of belts that run together: EA times differences of speeds."""
    if not (press.carried.sum(axis=0) > 1.0).any():
        return 0.0
    return 4.0 * float(np.finfo(float).eps) * max(belt.axial_stiffness_N or 0.0 for belt in press.fixed_belts)


def at_kept_lengths_N(
    press: Press,
    by_preload: FloatArray,
    effective_tension_N: FloatArray,
    *,
    circling_N: FloatArray,
    friction: float | WrapFriction | None,
    regressors: frozenset[str] = EVERYTHING,
    pretension_N: FloatArray | None = None,
    grip: FloatArray | float = 1.0,
    strict: bool = True,
) -> FloatArray:
    """Return T' at which all fixed belts have their unstretched length, shape (..., n_spans) as the T' to begin with.

    `by_preload` is that of the statics, `circling_N` ρAv² of every span where the belts' mass counts, `grip` a factor
    on all coefficients; the pretensions are those of the press where none are given, shape (..., n_fixed). Newton's
    method, with slopes from small differences of the levels. Where it does not settle, `strict` refuses; else T' is NaN.
    """
    ways = _ways(press)
    n_fixed = len(ways)
    if not n_fixed:
        return effective_tension_N
    if friction is None:
        raise InputError(
            "where a belt between fixed centres slips on its rollers depends on the friction, but none is given",
            code="RF521",
            key="friction",
            fix="give the coefficient or law",
        )
    by_level = by_preload[:, -n_fixed:]
    rest_N = press.preload_N[-n_fixed:] if pretension_N is None else pretension_N

    follows = isinstance(friction, WrapFriction) and friction.follows_tension
    constant = None if follows else contacts_of(press, by_preload[:, 0]).exponent(friction, regressors)

    def excess_N(tension_N: FloatArray) -> FloatArray:
        """Return the mean excess of each belt's tension along its length, shape (..., n_fixed)."""
        contacts = contacts_of(press, tension_N)
        exponent = grip * (contacts.exponent(friction, regressors) if constant is None else constant)
        least_N = np.finfo(float).eps * np.abs(tension_N).max(axis=-1, keepdims=True)
        after, before = (np.maximum(one, least_N) for one in (contacts.downstream_N, contacts.upstream_N))
        growth, own_N = np.log(after / before), own_tensions_N(press, tension_N + circling_N)
        found = []
        for i, way in enumerate(ways):
            arriving_N = own_N[..., way.place, way.spans]
            excess_N_m = excess_of_length(
                rest_N[..., i],
                way.belt.axial_stiffness_N or np.inf,
                span_m=way.span_m,
                arc_m=way.arc_m,
                arriving_N=arriving_N,
                leaving_N=np.roll(arriving_N, -1, axis=-1),
                growth=growth[..., way.rollers],
                exponent=exponent[..., way.rollers],
            )
            found.append(excess_N_m / (way.span_m + way.arc_m).sum())
        return np.stack(found, axis=-1)

    tension_N = trial_N = effective_tension_N
    # One case as it is, and one with each level raised, side by side.
    raised = np.vstack([np.zeros(len(by_level)), by_level.T])
    raised = raised.reshape(n_fixed + 1, *(1,) * (tension_N.ndim - 1), -1)
    rounding_N = _rounding_N(press)
    step_N = newton_N = np.full((*tension_N.shape[:-1], n_fixed), np.inf)
    left_N = [np.array(np.inf)] * _RECENT
    settled = np.zeros((*tension_N.shape[:-1], 1), dtype=bool)
    with suppress(np.linalg.LinAlgError):  # where a belt is strained without bound
        for _ in range(_MAX_STEPS):
            sizes_N = np.abs(trial_N)
            lowest_N, largest_N = (one(sizes_N, axis=-1, keepdims=True) for one in (np.min, np.max))
            small_N = _SMALL * np.maximum(lowest_N, _SMALL * largest_N)
            near_N = _SETTLED * largest_N + rounding_N
            # Not beyond the last step, as the slopes change where a belt begins to slip on a whole arc.
            small_N = np.clip(np.abs(newton_N).max(axis=-1, keepdims=True), _LEAST_STEP * near_N, small_N)
            here, *more = excess_N(trial_N + raised * small_N)
            slopes = np.stack([one - here for one in more], axis=-1) / small_N[..., np.newaxis]
            newton_N = -np.linalg.solve(slopes, here[..., np.newaxis])[..., 0]
            by_N = newton_N @ by_level.T
            # The slip arcs grow with the logarithm of T': a span loses nine tenths of it at most, until it pushes.
            bound = (trial_N > _LEAST * largest_N) & (trial_N + by_N < 0.1 * trial_N)
            shares = np.divide(-0.9 * trial_N, by_N, out=np.ones_like(by_N), where=bound)
            # A step that leaves more of the excess than any recent one is halved.
            size_N = np.abs(here).max(axis=-1, keepdims=True)
            better = size_N < np.maximum.reduce(np.broadcast_arrays(*left_N))
            tension_N = np.where(better, trial_N, tension_N)
            left_N = [*left_N[1:], np.where(better, size_N, left_N[-1])]
            step_N = np.where(better, shares.min(axis=-1, keepdims=True) * newton_N, 0.5 * step_N)
            trial_N = tension_N + step_N @ by_level.T
            settled = (np.abs(newton_N) <= near_N).all(axis=-1, keepdims=True) & (
                small_N <= _LAST_STEP * near_N
            )
            if settled.all():
                return np.asarray(trial_N)
    if not strict:
        return np.where(settled, trial_N, np.nan)
    raise SolverError(
        "no tensions keep the lengths of the belts between fixed centres",
        code="RF500",
        key=f"belts.{press.fixed_belts[0].name}.pretension_N",
        fix="check EA, pretension and loads: a belt that is strained by tens of per cent is no elastic one",
    )
