"""The field's words: name, symbol, unit and meaning of the quantities that figures and answers show; statuses."""

from enum import StrEnum
from typing import NamedTuple, Self

from ropefric.quantities import split_unit_suffix
from ropefric.registry import Registry


class AdvisedStatus(StrEnum):
    """A status that says what it means and what to do; its members are written "value: advice"."""

    advice: str  # type: ignore[misc]  # it is set below

    def __new__(cls, text: str) -> Self:
        """Return the member of a value, with its advice."""
        value, _, advice = text.partition(": ")
        member = str.__new__(cls, value)
        member._value_, member.advice = value, advice  # type: ignore[misc]
        return member


class Term(NamedTuple):
    """One quantity of the field."""

    name: str
    symbol: str
    unit: str
    meaning: str


GLOSSARY: Registry[Term] = Registry(
    "term",
    [
        Term("time_s", "t", "s", "Time"),
        Term("force_N", "F", "N", "Force"),
        Term("wheel_radius_m", "R_w", "m", "Wheel radius"),
        Term("rope_radius_m", "R_r", "m", "Rope radius"),
        Term("wrap_angle_rad", "φ", "rad", "Wrap angle"),
        Term("end_tension_N", "F_B", "N", "End tension; slack side"),
        Term("lift_force_N", "F_A", "N", "Lift force; tight side"),
        Term("peak_N", "F_A", "N", "Break-away force; static peak of the smoothed trace"),
        Term("mu", "μ", "-", "Friction coefficient; local"),
        Term("mu_average", "μ̄", "-", "Friction coefficient; average over the wrap"),
        Term("lift_margin", "", "-", "Lift force over the weight of the payload; above 1 it lifts"),
        Term("margin_N", "", "N", "Lift force beyond the weight of the payload"),
        Term("linear_density_kg_m", "ρ", "kg/m", "Mass per length"),
        Term("speed_m_s", "v", "m/s", "Rope speed"),
        Term("first_frequency_Hz", "f_1", "Hz", "First natural frequency"),
        Term("utilisation", "U", "-", "Friction used; 1 at gross slip"),
        Term("largest_utilisation", "", "-", "Largest share of friction used; 1 at gross slip"),
        Term("tension_N", "T", "N", "Tension"),
        Term("effective_tension_N", "T'", "N", "Effective tension; less what keeps the belt on its path"),
        Term("preload_N", "F", "N", "Preload"),
        Term("mu_required", "", "-", "Friction coefficient at which slip begins"),
        Term("power_W", "P", "W", "Power"),
        Term("full_power_W", "", "W", "Largest power"),
        Term("torque_N_m", "M", "N m", "Torque"),
        Term("reversed_torque_N_m", "", "N m", "Torque turning the other way"),
        Term("normal_N_m", "", "N/m", "Side pressure"),
    ],
)
"""Every quantity by name."""


def axis_label(name: str) -> str:
    """Return an axis label with symbol and unit."""
    term = GLOSSARY[name]
    text = term.meaning.split(";")[0]
    if term.symbol:
        text = f"{text} {term.symbol}"
    return f"{text} [{term.unit}]" if term.unit else text


def without_unit(name: str) -> tuple[str, str]:
    """Return a number's name without its unit, and the unit.

    >>> [without_unit(name) for name in ("torque_N_m", "normal_N_m", "hand_tension_N", "advantage")]
    [('torque', 'N m'), ('normal', 'N/m'), ('hand_tension', 'N'), ('advantage', '')]
    """
    last = name.rpartition(".")[2]
    if last not in GLOSSARY:
        return split_unit_suffix(name)
    unit = GLOSSARY[last].unit.removeprefix("-")
    return name.removesuffix("_" + unit.replace("/", "_").replace(" ", "_")), unit


def answer_label(name: str) -> str:
    """Return the words for a number of an answer, with its unit, by its path such as "slip.2.utilisation".

    >>> [answer_label(name) for name in ("effective_tension_N.3", "slip.2.utilisation", "slip.2.as_plotted")]
    ['Effective tension 3 [N]', 'Friction used, slip 2', 'as plotted, slip 2']
    >>> answer_label("elements.0.tension_out_N")
    'tension out, elements 0 [N]'
    """
    first, *_ = parts = name.split(".")
    key = parts[-1] if parts[-1] in GLOSSARY or first not in GLOSSARY else first
    others = " ".join(part for part in parts if part != key)
    if key not in GLOSSARY and not others:
        return name
    words, unit = without_unit(key)
    words = GLOSSARY[key].meaning.partition(";")[0] if key in GLOSSARY else words.replace("_", " ")
    comma = "" if key == first or not others else ","
    return f"{words}{comma} {others}".rstrip() + (f" [{unit}]" if unit else "")


def counted(n: int, noun: str) -> str:
    """Return a number of things in words."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"
