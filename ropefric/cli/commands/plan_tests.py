"""`ropefric plan-tests`: the conditions to test next, so that a wanted lift force becomes as certain as it can."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.assignments import parse_assignments
from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import exit_code_of, read_fit, rope_radius, show_sections
from ropefric.cli.output import Output
from ropefric.cli.quantity_option import read_quantity
from ropefric.errors import InputError
from ropefric.files.write import refuse_input, refuse_special, write_file

if TYPE_CHECKING:
    from ropefric.fitting.next_tests import PlannedLaw
    from ropefric.fitting.plan_search import Criterion


Wheels = Annotated[str, typer.Option(metavar="LENGTHS", help='The wheels there are: "15 mm, 20 mm, 40 mm".')]
Wraps = Annotated[str, typer.Option(metavar="ANGLES", help='A list, or a range: "90 deg .. 1080 deg".')]
EndTensions = Annotated[str, typer.Option(metavar="FORCES", help='A list, or a range: "5 N .. 200 N".')]
MaxForce = Annotated[
    str, typer.Option("--max-force", metavar="FORCE", help="The largest F_A the cell takes.")
]
WheelRadius = Annotated[
    str, typer.Option("--wheel-radius", metavar="LENGTH", help="R_w of the wanted wheel.")
]
Wrap = Annotated[str, typer.Option("--wrap", metavar="ANGLE", help="φ of the wanted wheel.")]
EndTension = Annotated[str, typer.Option("--end-tension", metavar="FORCE", help="F_B of the wanted wheel.")]
Fit = Annotated[Path | None, typer.Option("--fit", metavar="FIT.json", help="What is known already.")]
Law = Annotated[str, typer.Option(help="Without a fit: the law.")]
Guess = Annotated[
    list[str] | None,
    typer.Option("--guess", metavar="NAME=VALUE", help="Its parameters, guessed; repeatable."),
]
Hold = Annotated[
    list[str] | None,
    typer.Option("--hold", metavar="NAME", help="A guessed parameter taken as known; repeatable."),
]
RopeDiameter = Annotated[str, typer.Option("--rope-diameter", metavar="LENGTH", help="Needed with --law.")]
NConditions = Annotated[int, typer.Option("--conditions", min=1, help="Conditions to plan.")]
Repeats = Annotated[int, typer.Option(min=1, help="Pulls of each.")]
By = Annotated[
    str,
    typer.Option(
        "--criterion", metavar="v|d", help="The best for the wanted force (v), or the parameters (d)."
    ),
]
Within = Annotated[
    str, typer.Option("--scatter-within", metavar="PART", help='Between repeats, such as "1.7 %".')
]
Between = Annotated[str, typer.Option("--scatter-between", metavar="PART", help="Between conditions.")]
UForce = Annotated[
    str, typer.Option("--u-force", metavar="FORCE", help="Of a force, by the measuring chain.")
]
Levels = Annotated[int, typer.Option(min=2, help="Settings a range is divided into.")]
Level = Annotated[float, typer.Option(help="Level of the intervals, between 0 and 1.")]
Starts = Annotated[int, typer.Option(min=1, help="Starts of the search.")]
Seed = Annotated[int, typer.Option(min=0, help="Of those drawn at random.")]
OutFile = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="PLAN.csv", help="Write the plan there.")
]
Force = Annotated[
    bool, typer.Option("--force", help="Write over a file that holds anything else than this plan.")
]


def plan_tests(
    out: Output,
    *,
    wheels: Wheels,
    wraps: Wraps,
    end_tensions: EndTensions,
    max_force: MaxForce,
    wheel_radius: WheelRadius,
    wrap: Wrap,
    end_tension: EndTension,
    fit: Fit = None,
    law: Law = "",
    guess: Guess = None,
    hold: Hold = None,
    rope_diameter: RopeDiameter = "",
    conditions: NConditions = 12,
    repeats: Repeats = 12,
    criterion: By = "v",
    scatter_within: Within = "",
    scatter_between: Between = "",
    u_force: UForce = "",
    levels: Levels = 12,
    level: Level = 0.95,
    starts: Starts = 10,
    seed: Seed = 0,
    file: OutFile = None,
    force: Force = False,
) -> Answer:
    """Plan the conditions to test next, within what the rig can do, for one wanted lift force.

    Starts from a stored fit, or from a law with guessed parameters, and shows the plan's worth beside that of an
    equal number of tests that vary one factor at a time. Exits with 4 unless the fit supports its law.
    """
    if (fit is None) == (not law):
        raise typer.BadParameter("give a fit, or a law with --guess, and not both", param_hint="--fit")
    before = None
    if file is not None:  # before the work, as far as it can be known
        refuse_special(file)
        refuse_input(file, fit)
        before = file.read_bytes() if file.is_file() and not force else None
        if before is not None and not before.startswith(b"condition,wheel_radius_mm"):
            raise _taken(file)
    radii_m = read_levels(wheels, "m", "--wheels", levels)
    wraps_rad = read_levels(wraps, "rad", "--wraps", levels)
    loads_N = read_levels(end_tensions, "N", "--end-tensions", levels)
    largest_N = read_quantity(max_force, "N", "--max-force")
    R_w = read_quantity(wheel_radius, "m", "--wheel-radius")
    phi = read_quantity(wrap, "rad", "--wrap")
    F_B = read_quantity(end_tension, "N", "--end-tension")
    rope_m = 0.5 * read_quantity(rope_diameter, "m", "--rope-diameter") if rope_diameter else None
    within = read_quantity(scatter_within, "", "--scatter-within") if scatter_within else None
    between = read_quantity(scatter_between, "", "--scatter-between") if scatter_between else None
    u_N = read_quantity(u_force, "N", "--u-force") if u_force else None
    how: Criterion = criterion  # type: ignore[assignment]  # the library says what it may be
    from ropefric.fitting.next_tests import plan_tests as find_plan  # noqa: PLC0415
    from ropefric.fitting.next_tests import planned_fit  # noqa: PLC0415
    from ropefric.fitting.plan_search import RigLimits  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.report.lab_plan import plan_sections  # noqa: PLC0415

    exit_code = 0
    known: dict[str, object] = {}
    if fit is not None:
        stored = read_fit(fit, out)
        rope_m, exit_code = rope_radius(stored, rope_m), exit_code_of(stored.verdict)
        planned = planned_fit(stored, within=within, between=between, instrument_N=u_N)
        known = {"fit": fit, "fit_status": stored.status.value}
    else:
        planned = _guessed(
            law, guess or [], tuple(hold or ()), within=within, between=between, instrument_N=u_N
        )
    if rope_m is None:
        raise typer.BadParameter("a guessed law does not know its rope", param_hint="--rope-diameter")
    found = find_plan(
        planned,
        RigLimits(
            wheel_radius_m=radii_m,
            wrap_angle_rad=wraps_rad,
            end_tension_N=loads_N,
            rope_radius_m=rope_m,
            largest_force_N=largest_N,
        ),
        one_condition(R_w, rope_m, phi, F_B),
        n_conditions=conditions,
        repeats=repeats,
        criterion=how,
        level=level,
        starts=starts,
        seed=seed,
    )
    if file is not None:
        if before is not None and before != found.to_csv().encode():
            raise _taken(file)
        write_file(file, found.to_csv())
        out.note(f"wrote {file}")
    sections = plan_sections(found)
    return Answer(
        data=found.to_dict() | known | {"written": file},
        show=lambda console: show_sections(sections, console),
        exit_code=exit_code,
    )


def _taken(path: Path) -> InputError:
    # A lab writes into its plans, and nothing tells such a one from one as it was written.
    return InputError(
        "the file is there already, with other content than this plan",
        code="RF150",
        path=path.as_posix(),
        fix="choose another name, or replace it with --force",
    )


def read_levels(text: str, unit: str, option: str, n: int) -> tuple[float, ...]:
    """Return the settings of an option, in SI: a list of quantities, or a range divided into about n.

    Wraps are divided evenly, in whole degrees; lengths and forces in even ratios.

    Examples
    --------
    >>> read_levels("15 mm, 40 mm", "m", "--wheels", 12), read_levels("5 N .. 80 N", "N", "--end-tensions", 3)
    ((0.015, 0.04), (5.0, 20.0, 80.0))
    """
    if ".." not in text:
        parts = [part.strip() for part in text.replace(";", ",").split(",")]
        return tuple(read_quantity(part, unit, option) for part in parts if part)
    low, _, high = text.partition("..")
    ends = [read_quantity(end.strip(" ."), unit, option) for end in (low, high)]
    from ropefric.fitting.plan_search import geometric_levels, linear_levels  # noqa: PLC0415  (quick start-up)

    if unit != "rad":
        return geometric_levels(ends[0], ends[1], n)
    first, last = (float(f"{math.degrees(end):.12g}") for end in ends)
    step = next((s for s in (45.0, 15.0, 5.0) if (n - 1) * s <= last - first), 1.0)
    return tuple(math.radians(degrees) for degrees in linear_levels(first, last, n, step=step))


def _guessed(name: str, guess: list[str], hold: tuple[str, ...], **scatter: float | None) -> "PlannedLaw":
    """Return a law at guessed parameters; `scatter` holds the fields of `MeanScatter`, None where not given."""
    from ropefric.fitting.next_tests import MeanScatter, planned_guess  # noqa: PLC0415  (quick start-up)
    from ropefric.friction.laws import ALL_LAWS  # noqa: PLC0415

    if scatter["within"] is None:
        raise typer.BadParameter(
            'how far do repeats scatter? Write it like "1.7 %"', param_hint="--scatter-within"
        )
    known = MeanScatter(**{name: value or 0.0 for name, value in scatter.items()})
    return planned_guess(ALL_LAWS[name], parse_assignments(guess, option="--guess"), known, fixed=hold)


COMMAND = Command(
    name="plan-tests",
    run=plan_tests,
    example='ropefric plan-tests --fit fits/prth-coupled.json --wheels "15 mm, 30 mm, 60 mm" '
    '--wraps "90 deg .. 1080 deg" --end-tensions "5 N .. 200 N" --max-force "800 N" --wheel-radius "100 mm" '
    '--wrap "720 deg" --end-tension "80 N"',
    order=150,
)
