"""The third and the fourth rig against closed forms of their friction."""

import numpy as np
import pytest

from ropefric.rig.further import ELEMENTS, chains, contacts, pulls
from ropefric.traces.breakaway import Status

SLOW = {
    "weight_N": (20.0, 20.0),
    "wrap": (3.0, 3.0),
    "climb_s": (1.0, 1.0),
    "rest_s": (0.3, 0.3),
    "slide_s": (1.5, 1.5),
}


def that_slip(rig, **given):
    made = [
        one for one in rig(np.random.default_rng(3), 4, **SLOW, **given) if one.slip_m.max() > one.slips_m
    ]
    assert made
    return made


@pytest.mark.release
def test_a_chain_of_one_friction_slides_at_the_force_of_its_elements():
    """On each element it is friction times the mean of the tensions beside it: (1 + μθ/2) / (1 - μθ/2).

    The spring of the cell is damped against the ground, which costs some tenths of a percent.
    """
    even = {"static": (0.2, 0.2), "weakening": (1.0, 1.0), "roughness": (1e-9, 1e-9), "rope": (1.0, 1.0)}
    half = 0.2 * 3.0 / ELEMENTS / 2.0
    for one in that_slip(chains, **even):
        assert one.force_N[-1] == pytest.approx(20.0 * ((1.0 + half) / (1.0 - half)) ** ELEMENTS, rel=5e-3)


@pytest.mark.release
def test_a_chain_breaks_away_between_its_kinetic_and_its_static_friction():
    friction = {"static": (0.2, 0.2), "weakening": (0.7, 0.7), "roughness": (1e-9, 1e-9)}
    for one in that_slip(chains, **friction):
        assert 20.0 * np.exp(0.14 * 3.0) < one.force_N.max() < 20.0 * np.exp(0.2 * 3.0) * 1.01


def test_junctions_alike_break_together_at_the_capstan_force():
    alike = {"static": (0.3, 0.3), "spread": (1e-4, 1e-4), "ageing": (0.0, 0.0)}
    capstan_N = 20.0 * np.exp(0.3 * 3.0)
    for one in that_slip(contacts, **alike):
        is_tared = one.force_N[0] < 1e-9
        assert one.force_N.max() == pytest.approx(capstan_N - 20.0 * is_tared, rel=5e-3)


def test_junctions_slide_at_half_of_what_they_keep_and_what_they_break_at():
    """Each is stretched evenly in time; strengths e^(±w) have the mean sinh(w)/w."""
    friction = {"static": (0.2, 0.2), "spread": (0.3, 0.3), "ageing": (0.0, 0.0), "left": (0.6, 0.6),
                "distance": (0.05, 0.05), "damping": (0.4, 0.4)}  # fmt: skip
    width = np.sqrt(3.0) * 0.3
    mu = 0.2 * 0.5 * (1.0 + 0.6) * np.sinh(width) / width
    for one in that_slip(contacts, **friction):
        after_N = one.force_N[one.time_s > one.time_s[-1] - 1.0] + 20.0 * (one.force_N[0] < 1e-9)
        assert np.log(after_N.mean() / 20.0) / 3.0 == pytest.approx(mu, rel=0.02)


@pytest.mark.parametrize("rig", [pytest.param(chains, marks=pytest.mark.release), contacts])
def test_recordings_of_a_seed_are_the_same_and_their_truth_is_in_them(rig):
    first, again = (list(pulls(np.random.default_rng(5), 2, rig)) for _ in range(2))
    assert first
    for one, other in zip(first, again, strict=True):
        assert np.array_equal(one.force_N, other.force_N)
        if one.status is Status.OK:
            near_N = one.force_N[np.abs(one.time_s - one.breakaway_s) < 0.02]
            assert near_N.max() == pytest.approx(one.peak_N, rel=0.03)
