"""What the friction tests share: a plan of pulls, and 50-digit references as a fixture."""

import importlib.util
from pathlib import Path

import pytest

from ropefric.testing import bench


@pytest.fixture(scope="session")
def reference():
    """The module of independent references; tests are no package, so it is loaded by its path."""
    path = Path(__file__).with_name("reference_50_digits.py")
    spec = importlib.util.spec_from_file_location("reference_50_digits", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def plan():
    """6 wheels x 6 wraps x 6 loads, as on a bench."""
    return bench()
