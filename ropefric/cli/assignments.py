"""Options that set numbers by name: `--parameter mu=0.2`."""

import math
from collections.abc import Iterable

import typer

__all__ = ["parse_assignments"]


def parse_assignments(texts: Iterable[str], *, option: str) -> dict[str, float]:
    """Return `name=value` texts as a mapping.

    Parameters
    ----------
    texts : iterable of str
        "mu=0.2" each.
    option : str
        The option they came with, for the message.

    Raises
    ------
    typer.BadParameter
        If one is not a name, an equals sign and a finite number, or a name comes twice.

    Examples
    --------
    >>> parse_assignments(["mu_inf=0.46", "a=-0.22"], option="--parameter")
    {'mu_inf': 0.46, 'a': -0.22}
    """
    values: dict[str, float] = {}
    for text in texts:
        name, equals, number = (part.strip() for part in text.partition("="))
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not name or not equals or not math.isfinite(value):
            raise typer.BadParameter(f"{text!r} is not like mu=0.2", param_hint=option)
        if name in values:
            raise typer.BadParameter(f"{name!r} is given twice", param_hint=option)
        values[name] = value
    return values
