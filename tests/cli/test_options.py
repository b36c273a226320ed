"""Options that need more than a type: processes, assignments."""

import os

import pytest
import typer

from ropefric.cli.options import SERIAL_BELOW, parse_assignments, parse_jobs


def test_a_small_campaign_runs_in_one_process_and_a_large_one_on_every_core():
    assert parse_jobs("auto", SERIAL_BELOW - 1) == 1
    assert 1 <= parse_jobs("auto", SERIAL_BELOW) <= (os.cpu_count() or 1)
    assert parse_jobs("7", 3) <= 3


def test_other_numbers_of_jobs_are_refused():
    for text in ("0", "-1", "1.5", "many", "", "²"):
        with pytest.raises(typer.BadParameter, match="neither 'auto' nor a number"):
            parse_jobs(text, 100)


def test_assignments():
    assert parse_assignments([" mu = 2e-1 ", "b=-.5"], option="-p") == {"mu": 0.2, "b": -0.5}
    for text in ("mu", "mu=", "=3", "mu=big", "mu=nan", "mu=inf", "mu=1=2"):
        with pytest.raises(typer.BadParameter, match="is not like"):
            parse_assignments([text], option="-p")
    with pytest.raises(typer.BadParameter, match="twice"):
        parse_assignments(["mu=1", "mu=2"], option="-p")
