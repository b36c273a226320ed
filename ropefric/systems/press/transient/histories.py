"""From states to what people read: tensions, speeds, slips."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.energy import energies_of
from ropefric.systems.press.transient.hybrid import Change
from ropefric.systems.press.transient.inputs import SPEED, Inputs
from ropefric.systems.press.transient.limit import friction_utilisation
from ropefric.systems.press.transient.mode import STICK
from ropefric.systems.press.transient.motion import FrictionLimit, Motion
from ropefric.systems.press.transient.result import SlipInterval


def histories_of(
    motions: Sequence[Motion],
    states: FloatArray,
    works: FloatArray,
    *,
    inputs: Inputs,
    times_s: FloatArray,
    limit: FrictionLimit | None,
) -> dict[str, Any]:
    """Return the arrays of a `StartUp` by name."""
    model = motions[0].model
    radius = np.array([roller.radius_m for roller in model.press.rollers])
    rest = np.array(
        [part.tensioner.travel_m for part in model.press.tensioners if part.tensioner is not None]
    )
    w = np.hstack([states, inputs.at(times_s)])
    chosen = _by_mode(motions, len(times_s))
    first = motions[0]
    tension = _apply("tension_N", w, chosen)
    friction = _apply("friction_N", w, chosen)
    if len(motions) > 1:
        tension = np.maximum(tension, 0.0)  # the moment a belt goes slack is met to rounding only
    contact = np.zeros((len(times_s), len(radius)), dtype=np.int8)
    for motion, rows in chosen:
        contact[rows] = motion.mode.contact
    utilisation = None
    if limit is not None:
        pressing = _apply("pressing_N", w, chosen)
        upstream = pressing @ np.maximum(-model.incidence, 0.0).T
        downstream = pressing @ np.maximum(model.incidence, 0.0).T
        utilisation = friction_utilisation(
            limit,
            friction_N=friction,
            upstream_N=upstream,
            downstream_N=downstream,
            arc_force_N=model.arc_mass_kg * _apply("belt_acceleration_m_s2", w, chosen),
        )
        if first.limit is not None:
            # Beside a span that has lifted off the formula has no slack side, but the friction still has a limit.
            lifted = (pressing <= 0.0).astype(np.float64) @ np.abs(model.incidence).T > 0.0
            most = np.where(friction >= 0.0, *(_apply_limit(side, w, chosen) for side in (0, 1)))
            share = np.divide(np.abs(friction), most, out=np.zeros_like(most), where=most > 0.0)
            utilisation = np.where(contact != STICK, 1.0, np.where(lifted, share, utilisation))
    return {
        "time_s": times_s,
        "drive_speed_m_s": w[:, states.shape[1] + SPEED],
        "tension_N": tension,
        "roller_speed_rad_s": w @ first.rim_speed_m_s.T / radius,
        "relative_angle_rad": w @ first.relative_way_m.T / radius,
        "travel_m": rest + w @ first.travel_m.T,
        "contact": contact,
        "slip_m": w @ first.slip_m.T,
        "slip_speed_m_s": w @ first.slip_speed_m_s.T,
        "friction_N": friction,
        "utilisation": utilisation,
        "energy": energies_of(first, w, works),
    }


def _by_mode(motions: Sequence[Motion], n_times: int) -> list[tuple[Motion, np.ndarray]]:
    if len(motions) == 1:
        return [(motions[0], np.arange(n_times))]
    rows: dict[int, list[int]] = {}
    for i, motion in enumerate(motions):
        rows.setdefault(id(motion), []).append(i)
    return [(motions[indices[0]], np.array(indices)) for indices in rows.values()]


def _apply(name: str, w: FloatArray, chosen: list[tuple[Motion, np.ndarray]]) -> FloatArray:
    whole = np.zeros((len(w), len(getattr(chosen[0][0], name))))
    for motion, rows in chosen:
        whole[rows] = w[rows] @ getattr(motion, name).T
    return whole


def _apply_limit(side: int, w: FloatArray, chosen: list[tuple[Motion, np.ndarray]]) -> FloatArray:
    whole = np.zeros((len(w), chosen[0][0].n_rollers))
    for motion, rows in chosen:
        whole[rows] = w[rows] @ motion.limit_N[side].T
    return whole


def slip_intervals(names: Sequence[str], changes: Sequence[Change], end_s: float) -> tuple[SlipInterval, ...]:
    """Return all slips from the changes of mode; instants without duration are left out."""
    open_slips: dict[int, Change] = {}
    found: list[SlipInterval] = []

    def close(place: int, time_s: float, *, stuck: bool) -> None:
        begun = open_slips.pop(place)
        if time_s > begun.time_s:
            found.append(
                SlipInterval(
                    roller=names[place],
                    start_s=begun.time_s,
                    end_s=time_s,
                    direction=begun.direction,
                    ends_stuck=stuck,
                )
            )

    for change in changes:
        if change.what == "slip" and change.direction != STICK:
            open_slips[change.place] = change
        elif change.what == "stick" and change.place in open_slips:
            close(change.place, change.time_s, stuck=True)
    for place in list(open_slips):
        close(place, end_s, stuck=False)
    return tuple(sorted(found, key=lambda slip: (slip.start_s, slip.roller)))
