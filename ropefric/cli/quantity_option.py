"""Options that are quantities: written with their unit, as in a campaign file."""

import typer

from ropefric.errors import InputError

__all__ = ["read_quantity"]


def read_quantity(text: str, si_unit: str, option: str) -> float:
    """Return an option's quantity in SI.

    Parameters
    ----------
    text : str
        "35 mm".
    si_unit : str
        The unit of the result: "m".
    option : str
        The option it came with, for the message.

    Raises
    ------
    typer.BadParameter
        For a bare number, an unknown unit or another dimension; its cause shows how to write it.

    Examples
    --------
    >>> read_quantity("35 mm", "m", "--wheel-radius")
    0.035
    """
    from ropefric.quantities import parse_quantity  # noqa: PLC0415  (quick start-up)

    try:
        return parse_quantity(text, si_unit, name=option)
    except InputError as error:
        raise typer.BadParameter(str(error), param_hint=option) from error
