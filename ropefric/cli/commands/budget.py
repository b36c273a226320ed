"""`ropefric budget`: what makes up the uncertainty of a force, a coefficient, or a predicted lift force."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropefric.cli.campaign_file import campaign_file
from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import NOT_TRUSTED, read_fit, read_table, rope_radius, show_sections
from ropefric.cli.output import Output
from ropefric.cli.progress import Progress
from ropefric.cli.quantity_option import read_quantity
from ropefric.errors import InputError

if TYPE_CHECKING:
    from ropefric.fitting.measured_budget import MeasuredCondition
    from ropefric.uncertainty.statement import Statement


Source = Annotated[
    Path | None,
    typer.Argument(metavar="[CAMPAIGN.toml|TRIALS.csv]", help="A campaign, or a trial table; or use --fit."),
]
Fit = Annotated[Path | None, typer.Option("--fit", metavar="FIT.json", help="Of a lift force by this fit.")]
What = Annotated[str, typer.Option("--quantity", metavar="force|mu", help="F_A, or μ̄ = ln(F_A/F_B)/φ.")]
Number = Annotated[int | None, typer.Option("--condition", min=1, help="Only this condition, in full.")]
WheelRadius = Annotated[str, typer.Option("--wheel-radius", metavar="LENGTH", help="R_w, with --fit.")]
Wrap = Annotated[str, typer.Option("--wrap", metavar="ANGLE", help="φ, with --fit.")]
EndTension = Annotated[str, typer.Option("--end-tension", metavar="FORCE", help="F_B, with --fit.")]
RopeDiameter = Annotated[str, typer.Option("--rope-diameter", metavar="LENGTH", help="Of another rope.")]
UWheel = Annotated[
    str, typer.Option("--u-wheel-radius", metavar="LENGTH", help="Standard uncertainty of R_w.")
]
URope = Annotated[str, typer.Option("--u-rope-diameter", metavar="LENGTH", help="Of the rope's diameter.")]
UWrap = Annotated[str, typer.Option("--u-wrap", metavar="ANGLE", help='Of the wrap, such as "2 deg".')]
UEnd = Annotated[str, typer.Option("--u-end-tension", metavar="FORCE", help='Of F_B, such as "0.5 N".')]
Measured = Annotated[
    bool,
    typer.Option("--end-tension-measured", help="F_B is read by a second channel, no weights hang there."),
]
Gain = Annotated[
    str,
    typer.Option(
        metavar="PART", help='Limit of error of the gain, such as "0.1 %"; common to both channels.'
    ),
]
Gravity = Annotated[
    str,
    typer.Option(metavar="PART", help='Limit of error of g of the weights, such as "0 %" where it is known.'),
]
OnePull = Annotated[
    bool, typer.Option("--one-pull", help="Of one pull with a new rope, not of the mean law.")
]
Level = Annotated[float, typer.Option(help="Coverage probability, between 0 and 1.")]
Draws = Annotated[int, typer.Option(help="Draws that check the budget.")]
Seed = Annotated[int, typer.Option(min=0, help="Of the draws.")]


def budget(
    out: Output,
    source: Source = None,
    *,
    fit: Fit = None,
    quantity: What = "force",
    condition: Number = None,
    wheel_radius: WheelRadius = "",
    wrap: Wrap = "",
    end_tension: EndTension = "",
    rope_diameter: RopeDiameter = "",
    u_wheel_radius: UWheel = "",
    u_rope_diameter: URope = "",
    u_wrap: UWrap = "",
    u_end_tension: UEnd = "",
    end_tension_measured: Measured = False,
    gain: Gain = "",
    gravity: Gravity = "",
    one_pull: OnePull = False,
    level: Level = 0.95,
    draws: Draws = 200_000,
    seed: Seed = 0,
) -> Answer:
    """State an uncertainty after the GUM: a budget line by line, checked by draws, and what would shrink it.

    Of the conditions of a campaign or trial table, or, with --fit, of the lift force of a wheel that is known only so
    well. Exits with 4 when a statement is not to be trusted.
    """
    if (source is None) == (fit is None):
        raise typer.BadParameter("give a campaign or trial table, or --fit, and not both", param_hint="--fit")
    check: dict[str, Any] = {"level": level, "draws": draws, "seed": seed}
    u_wrap_rad = _read(u_wrap, "rad", "--u-wrap")
    u_end_N = _read(u_end_tension, "N", "--u-end-tension")
    if fit is not None:
        _need({"--wheel-radius": wheel_radius, "--wrap": wrap, "--end-tension": end_tension})
        wheel = {
            "wheel_radius_m": read_quantity(wheel_radius, "m", "--wheel-radius"),
            "wrap_angle_rad": read_quantity(wrap, "rad", "--wrap"),
            "end_tension_N": read_quantity(end_tension, "N", "--end-tension"),
        }
        rope_m = _read(rope_diameter, "m", "--rope-diameter")
        uncertainty = {
            "wheel_radius_m": _read(u_wheel_radius, "m", "--u-wheel-radius") or 0.0,
            "rope_radius_m": 0.5 * (_read(u_rope_diameter, "m", "--u-rope-diameter") or 0.0),
            "wrap_angle_rad": u_wrap_rad or 0.0,
            "end_tension_N": u_end_N or 0.0,
        }
        half = None if rope_m is None else 0.5 * rope_m
        return _of_fit(out, fit, wheel, half, uncertainty, one_pull=one_pull, check=check)
    from ropefric.fitting import measured_budget as measured  # noqa: PLC0415  (quick start-up)

    if quantity not in {"force", "mu"}:
        raise typer.BadParameter(f"{quantity!r} is neither force nor mu", param_hint="--quantity")
    parts = {"gain": _read(gain, "", "--gain") or 0.0, "gravity": _read(gravity, "", "--gravity")}
    found = _conditions(out, Path(str(source)), parts["gravity"])
    if condition is not None:
        found = (measured.condition_numbered(found, condition),)
    if end_tension_measured:
        found = tuple(measured.with_measured_end(item, u_end_N) for item in found)
    told = check | {"quantity": quantity, "u_wrap_angle_rad": u_wrap_rad, "gain_limit": parts["gain"] or 0.0}
    stated = [(item, measured.state_condition(item, **told)) for item in found]
    return _answer(stated, str(source))


def _need(options: dict[str, str]) -> None:
    """Refuse a fit without the wheel it is asked about."""
    missing = [name for name, text in options.items() if not text]
    if missing:
        raise typer.BadParameter(
            f"a budget of a fit is of one wheel: {' and '.join(missing)} missing", param_hint=missing[0]
        )


def _read(text: str, unit: str, option: str) -> float | None:
    """Return an option's quantity; None where it is not given."""
    return read_quantity(text, unit, option) if text else None


