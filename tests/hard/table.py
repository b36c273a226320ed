"""The hard cases as a Markdown table, from what is measured here and now: `python tests/hard/table.py`.

Accuracies are rounded up to a power of ten with half a decade to spare, so that the last bit of another machine's
logarithm does not change the table.
"""

import importlib.util
import math
import sys
from pathlib import Path
from types import ModuleType

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER))

__all__ = ["cases", "table"]

HEAD = ("regime", "what holds", "stated", "measured", "test")
FLOOR = 1e-15


def cases() -> list[ModuleType]:
    """Return the test modules that declare a regime, in order of their names."""
    found = []
    for path in sorted(FOLDER.glob("test_*.py")):
        spec = importlib.util.spec_from_file_location(f"hard_case_{path.stem}", path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        if hasattr(module, "REGIME"):
            found.append(module)
    return found


def table() -> str:
    """Return the table, one regime a row."""
    rows = [HEAD, tuple("---" for _ in HEAD)]
    for module in cases():
        regime = module.REGIME
        path = Path(module.__file__ or "").relative_to(FOLDER.parents[1]).as_posix()
        stated = "refused" if regime.accuracy is None else _power(regime.accuracy)
        reached = "refused" if regime.accuracy is None else f"≤ {_power(_rounded(module.measured()))}"
        cells = (regime.name, regime.statement, stated, reached, f"`{path}`")
        rows.append(tuple(cell.replace("|", "\\|") for cell in cells))
    return "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n"


def _rounded(error: float) -> float:
    return 10.0 ** math.ceil(math.log10(max(math.sqrt(10.0) * error, FLOOR)) - 1e-9)


def _power(value: float) -> str:
    return f"1e{round(math.log10(value))}"


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    sys.stdout.write(table())
