"""Figure and page show what was measured, and nothing that was not."""

import csv
import math
from dataclasses import replace

import pytest

from ropefric.accuracy.measure import Machine
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import ROUNDING, Case, Measured, Study, StudyResult
from ropefric.plotting.work_precision import draw_work_precision
from ropefric.report.cost_page import cost_sections, write_cost

MACHINE = Machine(cpu="Z80 & more", cores=2, system="CP/M", python="3.13", numpy="2.0", scipy="1.14")


def point(case, method, error, seconds, setting="", *, n=1):
    return Measured(case=case, method=method, setting=setting, error=error, seconds=seconds, evaluations=n,
                    lower_s=0.9 * seconds, upper_s=1.2 * seconds, repeats=5, loops=100)  # fmt: skip


@pytest.fixture(scope="module")
def result():
    """Two cases: slow and sure against quick and rough, and a case that one method cannot solve."""
    cases = (Case(name="easy", title="a case", settings=tuple),
             Case(name="hard", title="a < b case", settings=tuple))  # fmt: skip
    study = Study(name="made-up", title="A study", question="Why?", reference="by hand", counted="steps", cases=cases,
                  used="by hand, with care", findings=lambda points: (f"{len(points)} points.",))  # fmt: skip
    points = (*(point("easy", "slow", 10.0**-n, 1e-4 * n, f"n = {n}", n=n) for n in (1, 3, 5)),
              *(point("easy", "quick", 0.05 / n, 1e-6 * n, f"n = {n}", n=n) for n in (1, 2, 4)),
              point("easy", "exact", 0.0, 1e-2, "n = 1"), point("hard", "slow", math.inf, 1e-4, "n = 1"),
              point("hard", "exact", 1e-15, 1e-2, "n = 1"))  # fmt: skip
    return StudyResult(study=study, points=points, quick=True)


def test_one_panel_a_case_with_a_line_a_method_and_the_front_marked(result):
    drawn = draw_work_precision(result)
    easy, hard = drawn.figure.axes
    assert (easy.get_xscale(), easy.get_yscale()) == ("log", "log")
    assert easy.get_xlim()[0] > easy.get_xlim()[1], "more accurate is further right"
    lines = {container.get_label(): container.lines[0] for container in easy.containers}
    assert list(lines) == ["slow", "quick", "exact"]
    assert lines["quick"].get_xdata().tolist() == [0.05, 0.025, 0.0125]
    assert lines["exact"].get_xdata().tolist() == [ROUNDING], "an error of zero is drawn at rounding"
    assert len({line.get_marker() for line in lines.values()}) == 3, "markers tell the methods apart in grey"
    (same,) = hard.containers
    assert (same.get_label(), same.lines[0].get_color()) == ("exact", lines["exact"].get_color())
    (front,) = [line for line in easy.lines if line.get_label() == "fastest for its error"]
    assert front.get_xdata().tolist() == [0.05, 0.025, 0.0125, 1e-3, 1e-5, ROUNDING]
    assert (front.get_ydata()[1:] > front.get_ydata()[:-1]).all()
    (legend,) = drawn.figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert sorted(names) == ["exact", "fastest for its error", "quick", "slow"]
    assert "exact" in drawn.alt


def test_cases_whose_settings_do_not_differ_share_a_panel_of_times(result):
    piles = tuple(Case(name=name, title="a closed form", settings=tuple) for name in ("rope", "belt"))
    more = tuple(point(case.name, method, error, seconds, f"{n}") for case in piles for n in (1, 2)
                 for method, error, seconds in (("exact", 0.0, 1e-3 * n), ("quick", 0.2, 1e-5 * n)))  # fmt: skip
    study = replace(result.study, cases=result.study.cases + piles)
    drawn = draw_work_precision(StudyResult(study=study, points=result.points + more, quick=True))
    *_, times = drawn.figure.axes
    assert len(drawn.figure.axes) == 3
    assert [label.get_text() for label in times.get_yticklabels()] == ["rope", "belt"]
    lines = {container.get_label(): container.lines[0] for container in times.containers}
    assert lines["exact"].get_xdata().tolist() == [1e-3, 1e-3], "the quickest setting of a method"
    assert lines["quick"].get_ydata().tolist() == [0, 1]