def _conditions(out: Output, path: Path, gravity: float | None) -> "tuple[MeasuredCondition, ...]":
    """Return the conditions of a campaign, whose recordings are extracted, or of a trial table."""
    from ropefric.fitting import measured_budget as measured  # noqa: PLC0415  (all of these: quick start-up)

    limit = measured.GRAVITY_LIMIT if gravity is None else gravity
    file = campaign_file(path)
    if file.suffix != ".toml":
        return measured.conditions_of_table(read_table(path, out), gravity_limit=limit)
    from ropefric.trials.campaign import load_campaign  # noqa: PLC0415
    from ropefric.trials.extract import extract_campaign  # noqa: PLC0415

    campaign = load_campaign(file, missing_recordings="flag")
    with Progress(out, "extract") as progress:
        extraction = extract_campaign(campaign, progress=progress.update)
    found = measured.conditions_of_extraction(
        extraction, weights_tolerance=campaign.weights_tolerance, gravity_limit=limit
    )
    if not found:
        raise InputError(
            "no recording gave a usable force",
            code="RF301",
            path=file,
            fix="`ropefric extract` says why for each",
        )
    return found


def _of_fit(
    out: Output,
    path: Path,
    wheel: dict[str, float],
    rope_m: float | None,
    uncertainty: dict[str, float],
    *,
    one_pull: bool,
    check: dict[str, Any],
) -> Answer:
    from ropefric.fitting.lift_budget import WheelUncertainty, state_lift  # noqa: PLC0415  (all: quick start-up)
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.report.uncertainty import uncertainty_sections  # noqa: PLC0415

    stored = read_fit(path, out)
    at = one_condition(
        wheel["wheel_radius_m"], rope_radius(stored, rope_m), wheel["wrap_angle_rad"], wheel["end_tension_N"]
    )
    stated = state_lift(stored, at, WheelUncertainty(**uncertainty), one_pull=one_pull, **check)
    more = wheel | {
        "rope_radius_m": float(at.rope_radius_m[0]),
        "fit": path,
        "fit_status": stored.status.value,
    }
    sections = uncertainty_sections(stated, f"Uncertainty budget of the {stated.model.name} by {stored.law}")
    return Answer(
        data=stated.to_dict() | more,
        show=lambda console: show_sections(sections, console),
        exit_code=0 if stated.trustworthy else NOT_TRUSTED,
    )


def _answer(stated: "list[tuple[MeasuredCondition, Statement]]", source: str) -> Answer:
    from ropefric.report.uncertainty import budgets_section, uncertainty_sections  # noqa: PLC0415  (quick start-up)

    sections: list[Any] = []
    if len(stated) == 1:
        (item, only), *_ = stated
        sections += uncertainty_sections(only, f"Uncertainty budget, {item.describe()}")
    else:
        rows = [(item.number, item.describe().partition(": ")[2], each) for item, each in stated]
        name = stated[0][1].model
        sections.append(
            budgets_section(rows, f"Uncertainty of {name.symbol}; --condition N shows one in full")
        )
    trees = [
        each.to_dict()
        | {
            "condition": item.number,
            "wheel_radius_m": item.wheel_radius_m,
            "rope_radius_m": item.rope_radius_m,
            "wrap_angle_rad": item.wrap_angle_rad,
            "lift_force_N": item.lift.force_N,
            "end_tension_N": item.end.force_N,
            "n": item.n,
        }
        for item, each in stated
    ]
    return Answer(
        data={"source": source, "budgets": trees},
        show=lambda console: show_sections(sections, console),
        exit_code=0 if all(each.trustworthy for _, each in stated) else NOT_TRUSTED,
    )


COMMAND = Command(
    name="budget",
    run=budget,
    example='ropefric budget --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N" --u-wrap "2 deg" --u-end-tension "0.5 N"',
    order=130,
)
