"""Comparisons that leave no choice of law: no weights, and said so."""

import math

import numpy as np
import pytest
from pulled import grid, table_at

from ropefric.fitting.compare import compare_laws


def pulls(wraps, log_lift, repeats=6, within=0.01):
    """Conditions that differ in wrap, whose repeats lie evenly about a given ln(F_A/F_B)."""
    at = grid([0.04], wraps, [20.0], repeats)
    scatter = np.tile(within * np.linspace(-1.0, 1.0, repeats), len(wraps))
    return table_at(at, np.log(20.0) + np.repeat(log_lift, repeats) + scatter)


def test_a_law_that_stands_alone_has_no_weight():
    """Four conditions of an offset that is 20 standard errors large: too few to rank any law but the constant one."""
    wraps = np.array([3.0, 6.0, 9.0, 12.0])
    off = 0.3 + 0.005 * np.array([1, -1, -1, 1])
    found = compare_laws(pulls(wraps, 0.15 * wraps + off), ["constant", "wrap-power"])
    assert [entry.law for entry in found.ranking if entry.counted] == ["constant"]
    assert not found.conclusive
    assert math.isnan(found.best.weight)
    tree = found.to_dict()
    assert tree["conclusive"] is False
    assert tree["ranking"][0]["weight"] is None
    # The test that speaks against it is named.
    tests = {(test.simpler, test.fuller): test.p_value for test in found.tests}
    assert tests["constant", "constant-offset"] < 0.01
    text = " ".join(found.notes)
    assert "only constant could be ranked on 4 conditions" in text


@pytest.mark.parametrize(("n", "conclusive"), [(5, False), (6, True)])
def test_the_constant_laws_alone_are_a_choice_only_once_another_could_be_judged(n, conclusive):
    """A wrap law has four estimated quantities, so AICc needs six conditions for it."""
    wraps = np.linspace(3.0, 3.0 * n, n)
    found = compare_laws(pulls(wraps, 0.2 * wraps + 0.02 * (-1.0) ** np.arange(n)), ["wrap-power"])
    assert {entry.law for entry in found.ranking if entry.counted} >= {"constant", "constant-offset"}
    assert found.conclusive is conclusive
    assert np.isfinite(found.best.weight) == conclusive
