"""What the friction tests share: a plan of pulls, and 50-digit references as a fixture."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from ropefric.friction.condition import Conditions


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
    wheel, wrap, load = np.meshgrid(
        [0.02, 0.03, 0.04, 0.06, 0.08, 0.12],
        np.pi * np.array([0.5, 1, 2, 3, 4, 6]),
        [2.0, 5.0, 10.0, 20.0, 80.0, 200.0],
    )
    return Conditions(
        wheel_radius_m=wheel.ravel(),
        rope_radius_m=0.0049,
        wrap_angle_rad=wrap.ravel(),
        end_tension_N=load.ravel(),
    )
