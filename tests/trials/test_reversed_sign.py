"""A force that only goes down was recorded with its sign reversed; other low forces were not."""

import pytest


def with_force(text, force):
    head, *rows = text.splitlines()
    cells = [row.split(",") for row in rows]
    return "\n".join([head, *(f"{row[0]},{force(float(row[1])):.4f}" for row in cells)]) + "\n"


@pytest.fixture(scope="module")
def good(pull_csv):
    return pull_csv(100.0, seed=5)


@pytest.mark.parametrize("settings", ["", '[tare]\ninterval = ["0 s", "0.25 s"]'])
def test_a_reversed_force_is_read_and_told(lab, good, settings):
    (lab.folder / "a.csv").write_text(good)
    (lab.folder / "b.csv").write_text(with_force(good, lambda f: -f))
    extraction = lab.write([lab.row("a.csv"), lab.row("b.csv", trial="b")], settings).extract()
    right, turned = extraction.trials
    assert (turned.peak_N, turned.breakaway.status) == (right.peak_N, "ok")
    (problem,) = [one for one in extraction.problems if one.code == "RF241"]
    assert problem.path == "b.csv"
    assert 'force = "-force"' in problem.fix


@pytest.mark.parametrize(
    "force",
    [
        lambda f: f - 500,  # a zero that is off
        lambda f: 300 - f if f > 1 else 300,  # pulled from a load down to less
    ],
)
def test_other_low_forces_are_not_turned_round(lab, good, force):
    (lab.folder / "a.csv").write_text(with_force(good, force))
    extraction = lab.write([lab.row("a.csv")]).extract()
    assert "RF241" not in {one.code for one in extraction.problems}
