"""Every hard case declares its regime, and the table of them in the docs is what is measured."""

from pathlib import Path

import pytest
import table as hard_table

ROOT = Path(__file__).parents[2]
BEGIN, END = "<!-- hard-cases -->", "<!-- end -->"


def test_every_file_declares_a_regime_of_its_own():
    modules = hard_table.cases()
    files = {path.name for path in hard_table.FOLDER.glob("test_*.py")} - {Path(__file__).name}
    assert {Path(module.__file__).name for module in modules} == files
    assert len({module.REGIME.name for module in modules}) == len(modules)
    for module in modules:
        assert module.__doc__
        assert callable(module.measured)
        assert module.REGIME.accuracy is None or 0.0 < module.REGIME.accuracy <= 1e-8


@pytest.mark.slow
def test_the_page_shows_what_is_measured():
    text = (ROOT / "docs" / "hard-cases.md").read_text(encoding="utf-8")
    shown = _rows(text.split(BEGIN, 1)[1].split(END, 1)[0])
    found = _rows(hard_table.table())
    again = "run python tests/regenerate_readme.py"
    assert [row[:3] + row[4:] for row in shown] == [row[:3] + row[4:] for row in found], again
    for row, new in zip(shown[2:], found[2:], strict=True):
        if "1e" in row[3]:
            # The power of ten that is shown holds here too; another machine's logarithm may round to the next one.
            claimed, measured = (float(cell[3].split()[-1]) for cell in (row, new))
            assert 0.05 <= claimed / measured <= 20.0, again


def _rows(text):
    return [
        [cell.strip() for cell in line.strip().strip("|").split(" | ")] for line in text.strip().splitlines()
    ]
