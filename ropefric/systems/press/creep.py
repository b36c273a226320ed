"""Elastic creep of the belts of a press: how fast every roller runs.

A belt runs with v_b (1 + T/EA), T with its ρAv². It sticks to a roller where it arrives, so that the roller's rim runs
as fast as the belt in the span before it. Belts that run together stick to each other too: with their shares of T,

    v = Σ EA / Σ (EA/v_b) · (1 + T/Σ EA).

The first driver turns as fast as the scene says. The v_b of one belt after the other follows from the rollers where
belts meet, as in the closures of `statics`; so the speed that another driver must have follows from the tensions.
A belt with n spans loses v_b/(2 EA) Σ (T_i − T_i−1)² of the drivers' power.
"""

from itertools import product

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.creep import speed_ratio
from ropefric.systems.press.machine import Press
from ropefric.systems.press.statics import arriving, carried_belts, meetings, spans_into


def rim_speed_ratios(press: Press, tension_N: FloatArray) -> FloatArray:
    """Return each rim's speed over the first driver's, shape (..., n_rollers), from T, shape (..., n_spans).

    1 where the EA of a belt is not known.
    """
    stiffness_N = np.array([belt.axial_stiffness_N for belt in press.belts], dtype=np.float64)
    if np.isnan(stiffness_N).any():
        return np.ones((*tension_N.shape[:-1], len(press.rollers)))
    together_N = stiffness_N @ carried_belts(press)
    strain = tension_N / together_N
    place = {span.name: i for i, span in enumerate(press.spans)}

    def strain_at(roller: str, belt: str) -> FloatArray:
        return strain[..., place[arriving(press, roller, belt)]]

    driver = next(roller for roller in press.rollers if roller.role == "driver")
    first = press.belts_on(driver)[0].name
    unstrained = {first: 1.0 / speed_ratio(strain_at(driver.name, first))}
    for _, (roller, *pair) in product(press.belts, meetings(press)):
        for one, other in (pair, pair[::-1]):
            if one in unstrained and other not in unstrained:
                ratio = speed_ratio(strain_at(roller, one), strain_at(roller, other))
                unstrained[other] = unstrained[one] * ratio
    # A belt that never meets another alone keeps to the first one's pace.
    paces = np.stack([unstrained.get(belt.name, unstrained[first]) for belt in press.belts], axis=-1)
    pace = together_N / ((stiffness_N / paces) @ carried_belts(press))
    by_span = pace * speed_ratio(strain)
    before = np.argmax(spans_into(press), axis=1)
    return np.asarray(by_span[..., before])
