"""A third rig, which neither the picker's training nor its rules know: a rope of masses and springs around a wheel.

The rope is a chain of elements with mass and Coulomb friction on a locked wheel, joined by springs; a motor pulls its
tight end through the spring of a load cell, a weight hangs from its slack end. The normal force on an element is the
mean of the tensions beside it times its angle. Friction falls from static to kinetic over a slip distance and heals at
rest, so that slip begins at the tight end and runs to the weight. The rope breaks away when the weight moves.
"""

from typing import NamedTuple

import numpy as np

ELEMENTS, GRAVITY_M_S2, SPEED_M_S = 16, 9.81, 1e-3
FALL, LOWEST_FALL = 0.015, 0.005
"""A fall of this part of F_A ends the break-away; of a recording whose largest fall lies between, nobody could say."""
STEPS_PER_PERIOD, DAMPING, KEPT_HZ = 16.0, 0.1, 5000.0


class Pull(NamedTuple):
    """A recording of the chain: samples, status, and time and force of the break-away."""

    time_s: np.ndarray
    force_N: np.ndarray
    status: str
    breakaway_s: float
    peak_N: float


def _machines(rng, count):
    """Return the numbers of many machines, each of shape (count, 1)."""

    def uniform(low, high):
        return rng.uniform(low, high, (count, 1))

    def spread(low, high):
        return np.exp(uniform(np.log(low), np.log(high)))

    drawn = {
        "weight_N": spread(2.0, 300.0), "wrap": uniform(0.8, 7.0), "static": uniform(0.1, 0.45),
        "climb_s": spread(0.4, 4.0), "rest_s": uniform(0.3, 1.5), "slide_s": uniform(0.8, 3.0),
        "weakening": uniform(0.6, 0.95), "heal_s": spread(0.02, 2.0), "soft_s": uniform(0.01, 0.15),
        "rope": spread(1.0, 20.0), "own_Hz": spread(15.0, 40.0), "begin": uniform(0.0, 0.5),
        "stop": np.where(uniform(0.0, 1.0) < 0.15, uniform(0.4, 0.9), np.inf),
        "distance": spread(0.002, 0.05), "roughness": spread(1e-4, 0.01),
    }  # fmt: skip
    return drawn | {"static": np.minimum(drawn["static"], 2.2 / drawn["wrap"])}


def _motion(rng, drawn):
    """Return times, cell forces and travels of the weights of all machines, when each ends, and its slip distance."""
    weight_N, wrap, climb_s = (drawn[key] for key in ("weight_N", "wrap", "climb_s"))
    static, kinetic = drawn["static"], drawn["static"] * drawn["weakening"]
    # The cell's spring comes to the lift force in the time of the climb; the rope is stiffer by a factor.
    way_m = SPEED_M_S * climb_s
    cell_N_m = weight_N * np.exp(static * wrap) / way_m
    rope_N_m = cell_N_m * drawn["rope"] * ELEMENTS
    mass_kg = np.repeat(rope_N_m / (2.0 * np.pi * drawn["own_Hz"] * ELEMENTS) ** 2, ELEMENTS, axis=1)
    damping_N_s_m = DAMPING * np.sqrt(rope_N_m * mass_kg[:, :1])
    mass_kg[:, -1:] += np.minimum(weight_N / GRAVITY_M_S2, cell_N_m / (8.0 * np.pi) ** 2)
    step_s = 1.0 / (float(drawn["own_Hz"].max()) * ELEMENTS * STEPS_PER_PERIOD)
    ends_s = drawn["rest_s"] + 1.4 * climb_s + drawn["slide_s"]
    # The rope was laid on with some friction the other way: its tension falls from the weight to the cell.
    angles = wrap * np.arange(ELEMENTS) / ELEMENTS
    tension_N = weight_N * np.exp(-drawn["begin"] * static * (wrap - angles))
    stretch_m = tension_N / np.concatenate([cell_N_m, np.repeat(rope_N_m, ELEMENTS - 1, axis=1)], axis=1)
    x_m = -np.cumsum(stretch_m, axis=1)
    v_m_s, fresh, motor_m, still_m = (
        np.zeros_like(x_m),
        np.ones_like(x_m),
        np.zeros_like(wrap),
        x_m[:, -1].copy(),
    )
    waves = rng.uniform(0.0, 2.0 * np.pi, (len(wrap), 3, 1))
    lengths_m = (1.0 + 4.0 * rng.random((len(wrap), 3, 1))) * way_m[:, None]
    distance_m, healed = drawn["distance"] * way_m, np.exp(-step_s / drawn["heal_s"])
    kept = []
    for number in range(int(np.ceil(float(ends_s.max()) / step_s))):
        pulling_s = np.maximum(number * step_s - drawn["rest_s"], 0.0)
        soft = np.minimum(pulling_s / (drawn["soft_s"] * climb_s), 1.0)
        motor_m += step_s * SPEED_M_S * soft * (motor_m < drawn["stop"] * way_m)
        cell_N = (motor_m - x_m[:, :1]) * cell_N_m
        beside_N = np.concatenate([cell_N, rope_N_m * (x_m[:, :-1] - x_m[:, 1:]), weight_N], axis=1)
        apart_m_s = np.concatenate([-v_m_s[:, :1], v_m_s[:, :-1] - v_m_s[:, 1:], np.zeros_like(wrap)], axis=1)
        pulled_N = beside_N + damping_N_s_m * apart_m_s
        free_m_s = v_m_s + step_s * (pulled_N[:, :-1] - pulled_N[:, 1:]) / mass_kg
        normal_N = 0.5 * np.maximum(beside_N[:, :-1] + beside_N[:, 1:], 0.0) * wrap / ELEMENTS
        rough = 1.0 + drawn["roughness"] * np.sin(2.0 * np.pi * x_m[:, None] / lengths_m + waves).sum(axis=1)
        brake_m_s = step_s * (kinetic + (static - kinetic) * fresh) * rough * normal_N / mass_kg
        v_m_s = np.sign(free_m_s) * np.maximum(np.abs(free_m_s) - brake_m_s, 0.0)
        x_m += step_s * v_m_s
        worn = fresh * np.exp(-step_s * np.abs(v_m_s) / distance_m)
        fresh = np.where(v_m_s == 0.0, 1.0 - (1.0 - fresh) * healed, worn)
        if number % max(1, round(1.0 / (KEPT_HZ * step_s))) == 0:
            kept.append((number * step_s, cell_N[:, 0], x_m[:, -1] - still_m))
    time_s, force_N, travel_m = (np.array(one) for one in zip(*kept, strict=True))
    return time_s, force_N.T, travel_m.T, ends_s[:, 0], distance_m[:, 0]


