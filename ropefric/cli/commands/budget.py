"""`ropefric budget`: what makes up the uncertainty of a force, a coefficient, or a predicted lift force."""

from pathlib import Path
from typing import Any

from typer import Argument, BadParameter, Option

from ropefric.cli import options
from ropefric.cli.lazily import on_first_use
from ropefric.cli.options import Answer, Number, command, flag, quantity
from ropefric.cli.output import Output, Progress
from ropefric.errors import InputError

with on_first_use():
    from ropefric.fitting import budgets
    from ropefric.friction import condition as conditions
    from ropefric.report import parts
    from ropefric.trials import campaign as campaigns
    from ropefric.trials import extract as extracting


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
    of: str = Option("force", "--quantity", metavar="force|mu", help="F_A, or μ̄ = ln(F_A/F_B)/φ."),
    condition: int | None = Option(None, min=1, help="Only this condition, in full."),
    wheel_radius: Number = quantity("--wheel-radius", "m", "R_w, with --fit."),
    wrap: Number = quantity("--wrap", "rad", "φ, with --fit."),
    end_tension: Number = quantity("--end-tension", "N", "F_B, with --fit."),
    rope_diameter: Number = options.diameter("--rope-diameter", "Of another rope."),
    u_wheel_radius: Number = quantity("--u-wheel-radius", "m", "Standard uncertainty of R_w."),
    u_rope_diameter: Number = options.diameter("--u-rope-diameter", "Of the rope's options.diameter."),
    u_wrap: Number = quantity("--u-wrap", "rad", 'Of the wrap, such as "2 deg".'),
    u_end_tension: Number = quantity("--u-end-tension", "N", 'Of F_B, such as "0.5 N".'),
    end_tension_measured: bool = flag(
        "--end-tension-measured", "F_B is read by a second channel, no weights hang there."
    ),
    gain: Number = quantity(
        "--gain", "", 'Limit of error of the gain, such as "0.1 %"; common to both channels.'
    ),
    gravity: Number = quantity(
        "--gravity", "", 'Limit of error of g of the weights, such as "0 %" where it is known.'
    ),
    one_pull: bool = flag("--one-pull", "Of one pull with a new rope, not of the mean law."),
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
    if of not in {"force", "mu"}:
        raise BadParameter(f"{of!r} is neither force nor mu", param_hint="--quantity")
    found = _conditions(out, Path(str(source)), gravity)
    if condition is not None:
        found = (budgets.condition_numbered(found, condition),)
    if end_tension_measured:
        found = tuple(budgets.with_measured_end(item, u_end_tension) for item in found)
    check |= {"quantity": of, "u_wrap_angle_rad": u_wrap, "gain_limit": gain or 0.0}
    stated = [(item, budgets.state_condition(item, **check)) for item in found]
    if len(stated) == 1:
        title = f"Uncertainty budget, {found[0].describe()}"
        sections = parts.uncertainty_sections(stated[0][1], title)
    else:
        rows = [(item.number, item.describe().partition(": ")[2], each) for item, each in stated]
        title = f"Uncertainty of {stated[0][1].model.symbol}; --condition N shows one in full"
        sections = (parts.budgets_section(rows, title),)
    trees = [
        each.to_dict()
        | {"condition": item.number, "lift_force_N": item.lift.force_N, "end_tension_N": item.end.force_N}
        | {key: getattr(item, key) for key in ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "n")}
        for item, each in stated
    ]
    good = all(each.trustworthy for _, each in stated)
    return Answer({"source": str(source), "budgets": trees}, sections, options.exit_code_of(good))


def _conditions(out: Output, path: Path, gravity: float | None) -> "tuple[budgets.MeasuredCondition, ...]":
    """Return the conditions of a campaign, whose recordings are extracted, or of a trial table."""
    limit = budgets.GRAVITY_LIMIT if gravity is None else gravity
    file = options.campaign_file(path)
    if file.suffix != ".toml":
        return budgets.conditions_of_table(options.read_table(path, out), gravity_limit=limit)
    campaign = campaigns.load_campaign(file, missing_recordings="flag")
    with Progress(out, "extract") as progress:
        extraction = extracting.extract_campaign(campaign, progress=progress.update)
    found = budgets.conditions_of_extraction(
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
    names = ("--wheel-radius", "--wrap", "--end-tension")
    missing = [name for name, value in zip(names, wheel.values(), strict=True) if value is None]
    if missing:
        text = f"a budget of a fit is of one wheel: {' and '.join(missing)} missing"
        raise BadParameter(text, param_hint=missing[0])
    known = {name: float(value or 0.0) for name, value in wheel.items()}
    stored = options.read_fit(path, out)
    at = conditions.one_condition(rope_radius_m=options.rope_radius(stored, rope_m), **known)
    stated = budgets.state_lift(stored, at, uncertainty, **check)
    more = {"rope_radius_m": float(at.rope_radius_m[0]), "fit": path, "fit_status": stored.status.value}
    return Answer(
        stated.to_dict() | known | more,
        parts.uncertainty_sections(stated, f"Uncertainty budget of the {stated.model.name} by {stored.law}"),
        options.exit_code_of(stated.trustworthy),
    )
