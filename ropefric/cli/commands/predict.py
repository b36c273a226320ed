"""`ropefric predict`: the lift force of a wheel, from a stored fit."""

from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import FitOption, exit_code_of, read_fit, rope_radius, show_sections
from ropefric.cli.output import Output
from ropefric.cli.quantity_option import read_quantity

if TYPE_CHECKING:
    from ropefric.fitting.prediction import Method


WheelRadius = Annotated[str, typer.Option("--wheel-radius", metavar="LENGTH", help='R_w, such as "35 mm".')]
Wrap = Annotated[str, typer.Option("--wrap", metavar="ANGLE", help='φ, such as "400 deg" or "1.5 turn".')]
EndTension = Annotated[str, typer.Option("--end-tension", metavar="FORCE", help='F_B, such as "60 N".')]
RopeDiameter = Annotated[
    str, typer.Option("--rope-diameter", metavar="LENGTH", help="Of another rope than that of the trials.")
]
Speed = Annotated[str, typer.Option("--speed", metavar="SPEED", help='Of a running rope, such as "0.3 m/s".')]
Density = Annotated[
    str, typer.Option("--linear-density", metavar="DENSITY", help='Of a running rope, such as "62 g/m".')
]
Level = Annotated[float, typer.Option(help="Level of the intervals, between 0 and 1.")]
HowCarried = Annotated[
    str, typer.Option("--method", metavar="linear|monte-carlo", help="How the uncertainty is carried over.")
]
Hand = Annotated[bool, typer.Option("--hand", help="Print the calculation, to be checked by hand.")]


def predict(
    out: Output,
    *,
    fit: FitOption,
    wheel_radius: WheelRadius,
    wrap: Wrap,
    end_tension: EndTension,
    rope_diameter: RopeDiameter = "",
    speed: Speed = "",
    linear_density: Density = "",
    level: Level = 0.95,
    method: HowCarried = "linear",
    hand: Hand = False,
) -> Answer:
    """Predict the lift force of a wheel from a stored fit, with confidence and prediction interval.

    Exits with 4 when the lift force is not supported: undecided, or not judged.
    """
    R_w = read_quantity(wheel_radius, "m", "--wheel-radius")
    phi = read_quantity(wrap, "rad", "--wrap")
    F_B = read_quantity(end_tension, "N", "--end-tension")
    rope_m = 0.5 * read_quantity(rope_diameter, "m", "--rope-diameter") if rope_diameter else None
    speed_m_s = read_quantity(speed, "m/s", "--speed") if speed else None
    density_kg_m = read_quantity(linear_density, "kg/m", "--linear-density") if linear_density else None
    from ropefric.fitting.predict import predict as predict_lift  # noqa: PLC0415
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.report.parts import prediction_section  # noqa: PLC0415
    from ropefric.report.section import Section  # noqa: PLC0415

    stored = read_fit(fit, out)
    wheel = one_condition(R_w, rope_radius(stored, rope_m), phi, F_B)
    how: Method = method  # type: ignore[assignment]  # the library says what it may be
    found = predict_lift(
        stored, wheel, level=level, method=how, speed_m_s=speed_m_s, linear_density_kg_m=density_kg_m
    )
    data = found.to_dict() | {"fit": fit, "fit_status": stored.status.value}
    sections = [prediction_section(found)]
    if hand:
        lines = _by_hand(stored.friction_law.calculation(stored.theta, wheel), running=speed_m_s is not None)
        data["hand"] = list(lines)
        sections.append(Section(title="By hand", lines=lines, verbatim=True))
    return Answer(
        data=data,
        show=lambda console: show_sections(sections, console),
        exit_code=exit_code_of(found.verdict()),
    )


def _by_hand(lines: tuple[str, ...], *, running: bool) -> tuple[str, ...]:
    return ("for the rope at rest, without the centrifugal term:", *lines) if running else lines


COMMAND = Command(
    name="predict",
    run=predict,
    example='ropefric predict --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N"',
    order=120,
)