def _truth(force_N, travel_m, distance_m):
    """Return status and index of the break-away; None where nobody could say."""
    moved = np.flatnonzero(travel_m > 3.0 * distance_m)
    if not moved.size:
        return ("no-breakaway", 0) if travel_m.max() < 0.1 * distance_m else None
    begun = int(np.flatnonzero(travel_m[: moved[0]] <= 0.02 * travel_m[moved[0]]).max(initial=0))
    after_N = force_N[begun:]
    fall_N = np.maximum.accumulate(after_N) - after_N
    fallen = np.flatnonzero(fall_N > FALL * after_N.max())
    if not fallen.size:
        return ("no-peak", 0) if fall_N.max() < LOWEST_FALL * after_N.max() else None
    top = begun + int(np.argmax(after_N[: fallen[0] + 1]))
    # An attempt that stopped short of the weight, as high as the break-away.
    earlier_N = np.maximum.accumulate(force_N[: top + 1]) - force_N[: top + 1]
    return (
        None
        if earlier_N[force_N[: top + 1] < 0.98 * force_N[top]].max(initial=0.0) > FALL * force_N[top]
        else ("ok", top)
    )


def pulls(seed, count):
    """Yield about so many recordings with known truth."""
    rng = np.random.default_rng([seed, 3])
    time_s, *machines = _motion(rng, _machines(rng, count))
    for force_N, travel_m, end_s, distance_m in zip(*machines, strict=True):
        n = int(np.searchsorted(time_s, end_s))
        known = _truth(force_N[:n], travel_m[:n], distance_m)
        if known is None:
            continue
        status, top = known
        size_N = float(force_N[:n].max())
        read_s = np.arange(0.0, time_s[n - 1], float(np.exp(-rng.uniform(np.log(150.0), np.log(2500.0)))))
        noise_N = size_N * float(np.exp(rng.uniform(np.log(2e-4), np.log(6e-3))))
        read_N = np.interp(read_s, time_s[:n], force_N[:n]) + noise_N * rng.standard_normal(read_s.size)
        count_N = size_N * rng.uniform(1.1, 4.0) / 2.0 ** int(rng.integers(10, 17))
        seen = (float(time_s[top]), float(force_N[top])) if status == "ok" else (np.nan, np.nan)
        yield Pull(read_s, np.rint(read_N / count_N) * count_N, status, *seen)
