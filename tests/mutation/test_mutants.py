"""The study of broken lines breaks what it says; with ROPEFRIC_MUTANTS=40 the long run asks if the suite notices."""

import ast
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from mutants import ROOMS, ROOT, draw, study


@pytest.mark.slow
def test_each_mutant_breaks_one_line_of_a_room_and_is_the_same_each_time():
    mutants = draw(40, seed=1)
    assert mutants == draw(40, seed=1)
    assert len({(mutant.path, mutant.line) for mutant in mutants}) == 40
    for mutant in mutants:
        assert mutant.path.as_posix().startswith(tuple(f"ropefric/{room}" for room in ROOMS))
        whole = ast.unparse(ast.parse((ROOT / mutant.path).read_text(encoding="utf-8")))
        changed = [
            (old, new)
            for old, new in zip(whole.splitlines(), mutant.text.splitlines(), strict=True)
            if old != new
        ]
        assert len(changed) == 1


@pytest.mark.slow
@pytest.mark.skipif(
    "ROPEFRIC_MUTANTS" not in os.environ,
    reason="each change of the code draws other lines, and some break nothing: whoever looks at what is missed sets "
    "ROPEFRIC_MUTANTS to their number",
)
def test_the_suite_notices_broken_lines():
    noticed, counted = study(int(os.environ["ROPEFRIC_MUTANTS"]), seed=2026)
    assert noticed >= 0.95 * counted
