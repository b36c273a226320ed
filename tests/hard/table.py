"""All hard regimes, and the Markdown table of them from what is measured here and now: `python tests/hard/table.py`."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import hard_laws
import hard_machines
import hard_saw
import hard_traces
from hard_regime import FACTS, REFUSALS, REGIMES

__all__ = ["FACTS", "HEAD", "MODULES", "REFUSALS", "REGIMES", "table"]

MODULES = (hard_laws, hard_machines, hard_saw, hard_traces)
HEAD = ("regime", "checked", "against", "stated", "measured")


def table() -> str:
    """Return the table, one regime a row."""
    rows = [HEAD, tuple("---" for _ in HEAD)]
    rows += [one.row(None if one.tolerance is None else one.measure()) for one in REGIMES.values()]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |\n" for row in rows)


if __name__ == "__main__":
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    sys.stdout.write(table())
