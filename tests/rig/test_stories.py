"""How the picker fares on recordings drawn piece by piece, which share no equation with the rigs."""

from collections import Counter

import numpy as np
import pytest
from recordings import judged, pick

from ropefric.rig.pulls import Truth
from ropefric.rig.stories import KINDS, State, draw_recordings
from ropefric.traces.breakaway import Status
from ropefric.traces.trace import ForceTrace


def test_a_recording_is_the_same_each_time_and_its_labels_belong_to_it():
    for one, again in zip(draw_recordings(3, 40), draw_recordings(3, 20), strict=False):
        assert np.array_equal(one.force_N, again.force_N)
    for one in draw_recordings(3, 40):
        assert one.kind in KINDS
        assert one.time_s.shape == one.force_N.shape == one.state.shape
        assert (np.diff(one.time_s) > 0.0).all()
        if one.status is Status.OK:
            at = int(np.searchsorted(one.time_s, one.breakaway_s))
            assert State.LOADING in one.state[: at + 1]
            assert {State.SLIP, State.SLIDING, State.LOADING} & set(one.state[at : at + 3].tolist())
            assert one.time_s[0] < one.breakaway_s < one.time_s[-1]


@pytest.mark.slow
def test_the_picker_on_recordings_that_no_rig_made():
    """Half of them right and an eighth wrong is what rules reach on machines so varied; a picker has to do better."""
    counts = Counter()
    for one in draw_recordings(2026, 200):
        found = pick(ForceTrace(time_s=one.time_s, force_N=one.force_N))
        counts[judged(Truth(one.status, one.peak_N, one.breakaway_s), found)] += 1
    assert counts["right"] > 0.5 * counts.total(), counts
    assert counts["wrong"] < 0.14 * counts.total(), counts