def test_errors_that_differ_by_less_than_a_decade_have_a_panel_of_their_own(result):
    """Draws of an interval come closer slowly; two such cases are no pile."""
    cases = tuple(Case(name=name, title="an interval", settings=tuple) for name in ("arms", "coverage"))
    points = tuple(point(case.name, "draws", error, 1e-3 * n, f"{n}") for case in cases
                   for n, error in ((1, 0.18), (2, 0.1), (3, 0.06)))  # fmt: skip
    drawn = draw_work_precision(
        StudyResult(study=replace(result.study, cases=cases), points=points, quick=True)
    )
    titles = [axes.get_title(loc="left") for axes in drawn.figure.axes]
    assert titles == ["arms: an interval", "coverage: an interval"]


def test_the_page_answers_for_each_accuracy_and_first_for_the_ordinary_cases(result):
    head, section = cost_sections([result], MACHINE)
    assert "Z80" in head.lines[0]
    assert "a quick look" in head.lines[1]
    (row,) = head.rows
    assert row[:2] == ("made-up", "by hand, with care")
    assert row[3].startswith("slow, n = 5: 500 µs")
    rows = {row[0]: row[1:] for row in section.rows}
    assert list(rows) == ["1e-2 to 1e-3", "1e-4 to 1e-5", "1e-6 to 1e-12"]
    assert rows["1e-4 to 1e-5"][0].startswith("slow, n = 5: 500 µs")
    assert rows["1e-6 to 1e-12"][1].startswith("exact, n = 1: 10 ms")
    assert list(section.notes) == ["9 points."]
    assert cost_sections([], MACHINE)[0].headings == ()


@pytest.mark.slow
def test_table_and_page_stand_beside_their_figures(result, tmp_path):
    folder = tmp_path / "new" / "folder"
    paths = {path.name: path for path in write_cost([result], MACHINE, folder)}
    assert set(paths) == {"made-up.png", "made-up.csv", "cost.html"}
    page, table = (paths[name].read_text(encoding="utf-8") for name in ("cost.html", "made-up.csv"))
    assert "9 points." in page
    assert "by hand" in page
    assert 'role="img" aria-label="A study: time over error' in page
    assert "Z80 &amp; more" in page
    assert "a &lt; b case" in page
    assert "cheapest to 1e-\u206012" in page, "no power of ten is broken between lines"
    assert "1e-\u20602 to 1e-\u20603" in page
    rows = list(csv.DictReader(table.splitlines()))
    header = ["case", "method", "setting", "error", "seconds", "spread_s", "evaluations"]
    assert list(rows[0])[:7] == header
    assert len(rows) == len(result.points), "also those without an answer"
    assert [row["on_front"] for row in rows if row["case"] == "easy"] == ["false", *["true"] * 6]
    assert float(rows[0]["spread_s"]) == pytest.approx(0.3 * float(rows[0]["seconds"]))
    assert rows[-2]["error"] == "inf"


def test_a_busy_machine_is_told(result):
    assert result.unsteady == 0.0
    shaken = tuple(replace(p, upper_s=2.0 * p.seconds) if p.method == "quick" else p for p in result.points)
    busy = replace(result, points=shaken)
    assert busy.unsteady == pytest.approx(3 / 9)
    assert "33 % of the times spread" in cost_sections([busy], MACHINE)[1].notes[-1]


def test_the_largest_step_of_runge_kutta_is_told_of_the_belts_that_were_measured():
    found = STUDIES["press-transient"].findings
    (sentence,) = found((point("stiff", "rk4", 1e-6, 0.2, "step 0.5 ms"),))
    assert sentence == "RK4 is stable up to a step of 0.513 ms (stiff)."
    assert found(()) == ()
