"""Which setting is enough for an accuracy: the error side of the studies alone, the same on every machine."""

from dataclasses import dataclass
from functools import cache

from ropefric.accuracy.studies import STUDIES
from ropefric.accuracy.study import Setting
from ropefric.errors import InputError, SolverError, UnknownNameError
from ropefric.registry import did_you_mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """One setting with its error and work."""

    study: str
    case: str
    method: str
    setting: str
    error: float
    evaluations: float


def error_table(study: str, case: str = "", *, method: str = "") -> tuple[Choice, ...]:
    """Return the error and the work of every setting of a case; no clock is looked at.

    What was computed once is remembered.
    """
    name = STUDIES[study].case(case).name
    settings = _settings(study, name)
    methods = {setting.method for setting in settings}
    if method and method not in methods:
        raise UnknownNameError(
            f"study {study}, case {name}, has no method {method!r}", fix=did_you_mean(method, methods)
        )
    return tuple(
        _choice(study, name, place)
        for place, setting in enumerate(settings)
        if method in {"", setting.method}
    )


@cache
def _settings(study: str, case: str) -> tuple[Setting, ...]:
    return STUDIES[study].case(case).settings()


@cache
def _choice(study: str, case: str, place: int) -> Choice:
    setting = _settings(study, case)[place]
    outcome = setting.assess()
    return Choice(
        study=study,
        case=case,
        method=setting.method,
        setting=setting.setting,
        error=outcome.error,
        evaluations=outcome.evaluations,
    )


def enough(study: str, accuracy: float, case: str = "", *, method: str = "") -> Choice:
    """Return the setting with the least work whose error in the study is at most `accuracy`.

    Work is counted in the study's unit and not timed, so that the choice is the same on every machine; of two
    settings with the same work, the more accurate one is taken.
    """
    if not accuracy > 0.0:
        raise InputError(f"an accuracy of {accuracy:g} cannot be reached", key="accuracy", fix="give 1e-6")
    rows = error_table(study, case, method=method)
    good = [row for row in rows if row.error <= accuracy]
    if not good:
        best = min(rows, key=lambda row: row.error)
        raise SolverError(
            f"no setting of study {study}, case {best.case}, reaches an accuracy of {accuracy:g}; the best is "
            f"{best.method} {best.setting} with {best.error:.2g}",
            fix="ask for less, or use another method",
        )
    return min(good, key=lambda row: (row.evaluations, row.error))
