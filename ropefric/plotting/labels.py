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


_SUBSCRIPT = re.compile(r"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]++)_([A-Za-z0-9]++(?:,[A-Za-z0-9]++)*+)")

_OWN_MATHEMATICS = re.compile(r"(\$(?:[A-Za-zφμρσ']++_\{\\mathrm\{[A-Za-z0-9,]++\}\}/?)++\$)")
_LONGEST_WORD = 60  # beyond, nothing else has room
_DOLLAR = re.compile(r"(?<!\\)\$")


def typeset(text: str) -> str:
    r"""Return text with plain symbols such as F_A set as mathematics."""
    return _SUBSCRIPT.sub(r"$\1_{\\mathrm{\2}}$", text)


def figure_text(text: str) -> str:
    r"""Return text as it may stand in a figure: what is not our own mathematics is none, and all of it shows."""
    for word in set(text.split()):
        if len(word) > _LONGEST_WORD:
            text = text.replace(word, f"{word[: _LONGEST_WORD - 1]}…")
    parts = _OWN_MATHEMATICS.split(visible(text))
    return "".join(part if place % 2 else _DOLLAR.sub(r"\$", part) for place, part in enumerate(parts))


def figure_label(name: str) -> str:
    """Return a quantity's axis label with typeset symbol and unit."""
    return typeset(axis_label(name))


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionName:
    """A condition in the units people use at the rig."""

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
    """Return what a condition is called."""
    known_N = summary.lift_force_N if measures_slack else summary.end_tension_N
    return ConditionName(
        wheel_mm=f"{1e3 * summary.wheel_radius_m:.6g}",
        rope_mm=f"{1e3 * summary.rope_radius_m:.6g}",
        wrap_deg=f"{math.degrees(summary.wrap_angle_rad):.6g}",
        tension_N=f"{known_N:.6g}",
        symbol="F_A" if measures_slack else "F_B",
    )


def name_files(names: "Iterable[ConditionName]") -> list[str]:
    """Return a file name (without suffix) for each condition, all different."""
    seen: dict[str, int] = {}
    stems = []
    for name in names:
        seen[name.stem] = seen.get(name.stem, 0) + 1
        stems.append(name.stem if seen[name.stem] == 1 else f"{name.stem}_{seen[name.stem]}")
    return stems
