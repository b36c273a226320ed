"""Figure and page show what was measured, and nothing that was not."""

import csv
import math
from dataclasses import replace

import pytest

from ropefric.accuracy.measure import Machine
from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import ROUNDING, Case, Measured, Study, StudyResult
from ropefric.plotting.figure import save_figure
from ropefric.plotting.work_precision import draw_work_precision
from ropefric.report.cost_page import cost_markdown, cost_sections, write_cost

MACHINE = Machine(cpu="Z80 & more", cores=2, system="CP/M", python="3.13", numpy="2.0", scipy="1.14")


def point(case, method, n, error, seconds):
    return Measured(case=case, method=method, setting=f"n = {n}", error=error, seconds=seconds, evaluations=n,
                    lower_s=0.9 * seconds, upper_s=1.2 * seconds, repeats=5, loops=100)  # fmt: skip


@pytest.fixture
def result():
    """Two cases: slow and sure against quick and rough, and a case that one method cannot solve."""
    cases = (
        Case(name="easy", title="a case", settings=tuple),
        Case(name="hard", title="a < b case", settings=tuple),
    )
    study = Study(name="made-up", title="A study", question="Why?", reference="by hand", counted="steps", cases=cases,
                  findings=lambda points: (f"{len(points)} points.",))  # fmt: skip
    points = (
        *(point("easy", "slow", n, 10.0**-n, 1e-4 * n) for n in (1, 3, 5)),
        *(point("easy", "quick", n, 0.05 / n, 1e-6 * n) for n in (1, 2, 4)),
        point("easy", "exact", 1, 0.0, 1e-2),
        point("hard", "slow", 1, math.inf, 1e-4),
        point("hard", "exact", 1, 1e-15, 1e-2),
    )
    return StudyResult(study=study, points=points, quick=True)


def test_one_panel_a_case_with_a_line_a_method_on_logarithmic_axes(result):
    figure = draw_work_precision(result).figure
    easy, hard = figure.axes
    assert (easy.get_xscale(), easy.get_yscale()) == ("log", "log")
    assert easy.get_xlim()[0] > easy.get_xlim()[1], "more accurate is further right"
    lines = {container.get_label(): container.lines[0] for container in easy.containers}
    assert list(lines) == ["slow", "quick", "exact"]
    assert lines["quick"].get_xdata().tolist() == [0.05, 0.025, 0.0125]
    assert lines["exact"].get_xdata().tolist() == [ROUNDING], "an error of zero is drawn at rounding"
    looks = {(line.get_color(), line.get_linestyle(), line.get_marker()) for line in lines.values()}
    assert len({look[2] for look in looks}) == 3, "markers tell the methods apart in grey"
    assert [container.get_label() for container in hard.containers] == ["exact"]
    same = next(c.lines[0] for c in hard.containers if c.get_label() == "exact")
    assert same.get_color() == lines["exact"].get_color()


def test_the_front_is_marked(result):
    easy = draw_work_precision(result).figure.axes[0]
    (front,) = [line for line in easy.lines if line.get_label() == "fastest for its error"]
    assert front.get_xdata().tolist() == [0.05, 0.025, 0.0125, 1e-3, 1e-5, ROUNDING]
    assert (front.get_ydata()[1:] > front.get_ydata()[:-1]).all()


def test_every_method_is_named_once_below_the_panels(result):
    figure = draw_work_precision(result).figure
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert sorted(names) == ["exact", "fastest for its error", "quick", "slow"]
    assert "exact" in draw_work_precision(result).alt


def test_the_table_has_every_point_also_those_without_an_answer(result, tmp_path):
    paths = save_figure(draw_work_precision(result), tmp_path, "made-up")
    assert [path.name for path in paths] == ["made-up.png", "made-up.csv"]
    with paths[1].open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    header = ["case", "method", "setting", "error", "seconds", "spread_s", "evaluations"]
    assert list(rows[0])[:7] == header
    assert len(rows) == len(result.points)
    marked = [row["on_front"] for row in rows if row["case"] == "easy"]
    assert marked == ["false", *["true"] * 6]
    assert float(rows[0]["spread_s"]) == pytest.approx(0.3 * float(rows[0]["seconds"]))
    assert rows[-2]["error"] == "inf"


