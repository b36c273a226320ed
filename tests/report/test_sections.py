"""Text and pages of sections: aligned, folded where it may be, nothing lost, nothing that is not a number shown."""

import math
import re
from pathlib import Path

import ropefric as rf
from ropefric.friction.laws import ALL_LAWS
from ropefric.report.page import Chapter, Report, as_html
from ropefric.report.parts import diagnosis_section
from ropefric.section import WIDTH, Section, as_text, plain

TABLE = Section(
    headings=("law", "ΔAICc", "why "), rows=(("constant", "0.0", "won"), ("coupled", "1234.5", ""))
)
TRIALS = Path(__file__).parents[2] / "fits" / "prth-trials.csv"
LONG = " ".join(["friction"] * 40)


def test_numbers_stand_right_and_words_left():
    lines = as_text([TABLE]).splitlines()
    assert lines == ["law        ΔAICc  why", "constant     0.0  won", "coupled   1234.5"]


def test_sentences_are_folded_and_arithmetic_is_not():
    folded = as_text([Section(title="A", lines=(LONG,), notes=(LONG,))]).splitlines()
    assert max(map(len, folded)) <= WIDTH
    assert " ".join(" ".join(folded[1:]).replace("-", " ").split()) == f"{LONG} {LONG}"
    assert [line[:4] for line in folded if line.startswith("  -")] == ["  - "]
    assert f"  {LONG}" in as_text([Section(title="A", lines=(LONG,), verbatim=True)]).splitlines()


def test_sections_are_set_apart():
    assert (
        as_text([Section(title="A", lines=("a",)), Section(title="B", lines=("b",))]) == "A\n  a\n\nB\n  b\n"
    )


def test_a_page_holds_what_the_text_holds_and_escapes_it():
    section = TABLE._replace(title="x & y", lines=("<script>",), notes=("n",))
    page = as_html(Report("a < b", "", (Chapter("result", "Result", (section,)),)))
    for words in ("<title>a &lt; b</title>", "x &amp; y", "&lt;script&gt;", "<td>1234.5</td>", "<li>n</li>"):
        assert words in page
    assert "<script>" not in page
    assert page.count("<tr>") == page.count("</tr>") == 3


def test_what_is_no_number_is_shown_as_none():
    shown = {math.nan: "–", math.inf: "∞", -math.inf: "−∞", None: "–", 0.0: "0", 1234567.0: "1.235e+06"}
    assert [plain(value) for value in shown] == [*shown.values()]


def test_long_headings_are_folded_where_that_makes_a_table_fit():
    headings = ["point", *(f"Effective tension {i} [N]" for i in range(8))]
    lines = as_text([Section(headings=headings, rows=[["1", *["792.1"] * 8]])]).splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert " ".join(" ".join(lines[:-1]).split()).count("Effective") == 8
    assert lines[-1].split() == ["1", *["792.1"] * 8]
    wide = Section(headings=("standard error", "meaning "), rows=[["0.1", LONG]])
    assert as_text([wide]).splitlines()[0] == "standard error  meaning"


def test_causes_that_are_undetermined_are_one_line():
    found = rf.diagnose(TRIALS, rf.compare(TRIALS, ["coupled"]))
    notes = diagnosis_section(found).notes
    supported = [one.cause for one in found.causes if one.supported == "yes"]
    assert [note.partition(":")[0] for note in notes] == [*supported, "not supported", "undetermined"]
    open_ = ", ".join(one.cause for one in found.causes if one.supported == "cannot-tell")
    assert notes[-1] == f"undetermined: {open_}; `ropefric diagnose` names the tests that decide"


def test_the_equation_of_a_law_has_its_parameters():
    for law in ALL_LAWS.values():
        names = set(re.findall(r"[A-Za-z]\w*", law.equation))
        for item in law.parameters:
            # A parameter whose name says more than its symbol names the symbol in its meaning.
            assert item.name in names or any(f" {word} " in f" {item.meaning} " for word in names), item.name
