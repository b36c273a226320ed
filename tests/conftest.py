"""What all tests share."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
REAL_DATA = ROOT.parent / "shared" / "data"


@pytest.fixture
def real_data():
    """The folder of real recordings; tests that need it skip where it is absent."""
    if not REAL_DATA.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return REAL_DATA
