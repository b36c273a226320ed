"""`ropefric budget`: what makes up the uncertainty of a force, a coefficient, or a predicted lift force."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from typer import Argument, BadParameter, Option

from ropefric.cli.options import (
    NOT_TRUSTED,
    Answer,
    campaign_file,
    command,
    quantity,
    read_fit,
    read_table,
    rope_radius,
)
from ropefric.cli.output import Output, Progress
from ropefric.errors import InputError

if TYPE_CHECKING:
    from ropefric.fitting.budgets import MeasuredCondition


@command(
    'ropefric budget --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N" --u-wrap "2 deg" --u-end-tension "0.5 N"',
    order=130,
)
def budget(
    out: Output,
    source: Path | None = Argument(
        None, metavar="[CAMPAIGN.toml|TRIALS.csv]", help="A campaign, or a trial table; or use --fit."
    ),
    *,
    fit: Path | None = Option(None, metavar="FIT.json", help="Of a lift force by this fit."),
    quantity: str = Option("force", metavar="force|mu", help="F_A, or μ̄ = ln(F_A/F_B)/φ."),
    condition: int | None = Option(None, min=1, help="Only this condition, in full."),
    wheel_radius: float | None = quantity(None, "--wheel-radius", "m", "LENGTH", "R_w, with --fit."),
    wrap: float | None = quantity(None, "--wrap", "rad", "ANGLE", "φ, with --fit."),
    end_tension: float | None = quantity(None, "--end-tension", "N", "FORCE", "F_B, with --fit."),
    rope_diameter: float | None = quantity(
        None, "--rope-diameter", "m", "LENGTH", "Of another rope.", factor=0.5
    ),
    u_wheel_radius: float | None = quantity(
        None, "--u-wheel-radius", "m", "LENGTH", "Standard uncertainty of R_w."
    ),
    u_rope_diameter: float | None = quantity(
        None, "--u-rope-diameter", "m", "LENGTH", "Of the rope's diameter.", factor=0.5
    ),
    u_wrap: float | None = quantity(None, "--u-wrap", "rad", "ANGLE", 'Of the wrap, such as "2 deg".'),
    u_end_tension: float | None = quantity(None, "--u-end-tension", "N", "FORCE", 'Of F_B, such as "0.5 N".'),
    end_tension_measured: bool = Option(
        False, "--end-tension-measured", help="F_B is read by a second channel, no weights hang there."
    ),
    gain: float | None = quantity(
        None, "--gain", "", "PART", 'Limit of error of the gain, such as "0.1 %"; common to both channels.'
    ),
    gravity: float | None = quantity(
        None, "--gravity", "", "PART", 'Limit of error of g of the weights, such as "0 %" where it is known.'
    ),
    one_pull: bool = Option(False, "--one-pull", help="Of one pull with a new rope, not of the mean law."),
    level: float = Option(0.95, help="Coverage probability, between 0 and 1."),
    draws: int = Option(200_000, help="Draws that check the budget."),
    seed: int = Option(0, min=0, help="Of the draws."),
) -> Answer:
    """State an uncertainty after the GUM: a budget line by line, checked by draws, and what would shrink it.

    Of the conditions of a campaign or trial table, or, with --fit, of the lift force of a wheel that is known only so
    well. Exits with 4 when a statement is not to be trusted.
    """
    check: dict[str, Any] = {"level": level, "draws": draws, "seed": seed}
    if (source is None) == (fit is None):
        raise BadParameter("give a campaign or trial table, or --fit, and not both", param_hint="--fit")
    if fit is not None:
        wheel = {"wheel_radius_m": wheel_radius, "wrap_angle_rad": wrap, "end_tension_N": end_tension}
        uncertainty = {
            "wheel_radius_m": u_wheel_radius or 0.0,
            "rope_radius_m": u_rope_diameter or 0.0,
            "wrap_angle_rad": u_wrap or 0.0,
            "end_tension_N": u_end_tension or 0.0,
        }
        return _of_fit(out, fit, wheel, rope_diameter, uncertainty, check=check | {"one_pull": one_pull})
    from ropefric.fitting import budgets as measured  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.report.parts import budgets_section, uncertainty_sections  # noqa: PLC0415

    if quantity not in {"force", "mu"}:
        raise BadParameter(f"{quantity!r} is neither force nor mu", param_hint="--quantity")
    found = _conditions(out, Path(str(source)), gravity)
    if condition is not None:
        found = (measured.condition_numbered(found, condition),)
    if end_tension_measured:
        found = tuple(measured.with_measured_end(item, u_end_tension) for item in found)
    check |= {"quantity": quantity, "u_wrap_angle_rad": u_wrap, "gain_limit": gain or 0.0}
    stated = [(item, measured.state_condition(item, **check)) for item in found]
    if len(stated) == 1:
        sections = uncertainty_sections(stated[0][1], f"Uncertainty budget, {found[0].describe()}")
    else:
        rows = [(item.number, item.describe().partition(": ")[2], each) for item, each in stated]
        title = f"Uncertainty of {stated[0][1].model.symbol}; --condition N shows one in full"
        sections = (budgets_section(rows, title),)
    trees = [
        each.to_dict()
        | {
            "condition": item.number,
            "lift_force_N": item.lift.force_N,
            "end_tension_N": item.end.force_N,
            **{key: getattr(item, key) for key in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "n")},
        }
        for item, each in stated
    ]
    return Answer(
        {"source": str(source), "budgets": trees},
        sections,
        0 if all(each.trustworthy for _, each in stated) else NOT_TRUSTED,
    )


def _conditions(out: Output, path: Path, gravity: float | None) -> "tuple[MeasuredCondition, ...]":
    """Return the conditions of a campaign, whose recordings are extracted, or of a trial table."""
    from ropefric.fitting import budgets as measured  # noqa: PLC0415  (all of these: quick start-up)

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
        fix = "`ropefric extract` says why for each"
        raise InputError("no recording gave a usable force", code="RF301", path=file, fix=fix)
    return found


def _of_fit(
    out: Output, path: Path, wheel: dict[str, float | None], rope_m: float | None,
    uncertainty: dict[str, float], *, check: dict[str, Any],
) -> Answer:  # fmt: skip
    from ropefric.fitting.budgets import state_lift  # noqa: PLC0415  (all: quick start-up)
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.report.parts import uncertainty_sections  # noqa: PLC0415

    options = ("--wheel-radius", "--wrap", "--end-tension")
    missing = [name for name, value in zip(options, wheel.values(), strict=True) if value is None]
    if missing:
        text = f"a budget of a fit is of one wheel: {' and '.join(missing)} missing"
        raise BadParameter(text, param_hint=missing[0])
    known = {name: float(value or 0.0) for name, value in wheel.items()}
    stored = read_fit(path, out)
    at = one_condition(rope_radius_m=rope_radius(stored, rope_m), **known)
    stated = state_lift(stored, at, uncertainty, **check)
    more = {"rope_radius_m": float(at.rope_radius_m[0]), "fit": path, "fit_status": stored.status.value}
    title = f"Uncertainty budget of the {stated.model.name} by {stored.law}"
    return Answer(
        stated.to_dict() | known | more,
        uncertainty_sections(stated, title),
        0 if stated.trustworthy else NOT_TRUSTED,
    )
