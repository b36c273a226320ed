"""The measured blocks of the docs are what the script would write, apart from the machine it ran on."""

import math
from pathlib import Path

import pytest
import regenerate_readme as script
import small_campaigns

from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.studies.picks import PICKERS

ROOT = Path(__file__).parents[2]
PAGE = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("accuracy.md", "cost.md"))


@pytest.fixture(scope="module")
def cost_block():
    return script.cost_block("Z80")


def without_machine(block):
    return [line for line in block.splitlines() if not line.startswith(script.MACHINE_LINE)]


def test_the_page_says_what_the_studies_say(cost_block):
    shown = block_of("cost")
    again = "run python tests/regenerate_readme.py"
    assert without_machine(shown) == without_machine(cost_block), again
    for name in script.PICTURES:
        assert (ROOT / "data" / "pictures" / f"cost-{name}.png").stat().st_size < 80_000


def test_every_number_of_the_block_comes_from_a_study(cost_block):
    assert cost_block.count("](../data/pictures/cost-") == len(script.PICTURES)
    assert cost_block.endswith("Times in the pictures: Z80.\n")
    for said in ("512 pieces", "8 points", "error of 4.2 %", "order 24 in one", "steps above 0.51 ms",
                 "4 of 5 effects"):  # fmt: skip
        assert said in cost_block


def block_of(name):
    return PAGE.split(f"<!-- {name} -->\n", 1)[1].split("<!-- end -->", 1)[0]


def test_the_page_compares_all_quick_pickers_on_all_recordings():
    rows = [[cell.strip() for cell in line.split("|")] for line in block_of("picks").splitlines()[2:]]
    pickers = [
        f"{method}, {setting}" if setting else method for method, setting, _, quick in PICKERS if quick
    ]
    wanted = [[case.name, name] for case in STUDIES["picks"].cases for name in pickers]
    assert [row[1:3] for row in rows] == wanted, "run python tests/regenerate_readme.py picks"


@pytest.mark.release
def test_the_page_says_how_many_intervals_hold_the_truth():
    """Every design stands there; those that take little time are counted again."""
    shown = block_of("uncertainty").splitlines()
    assert [line.split(" | ")[0] for line in shown[2:]] == [
        f"| {one.name}" for one in small_campaigns.DESIGNS
    ]
    few = [one for one in small_campaigns.DESIGNS if one.law == "constant"]
    again = small_campaigns.uncertainty_block(few).splitlines()
    assert len(again) == 4
    assert set(again) <= set(shown), "run python tests/regenerate_readme.py uncertainty"


def test_the_page_says_how_often_verdicts_are_wrong():
    """Every number of conditions stands there, and no design is beyond a twentieth by more than two of its errors."""
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in block_of("verdicts").splitlines()
    ]
    wrong = [row for row in rows if len(row) == 10 and row[0].isdigit()]
    found = [row for row in rows if len(row) == 5 and row[0].isdigit()]
    for counts, table in ((small_campaigns.WRONG, wrong), (small_campaigns.FOUND, found)):
        again = "run tests/regenerate_readme.py verdicts"
        assert {int(size): int(n) for size, n, *_ in table} == counts, again
    for _, n, *shares in wrong:
        room = 2.0 * math.sqrt(0.05 * 0.95 / int(n))
        assert all(float(share.split("\N{NO-BREAK SPACE}")[0]) <= 100.0 * (0.05 + room) for share in shares)


def test_blocks_go_between_their_markers_and_nowhere_else():
    text = "a\n<!-- cost -->\nold\nlines\n<!-- end -->\nb\n<!-- other -->\nkept\n<!-- end -->\n"
    made = script.with_blocks(text, {"cost": "new \\1\n", "hard-cases": "not asked for\n"})
    assert made == text.replace("old\nlines\n", "new \\1\n")
    assert script.with_blocks(made, {"cost": "new \\1\n"}) == made
