"""The columns a trial list may have, which of them a header names, and those it has of its own."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from ropefric.errors import InputError, Problem
from ropefric.quantities import split_unit_suffix, unit_factor
from ropefric.registry import did_you_mean

STANDARD_GRAVITY_M_S2 = 9.80665
"""Weight per mass [m/s²], CGPM 1901; what turns `end_mass_kg` into a tension."""

TEXT_COLUMNS = ("trial", "file", "sample", "wheel", "cell", "rope_id", "exclude", "note")

# Closer than this a strange name is more likely a slip than a column of the user's own.
_SLIP = 0.8


@dataclass(frozen=True, slots=True)
class _Quantity:
    field: str
    si_unit: str
    example: str
    scale: float = 1.0


_QUANTITIES = {
    "wheel_radius": _Quantity("wheel_radius_m", "m", "wheel_radius_mm"),
    "wheel_diameter": _Quantity("wheel_radius_m", "m", "wheel_diameter_mm", 0.5),
    "rope_diameter": _Quantity("rope_radius_m", "m", "rope_diameter_mm", 0.5),
    "rope_radius": _Quantity("rope_radius_m", "m", "rope_radius_mm"),
    "wrap_angle": _Quantity("wrap_angle_rad", "rad", "wrap_angle_deg"),
    "wrap": _Quantity("wrap_angle_rad", "rad", "wrap_turns"),
    "end_tension": _Quantity("end_tension_N", "N", "end_tension_N"),
    "end_mass": _Quantity("end_tension_N", "kg", "end_mass_kg", STANDARD_GRAVITY_M_S2),
    "lift_force": _Quantity("lift_force_N", "N", "lift_force_N"),
    "lift_mass": _Quantity("lift_force_N", "kg", "lift_mass_kg", STANDARD_GRAVITY_M_S2),
    "dwell": _Quantity("dwell_s", "s", "dwell_s"),
    "from": _Quantity("start_s", "s", "from_s"),
    "until": _Quantity("stop_s", "s", "until_s"),
}


_KNOWN = (*TEXT_COLUMNS, *(item.example for item in _QUANTITIES.values()))


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundColumn:
    """A column of the table and what it means."""

    index: int
    header: str
    field: str
    unit: str = ""
    si_unit: str = ""
    scale: float = 1.0


def bind_columns(
    header: tuple[str, ...], path: str, line: int
) -> tuple[dict[str, BoundColumn], dict[str, int], tuple[Problem, ...]]:
    """Return the columns by the field they give, the places of columns of the user's own, and problems of the header.

    Columns whose name is empty or starts with "_" are left out. A column that is not known is the user's own and is
    kept; one whose name is nearly that of a known column is doubtful.
    """
    bound, others, problems = bind_header(header, path, line, bind=_bind)
    own: dict[str, int] = {}
    for index, name in enumerate(header):
        if name in others and name and not name.startswith("_"):
            own.setdefault(name, index)
            problems += near_miss(name, _KNOWN, _QUANTITIES, path, line)
    return bound, own, tuple(problems)


def near_miss(
    name: str, known: Iterable[str], stems: Iterable[str], path: str, line: int | None
) -> tuple[Problem, ...]:
    """Return a warning if a column that is not known has nearly the name of one that is."""
    stem = _word(split_unit_suffix(name)[0])
    if not get_close_matches(stem[:80], [*stems], n=1, cutoff=_SLIP):
        return ()
    fix = f"{did_you_mean(name[:80], known)} Otherwise nothing is to be done."
    message = "this column is not known; it is kept, but not used"
    return (
        Problem(code="RF120", message=message, path=path, line=line, key=name, fix=fix, severity="warning"),
    )


def bind_header(
    header: Sequence[str],
    path: str,
    line: int | None,
    *,
    bind: Callable[[int, str, dict[str, BoundColumn]], BoundColumn | None],
) -> tuple[dict[str, BoundColumn], list[str], list[Problem]]:
    """Return the columns that a table knows, by field, the names it leaves alone, and all that is wrong."""
    bound: dict[str, BoundColumn] = {}
    others: list[str] = []
    problems: list[Problem] = []
    for index, name in enumerate(header):
        try:
            column = bind(index, name, bound)
        except InputError as error:
            message = error.problem.message.removeprefix(f"{name}: ")
            problems.append(
                Problem(code=error.code, message=message, path=path, line=line, key=name, fix=error.fix)
            )
        else:
            if column is None:
                others.append(name)
            else:
                bound[column.field] = column
    return bound, others, problems


def _bind(index: int, name: str, bound: dict[str, BoundColumn]) -> BoundColumn | None:
    word = _word(name)
    if not word or word.startswith("_"):
        return None
    column = BoundColumn(index=index, header=name, field=word)
    if word not in TEXT_COLUMNS:
        found = _bind_quantity(index, name)
        if found is None:
            return None
        column = found
    if column.field in bound:
        message = f"this column says the same as '{bound[column.field].header}'"
        raise InputError(message, code="RF122", fix="remove one of the two")
    return column


def _bind_quantity(index: int, name: str) -> BoundColumn | None:
    stem, unit = split_unit_suffix(name)
    quantity = _QUANTITIES.get(_word(stem))
    if quantity is None:
        return None
    if not unit:
        raise InputError(
            "the column has no unit",
            code="RF130",
            fix=f"name it with the unit of its numbers, for example {quantity.example}",
        )
    unit_factor(unit, quantity.si_unit, name=name)
    return BoundColumn(
        index=index,
        header=name,
        field=quantity.field,
        unit=unit,
        si_unit=quantity.si_unit,
        scale=quantity.scale,
    )


def _word(name: str) -> str:
    return "_".join(name.lower().split())