def test_the_page_answers_for_each_accuracy(result):
    head, section = cost_sections([result], MACHINE)
    assert "Z80" in head.lines[0]
    assert "a quick look" in head.lines[1]
    rows = {row[0]: row[1:] for row in section.rows}
    assert list(rows) == ["1e-2 to 1e-3", "1e-4 to 1e-5", "1e-6 to 1e-12"]
    assert rows["1e-4 to 1e-5"][0].startswith("slow, n = 5: 500 µs")
    assert rows["1e-6 to 1e-12"][1].startswith("exact, n = 1: 10 ms")
    assert list(section.notes) == ["9 points."]


def test_the_page_begins_with_the_cheapest_of_the_ordinary_cases(result):
    used = replace(result, study=replace(result.study, used="by hand, with care"))
    (row,) = cost_sections([used], MACHINE)[0].rows
    assert row[:2] == ("made-up", "by hand, with care")
    assert row[3].startswith("slow, n = 5: 500 µs")
    assert cost_sections([], MACHINE)[0].headings == ()


def test_no_power_of_ten_is_broken_between_lines(result, tmp_path):
    write_cost([result], MACHINE, tmp_path)
    page = (tmp_path / "cost.html").read_text(encoding="utf-8").partition("<body>")[2]
    assert "cheapest to 1e-\u206012" in page
    assert "1e-\u20602 to 1e-\u20603" in page


def test_markdown_and_html_say_the_same_and_stand_beside_their_figures(result, tmp_path):
    names = {path.name for path in write_cost([result], MACHINE, tmp_path / "new" / "folder")}
    assert names == {"made-up.png", "made-up.csv", "cost.md", "cost.html"}
    page = (tmp_path / "new" / "folder" / "cost.html").read_text(encoding="utf-8")
    text = (tmp_path / "new" / "folder" / "cost.md").read_text(encoding="utf-8")
    assert 'role="img" aria-label="A study: time over error' in page
    assert "Z80 &amp; more" in page
    assert "a &lt; b case" in page
    assert text == cost_markdown([result], MACHINE)
    assert "![made-up](made-up.png)" in text
    assert "| 1e-2 to 1e-3 | slow" in text
    for document in (page, text):
        assert "9 points." in document
        assert "by hand" in document


def test_a_busy_machine_is_told(result):
    assert result.unsteady == 0.0
    shaken = tuple(replace(p, upper_s=2.0 * p.seconds) if p.method == "quick" else p for p in result.points)
    busy = replace(result, points=shaken)
    assert busy.unsteady == pytest.approx(3 / 9)
    assert "33 % of the times spread" in cost_sections([busy], MACHINE)[1].notes[-1]


def timed(case, method, error, seconds, setting=""):
    return Measured(case=case, method=method, setting=setting, error=error, seconds=seconds, evaluations=1,
                    lower_s=seconds, upper_s=seconds, repeats=5, loops=1)  # fmt: skip


@pytest.mark.parametrize(
    ("gauss_s", "verdict"), [(9e-6, "is not the fastest"), (9e-3, "a closed form is the fastest")]
)
def test_the_sentence_on_the_closed_form_follows_the_measurement(gauss_s, verdict):
    points = (
        timed("regular", "gauss-legendre", 1e-15, gauss_s, "16 points"),
        timed("regular", "closed form, textbook", 1e-3, 1e-6),
        timed("regular", "closed form, stable", 1e-16, 3e-5),
        timed("regular", "closed form", 1e-16, 1e-4),
    )
    first, *others = STUDIES["integral"].findings(points)
    assert verdict in first
    assert "100 µs (closed form" in first
    assert ("gauss-legendre, 16 points is faster" in first) == (gauss_s < 3e-5)
    assert any("off by 1e-03 in regular" in sentence for sentence in others)


def test_the_sentence_on_the_exponential_follows_the_measurement():
    rk4, exact = timed("stiff", "rk4", 1e-6, 0.2, "step 0.5 ms"), timed("stiff", "exact", 1e-13, 0.01)
    assert (
        STUDIES["press-transient"]
        .findings((rk4, exact))[0]
        .startswith("stiff: the matrix exponential is the fastest")
    )
    quick = timed("stiff", "rk4", 1e-6, 0.001, "step 0.5 ms")
    assert STUDIES["press-transient"].findings((quick, exact))[0] == (
        "stiff: fastest, from rough to accurate: rk4, exact."
    )
