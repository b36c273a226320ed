"""The table of peers can be made, and both ways of each pair do the same."""

import pytest
from peers import peers_block


@pytest.mark.release
def test_every_pair_is_timed():
    pairs, large = peers_block("here", rounds=1).split("| large input |")
    rows = [line for line in pairs.splitlines() if line.startswith("| ")]
    assert len(rows) >= 10
    assert all(len(row.split(" | ")) == 6 for row in rows)
    assert large.count("\n| ") == 7
