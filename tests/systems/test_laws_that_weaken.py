"""What the bound of a rope's stiffness rests on: laws that weaken."""

import numpy as np

from ropefric.errors import RopefricError
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS

WEAKENING = sorted(name for name, law in ALL_LAWS.items() if law.weakens)
USUAL = {"A": 5.0, "mu": 0.6, "mu_inf": 0.8, "d": 0.4, "a": 3.0, "b": 3.0}


def parameters(law, rng):
    """Parameters anywhere within the bounds, most of them as they are usual, some at an end."""
    ends = [(max(one.lower, -USUAL.get(one.name, 9.0)), min(one.upper, USUAL.get(one.name, 9.0)))
            for one in law.parameters]  # fmt: skip
    theta = np.array([rng.uniform(low, high) for low, high in ends])
    return np.where(rng.random(theta.size) < 0.1, [end[rng.integers(2)] for end in ends], theta)


def test_a_law_that_weakens_keeps_to_what_that_means():
    for name in WEAKENING:
        law, rng, n = ALL_LAWS[name], np.random.default_rng(1), 40
        wrap = np.geomspace(1e-3, 40.0, n)
        checked = 0
        for _ in range(20):
            theta = parameters(law, rng)
            own = {"wheel_radius_m": 10.0 ** rng.uniform(-2.0, 0.0),
                   "rope_radius_m": 10.0 ** rng.uniform(-3.5, -2.0),
                   "wrap_angle_rad": rng.uniform(0.1, 30.0), "end_tension_N": 10.0 ** rng.uniform(0.0, 4.0)}  # fmt: skip

            def rise(**other):
                at = {key: np.broadcast_to(value, n) for key, value in {**own, **other}.items()}  # noqa: B023
                conditions = Conditions(**at)
                return law.log_lift(theta, conditions) - conditions.log_end_tension  # noqa: B023

            try:
                by_wrap = rise(wrap_angle_rad=wrap)
            except RopefricError:
                continue
            checked += 1
            tiny = 1e-9 * (1.0 + np.abs(by_wrap).max())
            average, slopes = by_wrap / wrap, np.diff(by_wrap) / np.diff(wrap)
            assert by_wrap[0] >= -tiny, name
            bent = np.diff(slopes) - tiny / np.diff(wrap)[:-1]
            assert (bent <= 1e-9 * (1.0 + slopes.max())).all(), "concave"
            assert (np.diff(average) <= 1e-9 * average[:-1] + 1e-12).all(), name
            tension = np.geomspace(1.0, 1e5, n)
            by_tension = rise(end_tension_N=tension)
            assert (np.diff(by_tension) <= tiny).all(), "falls with the tension …"
            assert (np.diff(by_tension + np.log(tension)) >= -tiny).all(), "… no faster than it rises"
            for key in ("wheel_radius_m", "rope_radius_m"):
                steps = np.diff(rise(**{key: own[key] * np.geomspace(0.1, 10.0, n)}))
                assert (steps <= tiny).all() or (steps >= -tiny).all(), key
                assert "size" in law.effects or not steps.any(), key
        assert checked > 4, name
