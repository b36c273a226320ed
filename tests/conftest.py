"""What all tests share."""

import os
from pathlib import Path

import pytest

# Two workers on two cores: linear algebra with threads of its own gets in their way. Set before numpy loads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

ROOT = Path(__file__).parents[1]
REAL_DATA = ROOT.parent / "shared" / "data"


@pytest.fixture
def real_data():
    """The folder of real recordings; tests that need it skip where it is absent."""
    if not REAL_DATA.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return REAL_DATA
