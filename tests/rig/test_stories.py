"""Recordings drawn piece by piece: the same ones each time, and their labels belong to them."""

import numpy as np

from ropefric.rig.stories import KINDS, draw_recordings
from ropefric.traces.breakaway import Status
from ropefric.traces.picker import State


def test_a_recording_is_the_same_each_time_and_its_labels_belong_to_it():
    drawn = [*draw_recordings(3, 30)]
    for one, again in zip(drawn, draw_recordings(3, 10), strict=False):
        assert np.array_equal(one.force_N, again.force_N)
    for one in drawn:
        assert one.kind in KINDS
        assert one.time_s.shape == one.force_N.shape == one.state.shape
        assert (np.diff(one.time_s) > 0.0).all()
        if one.status is Status.OK:
            at = int(np.searchsorted(one.time_s, one.breakaway_s))
            assert State.LOADING in one.state[: at + 1]
            assert {State.SLIP, State.SLIDING, State.LOADING} & set(one.state[at : at + 3].tolist())
            assert one.time_s[0] < one.breakaway_s < one.time_s[-1]
