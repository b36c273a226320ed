"""An uncertainty budget as a section: its lines, their sum, the check by draws, what would help."""

import math
from collections.abc import Sequence

from ropefric.report.section import Section, Table, interval, plain
from ropefric.uncertainty.budget import BudgetLine
from ropefric.uncertainty.quantity import Quantity
from ropefric.uncertainty.statement import DISAGREEMENT, Statement, numerical_tolerance

_HEADINGS = (
    "source",
    "symbol",
    "estimate",
    "stated",
    "divisor",
    "u(x)",
    "unit ",
    "type ",
    "distribution ",
    "sensitivity",
    "|c| u",
    "share",
    "dof",
)
_DIVISORS = {math.sqrt(3.0): "√3", math.sqrt(12.0): "√12", 1.0: "1"}


def uncertainty_sections(stated: Statement, title: str) -> tuple[Section, ...]:
    """Return a statement of uncertainty as sections: budget, check, what would shrink it, what is not in it."""
    found = stated.budget
    unit = "" if stated.model.unit == "-" else f" {stated.model.unit}"
    rows = tuple(_row(line) for line in found.lines)
    answer = (
        f"{stated.model.symbol} = {plain(found.estimate, '.5g')}{unit} ± {plain(found.expanded, '.2g')}{unit} "
        f"({100 * found.level:g} %)"
    )
    sums = (
        f"u_c = {plain(found.combined, '.3g')}{unit}, ν_eff = {plain(found.effective_dof, '.3g')}, "
        f"k = {plain(found.coverage_factor, '.3g')}: U = {plain(found.expanded, '.3g')}{unit}"
    )
    budget = Section(
        title=title,
        lines=(answer, sums),
        table=Table(headings=_HEADINGS, rows=rows, left=2),
        notes=(f"{stated.status}: {stated.status.advice}", *stated.notes),
    )
    return budget, _drawn(stated, unit), _improvements(stated, unit)


def budgets_section(stated: Sequence[tuple[int, str, Statement]], title: str) -> Section:
    """Return many statements as one table: number, condition in words, answer, U, and what dominates."""
    rows = tuple(
        (
            str(number),
            words,
            plain(item.budget.estimate, ".5g"),
            plain(item.budget.combined, ".2g"),
            plain(item.budget.effective_dof, ".3g"),
            plain(item.budget.expanded, ".2g"),
            f"{100 * item.budget.expanded / abs(item.budget.estimate):.2g} %",
            f"{item.budget.lines[0].label} ({100 * item.budget.lines[0].share:.0f} %)",
            str(item.status),
        )
        for number, words, item in stated
    )
    headings = (
        "no.",
        "condition ",
        "estimate",
        "u_c",
        "ν_eff",
        "U",
        "U/estimate",
        "largest part ",
        "status ",
    )
    return Section(title=title, table=Table(headings=headings, rows=rows, left=2))


def _row(line: BudgetLine) -> tuple[str, ...]:
    share, dof = f"{100 * line.share:.1f} %", plain(line.dof, ".3g")
    if not isinstance(line.source, Quantity):
        return (line.name, "θ", "–", "–", "–", "–", "", line.type, "joint, with covariance", "–",
                plain(line.contribution, ".2g"), share, dof)  # fmt: skip
    item = line.source
    divisor = next((text for value, text in _DIVISORS.items() if math.isclose(value, item.divisor)), "")
    if not divisor:
        divisor = f"√{item.repeats}" if item.repeats else plain(item.divisor, ".3g")
    return (
        line.label,
        item.symbol,
        plain(item.estimate, ".5g"),
        plain(item.stated, ".2g"),
        divisor,
        plain(item.std, ".2g"),
        item.unit,
        item.type,
        item.distribution,
        plain(line.sensitivity, ".3g"),
        plain(line.contribution, ".2g"),
        share,
        dof,
    )


def _drawn(stated: Statement, unit: str) -> Section:
    drawn, found = stated.drawn, stated.budget
    half_68 = f"{plain(drawn.half_68, '.3g')}{unit}"
    lines = (
        f"y ± U: {interval(found.interval, '.5g')}{unit}",
        f"symmetric: {interval(drawn.symmetric, '.5g')}{unit}; shortest: {interval(drawn.shortest, '.5g')}{unit}",
        f"half the central 68.27 %: {half_68} against u_c = {plain(found.combined, '.3g')}{unit}",
        _verdict(stated, unit),
        _strict_test(stated, unit),
    )
    return Section(title=f"Check by {drawn.draws} draws (seed {drawn.seed})", lines=lines)


def _verdict(stated: Statement, unit: str) -> str:
    """Return how far the ends of y ± U are from those of the draws, and whether that counts as agreement."""
    drawn, expanded = stated.drawn, stated.budget.expanded
    gap = max(drawn.low_gap, drawn.high_gap)
    word = "agrees" if drawn.agrees else "does not agree"
    left_out = f"; {drawn.unanswered} draws have no answer" if drawn.unanswered else ""
    return (
        f"the budget {word} with the draws: the ends differ by up to {plain(gap, '.2g')}{unit}, "
        f"{100 * gap / expanded:.2g} % of U ({100 * DISAGREEMENT:g} % count as agreement){left_out}"
    )


def _strict_test(stated: Statement, unit: str) -> str:
    """Return to how many digits the stricter test of JCGM 101 holds."""
    digits, u_c = stated.drawn.digits, stated.budget.combined
    allowed = f"{plain(numerical_tolerance(u_c, max(digits, 1)), '.2g')}{unit}"
    if digits:
        count = {1: "one digit", 2: "two digits"}[digits]
        return f"the stricter test of JCGM 101, 8.1, holds to {count} of u_c, for which {allowed} are allowed"
    return f"the stricter test of JCGM 101, 8.1, is not passed: to one digit of u_c {allowed} are allowed"


def _improvements(stated: Statement, unit: str) -> Section:
    notes = tuple(
        f"{item.action}: U = {plain(item.expanded, '.3g')}{unit}, {100 * item.saving:.0f} % smaller"
        for item in stated.improvements
    )
    return Section(title="What would make it smaller", notes=notes)
