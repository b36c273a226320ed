"""`ropefric predict`: the lift force of a wheel, from a stored fit."""

from typing import TYPE_CHECKING

from typer import Option

from ropefric.cli.options import (
    ROPE_DIAMETER,
    Answer,
    Command,
    FitOption,
    Level,
    exit_code_of,
    quantity,
    read_fit,
    rope_radius,
)
from ropefric.cli.output import Output

if TYPE_CHECKING:
    from ropefric.fitting.predict import Method


def predict(
    out: Output,
    *,
    fit: FitOption,
    wheel_radius: float = quantity(..., "--wheel-radius", "m", "LENGTH", 'R_w, such as "35 mm".'),
    wrap: float = quantity(..., "--wrap", "rad", "ANGLE", 'φ, such as "400 deg" or "1.5 turn".'),
    end_tension: float = quantity(..., "--end-tension", "N", "FORCE", 'F_B, such as "60 N".'),
    rope_diameter: float | None = ROPE_DIAMETER,
    speed: float | None = quantity(None, "--speed", "m/s", "SPEED", 'Of a running rope, such as "0.3 m/s".'),
    linear_density: float | None = quantity(
        None, "--linear-density", "kg/m", "DENSITY", 'Of a running rope, such as "62 g/m".'
    ),
    level: Level = 0.95,
    method: str = Option("linear", metavar="linear|monte-carlo", help="How the uncertainty is carried over."),
    hand: bool = Option(False, "--hand", help="Print the calculation, to be checked by hand."),
) -> Answer:
    """Predict the lift force of a wheel from a stored fit, with confidence and prediction interval.

    Exits with 4 when the lift force is not supported: undecided, or not judged.
    """
    from ropefric.fitting.predict import predict as predict_lift  # noqa: PLC0415
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.report.parts import prediction_section  # noqa: PLC0415
    from ropefric.report.section import Section  # noqa: PLC0415

    stored = read_fit(fit, out)
    wheel = one_condition(wheel_radius, rope_radius(stored, rope_diameter), wrap, end_tension)
    how: Method = method  # type: ignore[assignment]  # the library says what it may be
    found = predict_lift(
        stored, wheel, level=level, method=how, speed_m_s=speed, linear_density_kg_m=linear_density
    )
    data = found.to_dict() | {"fit": fit, "fit_status": stored.status.value}
    sections = [prediction_section(found)]
    if hand:
        running = ("for the rope at rest, without the centrifugal term:",) if speed is not None else ()
        lines = (*running, *stored.friction_law.calculation(stored.theta, wheel))
        data["hand"] = list(lines)
        sections.append(Section(title="By hand", lines=lines, verbatim=True))
    return Answer(data, sections, exit_code_of(found.verdict()))


COMMAND = Command(
    "predict",
    predict,
    'ropefric predict --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N"',
    order=120,
)
