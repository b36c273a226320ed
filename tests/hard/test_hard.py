"""Every hard regime keeps what it states, what holds besides does, and the docs show what is measured."""

import resource
from pathlib import Path

import pytest
import table as hard_table
from hard_regime import refused as assert_refused
from hard_regime import shown

PAGE = (Path(__file__).parents[2] / "docs" / "hard-cases.md").read_text(encoding="utf-8")
ROWS = {cells[0]: cells
        for line in PAGE.split("<!-- hard-cases -->\n", 1)[1].split("<!-- end -->", 1)[0].splitlines()
        for cells in [tuple(line.removeprefix("| ").removesuffix(" |").split(" | "))]}  # fmt: skip


def named(declared):
    return {"argvalues": declared.values(), "ids": declared}


def test_the_docs_show_every_regime_and_no_other():
    assert list(ROWS) == ["regime", "---", *(one.name for one in hard_table.REGIMES.values())]


@pytest.mark.parametrize("regime", **named(hard_table.REGIMES))
def test_nothing_is_lost(regime):
    again, row = "run python tests/regenerate_readme.py hard-cases", ROWS[regime.name]
    if regime.tolerance is None:
        for call, said in regime.measure():
            assert_refused(call, said)
        assert row == regime.row(None), again
        return
    error = regime.measure()
    assert error <= regime.tolerance
    assert row[:-1] == regime.row(error)[:-1], again
    # The power of ten that is shown holds here too; another machine's logarithm may round to the next one.
    assert 0.05 <= float(row[-1].removeprefix("≤ ")) / shown(error) <= 20.0, again


@pytest.mark.parametrize("fact", **named(hard_table.FACTS))
def test_fact(fact):
    fact()


@pytest.mark.parametrize("calls", **named(hard_table.REFUSALS))
def test_refused(calls):
    number = 0
    for number, (call, said) in enumerate(calls(), start=1):  # noqa: B007
        assert_refused(call, said)
    assert number


@pytest.mark.slow
def test_stiff_belts_that_go_slack():
    assert hard_table.hard_machines.slack_belts([(1e8, 1e-4)]) <= 1e-5


@pytest.mark.slow
def test_a_hundred_million_samples():
    """Two arrays of 0.8 GB, two masks of 0.1 GB, and a little."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert hard_table.hard_traces.many_samples(100_000_000) <= 1e-9
    grown_GB = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e6
    assert grown_GB < 2.2
