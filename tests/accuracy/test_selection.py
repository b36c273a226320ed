"""Which setting is enough: the error side alone."""

import pytest

from ropefric.accuracy.measure import enough, error_table

CASES = [("integral", "regular"), ("end-tension", "exponential"), ("blade-modes", "blade"), ("fit", "wide")]


@pytest.mark.parametrize(("study", "case"), CASES)
@pytest.mark.parametrize("accuracy", [1e-2, 1e-5, 1e-8])
def test_the_choice_is_accurate_enough_and_nothing_that_is_takes_less_work(study, case, accuracy):
    chosen = enough(study, accuracy, case)
    assert chosen.error <= accuracy
    good = [row for row in error_table(study, case) if row.error <= accuracy]
    assert chosen in good
    assert all(row.evaluations >= chosen.evaluations for row in good)


@pytest.mark.parametrize(("study", "case"), CASES)
def test_more_accuracy_never_takes_less_work(study, case):
    work = [enough(study, 10.0**-n, case).evaluations for n in range(1, 9)]
    assert work == sorted(work)


def test_a_method_can_be_asked_for():
    points = [enough("integral", 10.0**-n, method="gauss-legendre").setting for n in (2, 4, 8, 12)]
    assert points == ["2 points", "6 points", "12 points", "16 points"]
    assert enough("integral", 1e-12).method.startswith("closed form")


def test_the_first_case_is_the_ordinary_one():
    assert error_table("integral") == error_table("integral", "regular")
