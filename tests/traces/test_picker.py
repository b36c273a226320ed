"""The trained picker: what it says does not hang on units, on how long a recording is, or on a processor."""

from fractions import Fraction

import numpy as np
import pytest
from drawn import PULL, TIME_S, drawn, line, picked

from ropefric.traces import decision, picker
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.picker import Look, State
from ropefric.traces.segments import prepare
from ropefric.traces.trace import ForceTrace


def ordinary(seed):
    """Return a pull as any lab has: rest, climb, a peak 2 to 25 % above sliding, let down; and when it broke away."""
    rng = np.random.default_rng([38, seed])
    rate_Hz, climb_s, rest_s = (
        np.exp(rng.uniform(*np.log((100.0, 3000.0)))),
        rng.uniform(0.8, 4.0),
        rng.uniform(0.4, 2.0),
    )
    slid_s = rng.uniform(1.0, 5.0)
    top_s, down_s = rest_s + climb_s, rest_s + climb_s + slid_s
    time_s = np.arange(0.0, down_s + rng.uniform(0.2, 1.5), 1.0 / rate_Hz)
    climb = np.clip((time_s - rest_s) / climb_s, 0.0, 1.0) ** rng.uniform(0.9, 1.5)
    slides = 1.0 / (1.0 + rng.uniform(0.02, 0.25))
    fallen = np.clip((time_s - top_s) / rng.uniform(0.004, 0.08), 0.0, 1.0)
    force = np.where(time_s > top_s, 1.0 - (1.0 - slides) * fallen**2 * (3.0 - 2.0 * fallen), climb)
    force = force * np.clip(1.0 - (time_s - down_s) / rng.uniform(0.05, 0.3), 0.0, 1.0)
    force += rng.uniform(3e-4, 4e-3) * rng.standard_normal(time_s.size)
    return time_s, 100.0 * force, (top_s, down_s)


def found_in(time_s, force_N):
    return decision.pick_breakaway(
        ForceTrace(time_s=time_s, force_N=force_N), PickSettings(rest="pretension")
    )[0]


@pytest.mark.parametrize("count", [20, pytest.param(400, marks=pytest.mark.slow)])
def test_ordinary_pulls_are_right_and_sure_and_do_not_hang_on_where_the_recording_begins_and_ends(count):
    right = same = cut_right = 0
    for seed in range(count):
        time_s, force_N, (top_s, down_s) = ordinary(seed)
        found = found_in(time_s, force_N)
        assert found.status in {Status.OK, Status.DOUBTFUL}
        right += found.status is Status.OK and abs(found.peak_N - 100.0) < 2.0
        assert found.status is not Status.OK or abs(found.peak_N - 100.0) < 2.0
        # Rest and sliding shorter by a third.
        kept = (time_s > 0.3 * time_s[time_s < 0.4].max()) & (time_s < down_s - 0.3 * (down_s - top_s))
        cut = found_in(time_s[kept], force_N[kept])
        cut_right += cut.status is Status.OK
        if found.status is cut.status is Status.OK:
            same += abs(cut.peak_N - found.peak_N) <= 2.0 * found.peak_std_N
    assert min(right, cut_right) >= 0.97 * count
    assert same >= 0.995 * min(right, cut_right)


def test_probabilities_add_up_and_hang_on_neither_unit_nor_clock():
    force_N = drawn(*PULL)
    seen = picker.look(TIME_S, force_N)
    assert seen.place.sum() + sum(seen.reasons.values()) == pytest.approx(1.0)
    np.testing.assert_allclose(seen.states.sum(axis=1), 1.0)
    for times, over in ((1.0, 2.0**10), (2.0**-6, 1.0)):
        other = picker.look(times * TIME_S, over * force_N)
        np.testing.assert_allclose(other.place, seen.place, atol=1e-6)
    found = decision.judge(prepare(ForceTrace(time_s=TIME_S, force_N=force_N), PickSettings()))
    total = sum(one.probability for one in found.candidates) + sum(found.reasons.values())
    assert total == pytest.approx(1.0, abs=0.06)  # rounded to two digits, and what is fainter left out
    assert found.candidates[0].first_s < 3.0 < found.candidates[0].last_s + 0.01


