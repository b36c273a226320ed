"""What the friction tests share: a plan of pulls."""

import pytest

from ropefric.testing import bench


@pytest.fixture
def plan():
    """6 wheels x 6 wraps x 6 loads, as on a bench."""
    return bench()
