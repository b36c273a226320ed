"""A calculation written out by hand: every line can be checked with a pocket calculator.

Each line is worked out from the rounded numbers printed above it, as a person would, so every line is right to its
last digits.
"""

import math
import re
from collections import UserDict

_DIGITS = 9
_FUNCTIONS = {"ln": math.log, "exp": math.exp, "sqrt": math.sqrt, "sin": math.sin, "acos": math.acos}
_NAME = re.compile(r"[A-Za-z_]\w*")


class Sheet(UserDict[str, float]):
    """Lines written so far, the numbers in them by symbol, as printed, and the effects of the law."""

    def __init__(self, effects: frozenset[str] = frozenset()) -> None:
        super().__init__()
        self.lines: list[str] = []
        self.effects = effects

    def __setitem__(self, symbol: str, value: float) -> None:
        super().__setitem__(symbol, float(f"{value:.{_DIGITS}g}"))

    def say(self, text: str) -> None:
        """Write a line without arithmetic."""
        self.lines.append(text)

    def given(self, symbol: str, value: float, name: str = "") -> None:
        """Write a number that is not worked out here, and keep it under its symbol."""
        self[symbol] = value
        self.lines.append(f"{name or symbol}: {self._printed(symbol)}")

    def line(self, name: str, formula: str, symbol: str = "") -> float:
        """Write `name = arithmetic = value`, keep the value under the symbol, else the name, and return it.

        The formula is written in the symbols of the sheet, + - * / ^ ( ) and `ln`, `exp`, `sqrt`, `sin`, `acos`.
        """
        key = symbol or name
        arithmetic = _NAME.sub(
            lambda found: self._printed(found[0]) if found[0] in self else found[0], formula
        )
        # Ours, not a user's text: a law declares it.
        self[key] = eval(formula.replace("^", "**"), _FUNCTIONS | self.data)  # noqa: S307
        self.lines.append(f"{name} = {arithmetic} = {self._printed(key)}")
        return self[key]

    def _printed(self, symbol: str) -> str:
        """Return a number for the sheet; a negative one in brackets."""
        text = f"{self[symbol]:.{_DIGITS}g}"
        return f"({text})" if self[symbol] < 0.0 else text
