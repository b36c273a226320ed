"""The study of broken lines breaks what it says; with ROPEFRIC_MUTANTS=60 the long run asks if the suite notices."""

import ast
import os
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from mutants import ROOMS, ROOT, draw, ranked_tests, study


@pytest.mark.slow
def test_each_mutant_breaks_one_line_of_a_room():
    mutants = draw(40, seed=1)
    assert len({(mutant.path, mutant.line) for mutant in mutants}) == 40
    for mutant in mutants:
        assert mutant.path.as_posix().startswith(tuple(f"ropefric/{room}" for room in ROOMS))
        whole = ast.unparse(ast.parse((ROOT / mutant.path).read_text(encoding="utf-8")))
        pairs = zip(whole.splitlines(), mutant.text.splitlines(), strict=True)
        assert sum(old != new for old, new in pairs) == 1


@pytest.mark.slow
def test_a_change_elsewhere_leaves_the_draw_as_it_is(tmp_path):
    shutil.copytree(ROOT / "ropefric", tmp_path / "ropefric", ignore=shutil.ignore_patterns("__pycache__"))
    before = draw(40, seed=1)
    drawn = {(mutant.path, mutant.line) for mutant in before}
    path = min(mutant.path for mutant in before)
    lines = (tmp_path / path).read_text(encoding="utf-8").splitlines()
    assert (path, len(lines)) not in drawn
    (tmp_path / path).write_text("\n".join(["# moved down by a line", *lines, ""]), encoding="utf-8")
    assert [mutant.key for mutant in draw(40, seed=1, root=tmp_path)] == [mutant.key for mutant in before]


@pytest.mark.slow
def test_tests_that_import_a_module_come_before_all_others():
    found = ranked_tests(Path("ropefric/trials/outliers.py"), ROOT)
    distances = {path.relative_to(ROOT).as_posix(): distance for distance, path in found}
    assert distances["tests/trials/test_rules.py"] == 1
    assert distances["tests/systems/hoist/test_effects.py"] > 1
    assert [distance for distance, _ in found] == sorted(distances.values())


@pytest.mark.slow
@pytest.mark.skipif(
    "ROPEFRIC_MUTANTS" not in os.environ, reason="an hour for 60 of them: set ROPEFRIC_MUTANTS"
)
def test_the_suite_notices_broken_lines():
    noticed, counted = study(int(os.environ["ROPEFRIC_MUTANTS"]), seed=2026)
    assert noticed >= 0.95 * counted
