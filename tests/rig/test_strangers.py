"""The families of the second rig: same seed same recordings, truths that hold, every tier and kind there."""

import numpy as np
import pytest

from ropefric.rig.strangers import FAMILIES, TIERS, recordings
from ropefric.traces.breakaway import Status

pytestmark = pytest.mark.slow  # a recording of every family takes 7 s


def test_every_family_is_drawn_with_what_it_promises_the_same_each_time():
    drawn = tuple(recordings(11, per_family=1))
    again = {one.family: one for one in recordings(11, per_family=1, families=("snag", "sharp"))}
    assert ([one.family for one in drawn], {one.tier for one in drawn}) == (list(FAMILIES), set(TIERS))
    for one in drawn:
        assert one.truth.status == FAMILIES[one.family].expects
        assert np.isfinite(one.truth.peak_N) == (one.truth.status == Status.OK)
        assert one.family not in again or np.array_equal(again[one.family].force_N, one.force_N)
        trace = one.trace()
        assert trace.time_s.size > 20
        assert (trace.saturation is not None) == (one.family == "clipped-counts")
        if one.truth.status != Status.OK or one.tier != "clean":
            continue
        # The truth is the highest force before the first fall.
        near = np.abs(one.time_s - one.truth.time_s) < 0.01 * one.time_s[-1]
        noise = 5.0 * np.nanstd(np.diff(one.force_N, 2)[:20])
        assert np.nanmax(one.force_N[near]) == pytest.approx(one.truth.peak_N, rel=0.01, abs=noise)
        assert one.force_N[one.time_s > one.truth.time_s].min() < 0.993 * one.truth.peak_N