def test_every_sum_is_exact_whichever_way_it_is_added_up():
    """Sums of multiples of a power of two that a float holds are the same on every kernel of every processor."""
    rng = np.random.default_rng(5)
    weights = picker.stored_weights()
    for name in ("stem", "left3a", "right0b", "top"):
        kernel = weights[f"{name}.w"]
        values = (
            np.rint(rng.uniform(0.0, picker.LARGEST, kernel.shape[0]) * picker.ACTIVATION_GRID)
            / picker.ACTIVATION_GRID
        )
        for column in kernel.T[:3]:
            exact = sum(
                (Fraction(float(a)) * Fraction(float(b)) for a, b in zip(values, column, strict=True)),
                Fraction(0),
            )
            assert Fraction(float(values @ column)) == exact
            assert Fraction(float(sum(values[::-1] * column[::-1]))) == exact
    for name, values in weights.items():
        if name not in {"temperature", "rarer"}:  # these come after all sums
            assert (np.rint(values * picker.WEIGHT_GRID) == values * picker.WEIGHT_GRID).all(), name


def test_two_looks_that_disagree_are_a_doubt(monkeypatch):
    """At first sight the top at 3 s; from near, half of what is likely lies at 2 s, where the force is another."""
    force_N, edges_s = drawn(*PULL), np.linspace(TIME_S[0], TIME_S[-1], picker.BINS + 1)

    def look(time_s, _, weights):
        place, edges = np.zeros(picker.BINS), np.linspace(time_s[0], time_s[-1], picker.BINS + 1)
        share = {3.0: 0.98} if time_s.size == TIME_S.size else {3.0: 0.5, 2.2: 0.48}
        for at_s, one in share.items():
            place[np.searchsorted(edges, at_s) - 1] = one
        states = np.zeros((picker.BINS, len(State)))
        states[:, State.LOADING] = edges[:-1] > 2.6
        states[:, State.REST] = edges[:-1] <= 2.6
        return Look(edges, place, dict.fromkeys(picker.REASONS, 0.02 / 3.0), states)

    monkeypatch.setattr(decision, "look", look)
    found = picked(force_N)
    assert found.status is Status.DOUBTFUL, edges_s.size
    assert [one.force_N for one in found.candidates] == pytest.approx([100.0, 60.0], abs=0.5)
    assert "(0.49) or 60.08 N" in found.detail
    assert "(0.47)" in found.detail


ODD = {
    "sine": lambda x, u: np.sin(2 * np.pi * u(1, 30) * x) + u(-1, 1),
    "square wave": lambda x, u: np.sign(np.sin(2 * np.pi * u(1, 12) * x + u(0, 6))),
    "random walk": lambda x, u: np.cumsum(u(-1, 1, x.size)),
    "heartbeat": lambda x, u: sum(
        np.exp(-0.5 * ((x - at) / 0.004) ** 2) for at in np.arange(0.05, 1, u(0.05, 0.2))
    ),
    "bumps": lambda x, u: sum(
        u(0.2, 1) * np.exp(-0.5 * ((x - u(0, 1)) / u(0.01, 0.1)) ** 2) for _ in range(5)
    ),
    "decay": lambda x, u: np.exp(-x * u(1, 20)),
    "triangles": lambda x, u: 1 - np.abs(2 * ((x * int(u(1, 9))) % 1) - 1),
    "temperature": lambda x, u: 20 + 3 * np.sin(2 * np.pi * x * u(0.5, 3)) + x * u(-3, 3),
}


def test_what_is_no_pull_at_all_is_hardly_ever_given_a_force():
    """A triangle that falls as fast as it rises may pass for a pull; the rules before gave a force to one in eight."""
    given = []
    for name, seed in ((name, seed) for name in ODD for seed in range(2)):
        rng = np.random.default_rng([seed, 3])
        part = np.linspace(0.0, 1.0, int(rng.integers(300, 8000)))
        force = ODD[name](part, rng.uniform)
        force = 100.0 * force / np.ptp(force) + 0.3 * rng.standard_normal(part.size)
        if found_in(part * rng.uniform(1.0, 50.0), force).status is Status.OK:
            given.append(name)
    assert len(given) <= 1, given


def test_the_highest_mean_before_the_first_fall_is_what_it_says():
    force_N = drawn(
        (0.0, 0.0), (1.0, 0.0), (2.0, 60.0), (2.01, 50.0), (4.0, 100.0), (4.01, 70.0), (6.0, 70.0)
    )
    first = picked(force_N, PickSettings(picker="highest", min_step_N=5.0, rest="pretension"))
    later = picked(force_N, PickSettings(picker="highest", min_step_N=20.0, rest="pretension"))
    assert (first.peak_N, later.peak_N) == (pytest.approx(60.0, abs=0.3), pytest.approx(100.0, abs=0.3))
    assert first.peak_std_N == pytest.approx(0.1 / np.sqrt(5), rel=0.2)
    never = picked(line((0.0, 0.0), (6.0, 100.0)), PickSettings(picker="highest"))
    assert never.status is Status.NO_BREAKAWAY
