"""The columns a trial table may have: their meanings, their units, and what a header calls them."""

from dataclasses import replace
from difflib import get_close_matches

from ropefric.errors import InputError, Problem
from ropefric.quantities import split_unit_suffix, unit_factor
from ropefric.trials.trial_columns import STANDARD_GRAVITY_M_S2, BoundColumn, bind_header, near_miss

REQUIRED_NUMBERS = {
    "wheel_radius_m": "wheel_radius_mm",
    "rope_radius_m": "rope_diameter_mm",
    "wrap_angle_rad": "wrap_angle_deg",
    "end_tension_N": "end_tension_N",
    "peak_N": "peak_N",
}
"""Fields every table needs, and a header that gives each."""

OPTIONAL_NUMBERS = ("peak_std_N", "end_tension_std_N", "wrap_std_rad", "wheel_radius_std_m")
"""Fields that may be absent."""

TEXTS = ("trial", "kept", "status")
"""Text fields, all optional."""

# stem -> (field, SI unit, factor)
_STEMS = {
    "wheel_radius": ("wheel_radius_m", "m", 1.0),
    "wheel_diameter": ("wheel_radius_m", "m", 0.5),
    "rope_radius": ("rope_radius_m", "m", 1.0),
    "rope_diameter": ("rope_radius_m", "m", 0.5),
    "wrap_angle": ("wrap_angle_rad", "rad", 1.0),
    "wrap": ("wrap_angle_rad", "rad", 1.0),
    "end_tension": ("end_tension_N", "N", 1.0),
    "end_mass": ("end_tension_N", "kg", STANDARD_GRAVITY_M_S2),
    "peak": ("peak_N", "N", 1.0),
    "breakaway_force": ("peak_N", "N", 1.0),
    "lift_force": ("peak_N", "N", 1.0),
    "lift_mass": ("peak_N", "kg", STANDARD_GRAVITY_M_S2),
    "peak_std": ("peak_std_N", "N", 1.0),
    "lift_force_std": ("peak_std_N", "N", 1.0),
    "end_tension_std": ("end_tension_std_N", "N", 1.0),
    "wrap_angle_std": ("wrap_std_rad", "rad", 1.0),
    "wrap_std": ("wrap_std_rad", "rad", 1.0),
    "wheel_radius_std": ("wheel_radius_std_m", "m", 1.0),
    "wheel_diameter_std": ("wheel_radius_std_m", "m", 0.5),
}
_UNITS = {"m": "mm", "rad": "deg", "N": "N", "kg": "kg"}
_KNOWN = (*TEXTS, *(f"{stem}_{_UNITS[unit]}" for stem, (_, unit, _) in _STEMS.items()))
# What an extraction writes beside the columns a fit reads.
_PASSED_OVER = frozenset(
    {
        "file", "sample", "peak_raw", "peak_time", "two_line", "bias", "window", "noise_std", "loading_rate",
        "kinetic", "kinetic_std", "rejected_by", "excluded", "exclude", "detail", "note", "notes", "cell", "rope_id",
        "dwell", "tare", "saturated_samples", "sha256", "wheel",
    }
)  # fmt: skip
# Closer than this a strange name is more likely a slip than a column of the user's own.
_SLIP = 0.8


def bind_table_columns(
    header: tuple[str, ...], path: str, line: int | None
) -> tuple[dict[str, BoundColumn], tuple[str, ...], tuple[Problem, ...]]:
    """Return the columns by the field they give, the names passed over, and what is wrong with the header."""
    bound, others, problems = bind_header(header, path, line, bind=_bind)
    # A column with a wrong unit is there; that it is missing as well would only confuse.
    there = set(bound) | {_field_of(problem.key) for problem in problems}
    strange = [name for name in others if (word := _word(name)) and not word.startswith("_")
               and _word(split_unit_suffix(name)[0]) not in _PASSED_OVER]  # fmt: skip
    for name in strange:
        near = near_miss(name, _KNOWN, _STEMS, path, line)
        field = _field_of(name)
        if near and field in REQUIRED_NUMBERS and field not in there:
            there.add(field)
            near = (replace(near[0], message="this column is not known", severity="error"),)
        problems += near
    problems += [_missing(field, example, path, line) for field, example in REQUIRED_NUMBERS.items()
                 if field not in there]  # fmt: skip
    return bound, tuple(others), tuple(problems)


def _field_of(name: str) -> str:
    stem = _word(split_unit_suffix(name)[0])
    close = get_close_matches(stem, _STEMS, n=1, cutoff=_SLIP)
    return _STEMS[close[0]][0] if close else ""


def _missing(field: str, example: str, path: str, line: int | None) -> Problem:
    named = field.rsplit("_", 1)[0].replace("_", " ").replace("peak", "break-away force")
    return Problem(
        code="RF121",
        message=f"there is no column for the {named}; every trial needs one",
        path=path,
        line=line,
        fix=f"add a column {example} (any unit will do, it stands in the name)",
    )


def _bind(index: int, name: str, bound: dict[str, BoundColumn]) -> BoundColumn | None:
    column = _column(index, name)
    if column is not None and column.field in bound:
        message = f"this column says the same as '{bound[column.field].header}'"
        raise InputError(message, code="RF122", fix="remove one of the two")
    return column


def _column(index: int, name: str) -> BoundColumn | None:
    word = _word(name)
    if not word or word.startswith("_"):
        return None
    if word in TEXTS:
        return BoundColumn(index=index, header=name, field=word)
    stem, unit = split_unit_suffix(name)
    known = _STEMS.get(_word(stem))
    if known is None:
        return None
    field, si_unit, scale = known
    if not unit:
        example = f"{_word(stem)}_{_UNITS[si_unit]}"
        raise InputError(
            "the column has no unit",
            code="RF130",
            fix=f"name it with the unit of its numbers, for example {example}",
        )
    unit_factor(unit, si_unit, name=name)
    return BoundColumn(index=index, header=name, field=field, unit=unit, si_unit=si_unit, scale=scale)


def _word(name: str) -> str:
    return "_".join(name.lower().replace("_", " ").split())
