"""Let the tests of the pages find the module that runs their sessions."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
