"""Words on figures: the glossary's, typeset; conditions named the way people speak of them."""

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ropefric.files.plain_text import visible
from ropefric.glossary import axis_label

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ropefric.trials.result import ConditionSummary

__all__ = ["ConditionName", "figure_label", "figure_text", "name_condition", "name_files", "typeset"]

_SUBSCRIPT = re.compile(r"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]++)_([A-Za-z0-9]++(?:,[A-Za-z0-9]++)*+)")

_OWN_MATHEMATICS = re.compile(r"(\$(?:[A-Za-zφμρσ']++_\{\\mathrm\{[A-Za-z0-9,]++\}\}/?)++\$)")
_LONGEST_WORD = 60  # beyond, nothing else has room
_DOLLAR = re.compile(r"(?<!\\)\$")


def typeset(text: str) -> str:
    r"""Return text with plain symbols such as F_A set as mathematics.

    Examples
    --------
    >>> typeset("Break-away force F_A [N]")
    'Break-away force $F_{\\mathrm{A}}$ [N]'
    """
    return _SUBSCRIPT.sub(r"$\1_{\\mathrm{\2}}$", text)


def figure_text(text: str) -> str:
    r"""Return text as it may stand in a figure: what is not our own mathematics is none, and all of it shows.

    Examples
    --------
    >>> figure_text(r"trial $\frac{$ at $F_{\mathrm{A}}$")
    'trial \\$\\frac{\\$ at $F_{\\mathrm{A}}$'
    """
    for word in set(text.split()):
        if len(word) > _LONGEST_WORD:
            text = text.replace(word, f"{word[: _LONGEST_WORD - 1]}…")
    parts = _OWN_MATHEMATICS.split(visible(text))
    return "".join(part if place % 2 else _DOLLAR.sub(r"\$", part) for place, part in enumerate(parts))


def figure_label(name: str) -> str:
    """Return a quantity's axis label with typeset symbol and unit.

    Parameters
    ----------
    name : str
        A glossary name.

    Raises
    ------
    UnknownNameError
        If the glossary does not have it.

    Examples
    --------
    >>> figure_label("time_s")
    'Time t [s]'
    """
    return typeset(axis_label(name))


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionName:
    """A condition in the units people use at the rig.

    Attributes
    ----------
    wheel_mm, rope_mm, wrap_deg, tension_N : str
        Radii, wrap angle and the known tension, to six digits.
    symbol : str
        Which tension is known: "F_B", or "F_A" where the slack side is what the sensor measures.

    Examples
    --------
    >>> name = ConditionName(wheel_mm="40", rope_mm="4.9", wrap_deg="540", tension_N="80", symbol="F_B")
    >>> name.stem
    'Rw40mm_phi540deg_FB80N'
    """

    wheel_mm: str
    rope_mm: str
    wrap_deg: str
    tension_N: str
    symbol: str

    @property
    def title(self) -> str:
        """Return the condition for a figure's title."""
        radii = f"R_w = {self.wheel_mm} mm,  R_r = {self.rope_mm} mm"
        return typeset(f"{radii},  φ = {self.wrap_deg}°,  {self.symbol} = {self.tension_N} N")

    @property
    def stem(self) -> str:
        """Return the condition as a file name without suffix."""
        return f"Rw{self.wheel_mm}mm_phi{self.wrap_deg}deg_{self.symbol.replace('_', '')}{self.tension_N}N"


def name_condition(summary: "ConditionSummary", *, measures_slack: bool) -> ConditionName:
    """Return what a condition is called.

    Parameters
    ----------
    summary : ConditionSummary
        The condition.
    measures_slack : bool
        Whether its trials measure the slack side, so that the lift force is the known one.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> condition = SimpleNamespace(wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=3 * math.pi,
    ...     end_tension_N=80.0, lift_force_N=321.7)
    >>> name_condition(condition, measures_slack=False).stem
    'Rw40mm_phi540deg_FB80N'
    """
    known_N = summary.lift_force_N if measures_slack else summary.end_tension_N
    return ConditionName(
        wheel_mm=f"{1e3 * summary.wheel_radius_m:.6g}",
        rope_mm=f"{1e3 * summary.rope_radius_m:.6g}",
        wrap_deg=f"{math.degrees(summary.wrap_angle_rad):.6g}",
        tension_N=f"{known_N:.6g}",
        symbol="F_A" if measures_slack else "F_B",
    )


def name_files(names: "Iterable[ConditionName]") -> list[str]:
    """Return a file name (without suffix) for each condition, all different.

    Examples
    --------
    >>> thin, thick = (ConditionName(wheel_mm="40", rope_mm=rope, wrap_deg="540", tension_N="80", symbol="F_B")
    ...     for rope in ("4", "5"))
    >>> name_files([thin, thick])
    ['Rw40mm_phi540deg_FB80N', 'Rw40mm_phi540deg_FB80N_2']
    """
    seen: dict[str, int] = {}
    stems = []
    for name in names:
        seen[name.stem] = seen.get(name.stem, 0) + 1
        stems.append(name.stem if seen[name.stem] == 1 else f"{name.stem}_{seen[name.stem]}")
    return stems
