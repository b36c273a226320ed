"""What the study of the lift-force integral says of the closed form: generated from the measurement."""

from ropefric.accuracy.measured import ACCURACIES, Measured, cheapest, in_case
from ropefric.accuracy.words import time_text

__all__ = ["CLOSED", "integral_findings"]

CLOSED = ("closed form", "closed form, stable", "closed form, textbook")
"""The library's function, its formula without the checks of its input, and the difference of two powers."""

_DEMANDING = tuple(accuracy for accuracy in ACCURACIES if accuracy < 2e-6)
_TIGHTEST = ACCURACIES[-1]
_ASKED = (1e-2, 1e-6, 1e-12)
_MANY = 10_000


def integral_findings(points: tuple[Measured, ...]) -> tuple[str, ...]:
    """Return whether a closed form is the fastest at every accuracy from 1e-6 down, case by case, and what else is.

    Examples
    --------
    >>> integral_findings(())
    ()
    """
    cases = [case for case in dict.fromkeys(point.case for point in points) if _closed(in_case(points, case))]
    sentences = tuple(_of_case(case, in_case(points, case)) for case in cases)
    return (*sentences, *_where_textbook_fails(points), *_one_against_many(points), *_of_the_hoist(points))


def _closed(points: tuple[Measured, ...]) -> tuple[Measured, ...]:
    return tuple(point for point in points if point.method in CLOSED)


def _of_case(case: str, points: tuple[Measured, ...]) -> str:
    winners = [best for accuracy in _DEMANDING if (best := cheapest(points, accuracy)) is not None]
    rivals = list(dict.fromkeys(best.name for best in winners if best.method not in CLOSED))
    first = min(_closed(points), key=lambda point: point.seconds)
    if not rivals:
        verdict = "a closed form is the fastest at every accuracy from 1e-6 down"
    else:
        verdict = (
            f"the closed form is not the fastest at every accuracy from 1e-6 down, {', '.join(rivals)} is faster "
            f"where {first.name} is not accurate enough"
        )
    times = ", ".join(
        f"{time_text(p.seconds)} ({p.method}, error {p.shown_error:.0e})" for p in _closed(points)
    )
    rule = cheapest([point for point in points if point.method not in CLOSED], _TIGHTEST)
    best_rule = f"no rule reaches {_TIGHTEST:.0e}"
    if rule is not None:
        best_rule = f"the fastest rule to {_TIGHTEST:.0e} is {rule.name} in {time_text(rule.seconds)}"
    return f"{case}: {verdict}: {times}; {best_rule}."


def _where_textbook_fails(points: tuple[Measured, ...]) -> tuple[str, ...]:
    bad = [p for p in points if p.method == CLOSED[-1] and p.error > _TIGHTEST]
    if not bad:
        return ()
    where = " and ".join(f"{point.error:.0e} in {point.case}" for point in bad)
    worst = max(point.error for point in points if point.method == CLOSED[0])
    sentence = (
        "The textbook's difference of two powers is the cheapest closed form and loses digits: it is off by "
        f"{where}. The stable form is never off by more than {worst:.0e}; for one condition, the checks of the input "
        "cost more than the formula."
    )
    return (sentence,)


def _one_against_many(points: tuple[Measured, ...]) -> tuple[str, ...]:
    """Return what a condition costs alone and in a batch: the difference is the overhead of calling numpy."""
    lines = []
    for method in (*CLOSED, "gauss-legendre"):
        alone, batch = (
            cheapest([p for p in in_case(points, case) if p.method == method], _TIGHTEST)
            for case in ("regular", "many")
        )
        if alone is not None and batch is not None:
            other = "" if batch.setting == alone.setting else f" ({batch.setting})"
            each_s = batch.seconds / _MANY
            lines.append(
                f"{alone.name} {time_text(alone.seconds)} alone, {time_text(each_s)} in a batch{other}"
            )
    if not lines:
        return ()
    return (
        "To 1e-12, a condition costs: "
        + "; ".join(lines)
        + ". Alone, the calls of numpy are paid for, and a rule with "
        "fewer of them wins; in a batch, the arithmetic is.",
    )


def _of_the_hoist(points: tuple[Measured, ...]) -> tuple[str, ...]:
    """Return what the plan of a hoist does with all this: it takes the closed form, and what that costs it."""
    parts = []
    for case, what in (("regular", "one condition"), ("many", f"{_MANY:,} conditions".replace(",", " "))):
        here = in_case(points, case)
        own = next((point for point in here if point.method == CLOSED[0]), None)
        rules = [point for point in here if point.method not in CLOSED]
        pairs = [(a, rule) for a in _ASKED if (rule := cheapest(rules, a)) is not None]
        if own is not None and pairs:
            rivals = ", ".join(f"{time_text(rule.seconds)} to {a:.0e} ({rule.name})" for a, rule in pairs)
            parts.append(f"for {what} {time_text(own.seconds)} to {own.shown_error:.0e}, against {rivals}")
    if not parts:
        return ()
    return (f"A hoist's plan takes the closed form at every accuracy: {'; '.join(parts)}.",)
