"""Makes the modules of this folder importable under importmode=importlib, with their assertions told in full."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
pytest.register_assert_rewrite("hard_regime", "hard_laws", "hard_machines", "hard_saw", "hard_traces")
