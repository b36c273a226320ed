"""The table of peers can be made, and both ways of each pair do the same."""

import pytest
from peers import peers_block


@pytest.mark.slow
def test_every_pair_is_timed():
    rows = [line for line in peers_block("here", rounds=1).splitlines() if line.startswith("| ")]
    assert len(rows) == 10
    assert all(len(row.split(" | ")) == 6 for row in rows)
