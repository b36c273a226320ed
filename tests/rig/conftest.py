"""Makes what draws recordings for tests of all folders importable under importmode=importlib."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
