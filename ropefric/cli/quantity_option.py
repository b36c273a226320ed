"""Options that are quantities: written with their unit, as in a campaign file."""

import typer

from ropefric.errors import InputError


def read_quantity(text: str, si_unit: str, option: str) -> float:
    """Return an option's quantity in SI."""
    from ropefric.quantities import parse_quantity  # noqa: PLC0415  (quick start-up)

    try:
        return parse_quantity(text, si_unit, name=option)
    except InputError as error:
        raise typer.BadParameter(str(error), param_hint=option) from error
