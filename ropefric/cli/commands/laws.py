"""The commands of friction laws: fitted and compared; stored fits shown, made again, and asked of wheels.

A wheel's lift force, its uncertainty, the smallest wheel, the next tests.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from typer import Argument, BadParameter, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, Number, Words, command, exit_code_of, flag, listed, option, quantity
from ropefric.cli.output import Output, Progress
from ropefric.files.disk import write_file

with on_first_use():
    from ropefric import section
    from ropefric.fitting import budgets, next_tests, resolution, store
    from ropefric.fitting import compare as comparing
    from ropefric.fitting import design as designs
    from ropefric.fitting import diagnose as diagnosing
    from ropefric.fitting import fit as fitting
    from ropefric.fitting import intervals as confidence
    from ropefric.fitting import predict as predicting
    from ropefric.friction import condition as conditions
    from ropefric.friction import laws as friction_laws
    from ropefric.report import parts


_OF = Option(
    "peak", metavar="peak|kinetic", help="Fit the break-away force, or the mean force while sliding."
)


@command("ropefric fit fits/prth-trials.csv --law coupled --out coupled.json", order=80)
def fit(
    out: Output,
    trials: options.TableArgument,
    *,
    law: str = Option(..., help="The friction law: constant, wrap-power, coupled, …"),
    fix: Words = listed("NAME=VALUE", "Hold a parameter"),
    bound: Words = listed("NAME=LOW:HIGH", "Bounds of a parameter"),
    start: Words = Option(None, metavar="NAME=VALUE", help="Start value; the law guesses others."),
    intervals: str = option(
        "auto|covariance|profile",
        "Where the 95 % intervals come from; auto is the covariance where it will do, else the profile.",
        default="auto",
    ),
    groups: Words = listed(
        "COLUMN", "A column whose levels may differ in μ; rope_id, operator, … by default"
    ),
    shared: Words = listed("ERROR=BY", "By what a stated error is shared: wrap=rig, wheel_radius=wheel"),
    seed: int = Option(0, min=0, help="Of the search's further starts."),
    of: str = _OF,
    file: Path | None = Option(None, "--out", "-o", metavar="FIT.json", help="Store the fit there."),
    force: bool = flag("--force", "Write over a file that is there and is no fit."),
) -> Answer:
    """Fit a friction law to a trial table: parameters with 95 % intervals, and whether to trust them.

    Exits with 4 when the law is not supported by its fit: undecided, or not judged; the status says more.
    """
    given = {
        "fixed": options.parse_assignments(fix or (), option="--fix"),
        "bounds": options.parse_spans(bound or (), option="--bound"),
        "start": options.parse_assignments(start or (), option="--start"),
    }
    given |= {"groups": tuple(groups) if groups else None, "shared": options.parse_sharers(shared)}
    if file is not None:  # before the work
        store.check_target(file, trials, overwrite=force)
    table = options.read_table(trials, out, of=of)
    result = confidence.with_intervals(fitting.fit_law(table, law, seed=seed, **given), intervals)
    if file is not None:
        out.note(f"wrote {store.save_fit(result, file, overwrite=force)}")
    verdict = parts.verdict_section(result.verdict, "The verdict, by this fit alone")
    sections = [parts.fit_section(result), verdict, *parts.notes_sections(result)]
    data = result.to_dict() | {"verdict": result.verdict.to_dict(), "of": result.of}
    return Answer(data, sections, exit_code_of(result.verdict))


@command("ropefric compare fits/prth-trials.csv", order=100)
def compare(
    out: Output,
    trials: options.TableArgument,
    *,
    laws: Words = listed("NAME[,NAME…]", "Laws to compare, all by default"),
    of: str = _OF,
) -> Answer:
    """Rank friction laws on a trial table by AICc, with weights and the error at unseen conditions.

    The two constant laws always stand in the comparison. Exits with 4 unless the best law is supported: when the
    data leave two laws undecided, or no choice at all.
    """
    names = [name.strip() for text in laws or () for name in text.split(",") if name.strip()]
    table = options.read_table(trials, out, of=of)
    with Progress(out, "fit") as progress:
        told = progress.update_named
        found = comparing.compare_laws(table, names or None, progress=told)
    chosen = comparing.choose_law(found)
    verdict = parts.verdict_section(chosen.verdict, f"The law: {chosen.fit.law}")
    data = found.to_dict() | chosen.to_dict() | {"of": table.force}
    return Answer(data, [parts.comparison_section(found), verdict], exit_code_of(chosen.verdict))


@command("ropefric diagnose fits/prth-trials.csv", order=110)
def diagnose(out: Output, trials: options.TableArgument) -> Answer:
    """Say why trials do not obey the capstan equation, with the evidence: offset, load, size, wrap.

    Columns rope_id, wheel, mounting, operator, day, dwell and order of the table are tested too. For an effect
    that is not supported, the largest size that the data allow is stated.

    Exits with 4 unless the best law is supported: when the data leave two laws undecided, or no choice at all.
    """
    found = diagnosing.diagnose(options.read_table(trials, out))
    return Answer(found.to_dict(), [parts.diagnosis_section(found, full=True)], exit_code_of(found.verdict))


@command("ropefric show fits/prth-coupled.json", order=90)
def show(out: Output, file: Path = Argument(..., metavar="FIT.json", help="A stored fit.")) -> Answer:
    """Show a stored fit: its parameters, whether to trust it, what it was made from, where it holds.

    Exits with 4 when its law is not supported: undecided, or not judged.
    """
    fit = options.read_fit(file, out)
    sections = [parts.fit_section(fit, short=True), *parts.notes_sections(fit), parts.origin_section(fit)]
    return Answer(fit.to_dict() | {"verdict": fit.verdict.to_dict()}, sections, exit_code_of(fit.verdict))


@command("ropefric verify fits/", order=190)
def verify(
    out: Output,
    folder: Path = Argument(Path("fits"), metavar="FOLDER", help="The folder of the stored fits."),
) -> Answer:
    """Fit every stored fit of a folder again from its data, and compare.

    Exits with 4 when one does not come out again.
    """
    found = store.verify_fits(folder)
    n_ok = sum(item.ok for item in found)
    out.note(f"{n_ok} of {len(found)} fits come out of their data again")
    words, good = {True: "ok", False: "FAILED"}, n_ok == len(found)
    rows = [(Path(i.path).name, words[i.ok], section.plain(i.difference, ".1g"), i.message) for i in found]
    headings = ("fit", "", "change [standard errors]", "found ")
    shown = section.Section(headings=headings, rows=rows, left=2)
    return Answer({"ok": good, "fits": [item._asdict() for item in found]}, [shown], exit_code_of(good))


@command(
    'ropefric predict --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N"',
    order=120,
)
def predict(
    out: Output,
    *,
    fit: options.FitOption,
    wheel_radius: float = quantity("--wheel-radius", "m", 'R_w, such as "35 mm".', needed=True),
    wrap: float = quantity("--wrap", "rad", 'φ, such as "400 deg" or "1.5 turn".', needed=True),
    end_tension: float = quantity("--end-tension", "N", 'F_B, such as "60 N".', needed=True),
    rope_diameter: float | None = options.ROPE_DIAMETER,
    speed: Number = quantity("--speed", "m/s", 'Of a running rope, such as "0.3 m/s".'),
    linear_density: Number = quantity("--linear-density", "kg/m", 'Of a running rope, such as "62 g/m".'),
    rope: str | None = Option(None, metavar="ROPE_ID", help="A rope of the trials: the force with that one."),
    level: options.Level = 0.95,
    method: str = Option("auto", metavar="auto|linear|profile", help="How the uncertainty is carried over."),
    hand: bool = flag("--hand", "Print the calculation, to be checked by hand."),
) -> Answer:
    """Predict the lift force of a wheel from a stored fit, with confidence and prediction interval.

    Exits with 4 when the lift force is not supported: undecided, or not judged.
    """
    stored = options.read_fit(fit, out)
    rope_m = options.rope_radius(stored, rope_diameter)
    wheel = conditions.one_condition(wheel_radius, rope_m, wrap, end_tension)
    running_rope = {"speed_m_s": speed, "linear_density_kg_m": linear_density}
    # The library says what the method may be.
    found = predicting.predict(stored, wheel, level=level, method=method, rope=rope, **running_rope)  # type: ignore[arg-type]
    data = found.to_dict() | {"fit": fit, "fit_status": stored.status.value}
    sections = [parts.prediction_section(found)]
    if (of := found.this_rope) is not None:
        lines = [f"F_A = {of.lift_force_N[0]:.4g} N"]
        for what, ends in (("its mean", of.interval_N), ("one pull with it", of.prediction_interval_N)):
            lines.append(f"{100 * level:g} % interval of {what}: {ends[0, 0]:.4g} N to {ends[0, 1]:.4g} N")
        sections.append(section.Section(title=f"With rope {of.rope}", lines=tuple(lines)))
    if hand:
        running = ("for the rope at rest, without the centrifugal term:",) if speed is not None else ()
        shown = (*running, *stored.friction_law.calculation(stored.theta, wheel))
        data["hand"] = list(shown)
        sections.append(section.Section(title="By hand", lines=shown, verbatim=True))
    return Answer(data, sections, exit_code_of(found.verdict))


_SHOWN = {"wrap": ("wrap", math.degrees(1.0), "deg"), "radius": ("wheel radius", 1e3, "mm"),
          "end_tension": ("end tension", 1.0, "N")}  # fmt: skip


@command(
    'ropefric design --fit fits/prth-coupled.json --lift "900 N" --solve-for wrap --wheel-radius "40 mm" '
    '--end-tension "80 N"',
    order=140,
)
def design(
    out: Output,
    *,
    fit: options.FitOption,
    lift: float = quantity("--lift", "N", 'The load, such as "900 N".', needed=True),
    solve_for: str = Option("wrap", metavar="wrap|radius|end-tension", help="The quantity to find."),
    wheel_radius: Number = quantity("--wheel-radius", "m", "R_w, unless looked for."),
    wrap: Number = quantity("--wrap", "rad", "φ, unless looked for."),
    end_tension: Number = quantity("--end-tension", "N", "F_B, unless looked for."),
    rope_diameter: float | None = options.ROPE_DIAMETER,
    probability: float = Option(
        0.95, help="Probability, 0.5 or more, that one pull with a new rope lifts the load."
    ),
    on_average: bool = flag("--on-average", "Ask only that the mean law lifts the load."),
) -> Answer:
    """Find the smallest wrap, wheel radius or end tension that lifts a load with a probability.

    Exits with 4 when there is none, or the law is not supported by its fit.
    """
    stored = options.read_fit(fit, out)
    asked: dict[str, Any] = {"lift_N": lift, "rope_radius_m": options.rope_radius(stored, rope_diameter)}
    asked |= {"wheel_radius_m": wheel_radius, "wrap_angle_rad": wrap, "end_tension_N": end_tension}
    asked["solve_for"] = solve_for.replace("-", "_")  # the library says what it may be
    found = designs.design(stored, **asked, probability=None if on_average else probability)
    about = {"fit": fit, "law": stored.law, "fit_status": stored.status.value}
    code = exit_code_of(bool(found.reached[0]) and stored.verdict.supported)
    return Answer(found.to_dict() | about, [_section(found)], code)


def _section(found: "designs.Design") -> "section.Section":
    title = f"A design for {found.required_N[0]:.4g} N"
    if not found.reached[0]:
        return section.Section(title=title, lines=(found.explain(),))
    name, factor, unit = _SHOWN[found.solve_for]
    wrap_deg, average_N = math.degrees(found.wrap_angle_rad[0]), found.lift_force_N[0]
    where = f"R_w = {1e3 * found.wheel_radius_m[0]:.4g} mm, wrap {wrap_deg:.4g} deg"
    lines = [
        f"{name} = {found.value[0] * factor:.4g} {unit}",
        f"{where}, F_B = {found.end_tension_N[0]:.4g} N: F_A = {average_N:.4g} N on average",
    ]
    if found.probability is not None:
        share, bound_N = 100 * found.probability, found.lower_bound_N[0]
        lines.append(f"{share:g} % of pulls with a new rope lift more than {bound_N:.4g} N")
    if found.status[0] != 0:
        lines.append(found.explain())
    notes = ("the design lies outside what was tested",) if found.extrapolated[0] else ()
    return section.Section(title=title, lines=tuple(lines), notes=notes)


@command(
    'ropefric plan-tests --fit fits/prth-coupled.json --wheels "15 mm, 30 mm, 60 mm" '
    '--wraps "90 deg .. 1080 deg" --end-tensions "5 N .. 200 N" --max-force "800 N" --wheel-radius "100 mm" '
    '--wrap "720 deg" --end-tension "80 N"',
    order=150,
)
def plan_tests(
    out: Output,
    *,
    wheels: str = Option(..., metavar="LENGTHS", help='The wheels there are: "15 mm, 20 mm, 40 mm".'),
    wraps: str = Option(..., metavar="ANGLES", help='A list, or a range: "90 deg .. 1080 deg".'),
    end_tensions: str = Option(..., metavar="FORCES", help='A list, or a range: "5 N .. 200 N".'),
    max_force: float = quantity("--max-force", "N", "The largest F_A the cell takes.", needed=True),
    wheel_radius: float = quantity("--wheel-radius", "m", "R_w of the wanted wheel.", needed=True),
    wrap: float = quantity("--wrap", "rad", "φ of the wanted wheel.", needed=True),
    end_tension: float = quantity("--end-tension", "N", "F_B of the wanted wheel.", needed=True),
    fit: Path | None = Option(None, metavar="FIT.json", help="The quantities that are known."),
    law: str = Option("", help="Without a fit: the law."),
    guess: options.Words = listed("NAME=VALUE", "Its parameters, guessed"),
    rope_diameter: Number = options.diameter("--rope-diameter", "Needed with --law."),
    n_conditions: int = Option(12, "--conditions", min=1, help="Conditions to plan."),
    repeats: int = Option(12, min=1, help="Pulls of each."),
    scatter_within: Number = quantity("--scatter-within", "", 'Between repeats, such as "1.7 %".'),
    scatter_between: Number = quantity("--scatter-between", "", "Between conditions."),
    level: options.Level = 0.95,
    file: Path | None = Option(None, "--out", "-o", metavar="PLAN.csv", help="Write the plan there."),
    force: bool = flag("--force", "Write over a file that is already there."),
) -> Answer:
    """Plan the conditions to test next, within what the rig can do, for one wanted lift force.

    Starts from a stored fit, or from a law with guessed parameters. The search includes the errors that tests share
    (a cell, a wheel, a weight), and says where more conditions help more than repeats. Exits with 4 unless the fit
    supports its law.
    """
    if (fit is None) == (not law):
        raise BadParameter("give a fit, or a law with --guess, and not both", param_hint="--fit")
    options.refuse_file(file, fit, force=force)
    can: dict[str, Any] = {
        "wheel_radius_m": read_levels(wheels, "m", "--wheels"),
        "wrap_angle_rad": read_levels(wraps, "rad", "--wraps"),
        "end_tension_N": read_levels(end_tensions, "N", "--end-tensions"),
    }
    exit_code, rope_m = 0, rope_diameter
    known: dict[str, object] = {}
    scatter = {"within": scatter_within, "between": scatter_between}
    if fit is not None:
        stored = options.read_fit(fit, out)
        rope_m, exit_code = options.rope_radius(stored, rope_diameter), exit_code_of(stored.verdict)
        planned = next_tests.planned_fit(stored, **scatter)
        known = {"fit": fit, "fit_status": stored.status.value}
    else:
        planned = _guessed(law, guess or (), scatter)
    if rope_m is None:
        raise BadParameter("a guessed law does not know its rope", param_hint="--rope-diameter")
    limits = resolution.RigLimits(**can, rope_radius_m=rope_m, largest_force_N=max_force)
    wanted = conditions.one_condition(wheel_radius, rope_m, wrap, end_tension)
    found = next_tests.plan_tests(
        planned, limits, wanted, n_conditions=n_conditions, repeats=repeats, level=level
    )
    if file is not None:
        write_file(file, found.to_csv())
        out.note(f"wrote {file}")
    return Answer(found.to_dict() | known | {"written": file}, parts.plan_sections(found), exit_code)


def _guessed(law: str, guess: Sequence[str], scatter: dict[str, float | None]) -> "next_tests.PlannedLaw":
    """Return a law of which nothing is known but a guess, and how repeats of it will scatter."""
    if scatter["within"] is None:
        text = 'how far do repeats scatter? Write it like "1.7 %"'
        raise BadParameter(text, param_hint="--scatter-within")
    repeats_scatter = resolution.MeanScatter(**{name: value or 0.0 for name, value in scatter.items()})
    at = options.parse_assignments(guess, option="--guess")
    return next_tests.planned_guess(friction_laws.ALL_LAWS[law], at, repeats_scatter)


# Settings that a range is divided into.
_LEVELS = 12


def read_levels(text: str, unit: str, option: str) -> tuple[float, ...]:
    """Return the settings of an option, in SI: a list of quantities, or a range divided into about twelve.

    Wraps are divided evenly, in whole degrees; lengths and forces in even ratios.

    Examples
    --------
    >>> read_levels("15 mm, 40 mm", "m", "--wheels"), len(read_levels("5 N .. 80 N", "N", "--end-tensions"))
    ((0.015, 0.04), 12)
    """
    if ".." not in text:
        parts = [part.strip() for part in text.replace(";", ",").split(",")]
        return tuple(options.read_quantity(part, unit, option) for part in parts if part)
    low, _, high = text.partition("..")
    ends = [options.read_quantity(end.strip(" ."), unit, option) for end in (low, high)]
    if unit != "rad":
        return resolution.levels(ends[0], ends[1], _LEVELS)
    first, last = (float(f"{math.degrees(end):.12g}") for end in ends)
    step = next((s for s in (45.0, 15.0, 5.0) if (_LEVELS - 1) * s <= last - first), 1.0)
    return tuple(math.radians(degrees) for degrees in resolution.levels(first, last, _LEVELS, step=step))


@command(
    'ropefric budget --fit fits/prth-coupled.json --wheel-radius "35 mm" --wrap "400 deg" '
    '--end-tension "60 N" --u-wrap "2 deg" --u-end-tension "0.5 N"',
    order=130,
)
def budget(
    out: Output,
    *,
    fit: options.FitOption,
    wheel_radius: float = quantity("--wheel-radius", "m", "R_w.", needed=True),
    wrap: float = quantity("--wrap", "rad", "φ.", needed=True),
    end_tension: float = quantity("--end-tension", "N", "F_B.", needed=True),
    rope_diameter: float | None = options.ROPE_DIAMETER,
    u_wheel_radius: Number = quantity("--u-wheel-radius", "m", "Standard uncertainty of R_w."),
    u_rope_diameter: Number = options.diameter("--u-rope-diameter", "Of the rope's diameter."),
    u_wrap: Number = quantity("--u-wrap", "rad", 'Of the wrap, such as "2 deg".'),
    u_end_tension: Number = quantity("--u-end-tension", "N", 'Of F_B, such as "0.5 N".'),
    one_pull: bool = flag("--one-pull", "Of one pull with a new rope, not of the mean law."),
    level: float = Option(0.95, help="Coverage probability, between 0 and 1."),
    draws: int = Option(200_000, help="Draws that check the budget."),
    seed: int = Option(0, min=0, help="Of the draws."),
) -> Answer:
    """State the uncertainty of a lift force after the GUM: a budget line by line, checked by draws.

    The wheel is known only so well as the options say. Exits with 4 if the statement cannot be trusted.
    """
    stored = options.read_fit(fit, out)
    at = conditions.one_condition(wheel_radius, options.rope_radius(stored, rope_diameter), wrap, end_tension)
    stds = (u_wheel_radius, u_rope_diameter, u_wrap, u_end_tension)
    uncertainty = {name: std or 0.0 for name, std in zip(conditions.SETTINGS, stds, strict=True)}
    stated = budgets.state_lift(
        stored, at, uncertainty, one_pull=one_pull, level=level, draws=draws, seed=seed
    )
    data = stated.to_dict() | at.row(0) | {"fit": fit, "fit_status": stored.status.value}
    title = f"Uncertainty budget of the {stated.model.name} by {stored.law}"
    return Answer(data, parts.uncertainty_sections(stated, title), exit_code_of(stated.trustworthy))
