"""Which setting is enough: the error side alone."""

from regenerate_readme import enough

from ropefric.accuracy.measure import error_table

CASES = [("integral", "regular"), ("blade-modes", "blade")]


def test_the_choice_is_accurate_enough_and_nothing_that_is_takes_less_work():
    for study, case in CASES:
        chosen = {10.0**-n: enough(study, 10.0**-n, case) for n in range(1, 9)}
        for accuracy, row in chosen.items():
            assert row.error <= accuracy, (study, case)
            good = [one for one in error_table(study, case) if one.error <= accuracy]
            assert row in good, (study, case)
            assert row.evaluations == min(one.evaluations for one in good), (study, case)
        work = [row.evaluations for row in chosen.values()]
        assert work == sorted(work), "more accuracy never takes less work"


def test_a_method_can_be_asked_for_and_the_first_case_is_the_ordinary_one():
    points = [enough("integral", 10.0**-n, method="gauss-legendre").setting for n in (2, 4, 8, 12)]
    assert points == ["2 points", "6 points", "12 points", "16 points"]
    assert enough("integral", 1e-12).method.startswith("closed form")
    assert error_table("integral") == error_table("integral", "regular")
