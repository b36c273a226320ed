"""`ropefric plan-tests`: the conditions to test next, so that a wanted lift force becomes as certain as it can."""

import math
from pathlib import Path
from typing import Annotated

import typer

from ropefric.cli.options import (
    Answer,
    Command,
    Level,
    exit_code_of,
    parse_assignments,
    quantity_option,
    read_fit,
    read_quantity,
    rope_radius,
)
from ropefric.cli.output import Output
from ropefric.errors import InputError
from ropefric.files.write import refuse_input, refuse_special, write_file

Wheels = Annotated[str, typer.Option(metavar="LENGTHS", help='The wheels there are: "15 mm, 20 mm, 40 mm".')]
Wraps = Annotated[str, typer.Option(metavar="ANGLES", help='A list, or a range: "90 deg .. 1080 deg".')]
EndTensions = Annotated[str, typer.Option(metavar="FORCES", help='A list, or a range: "5 N .. 200 N".')]
MaxForce = Annotated[
    float, quantity_option("--max-force", "N", "FORCE", "The largest F_A the cell takes.", needed=True)
]
WheelRadius = Annotated[
    float, quantity_option("--wheel-radius", "m", "LENGTH", "R_w of the wanted wheel.", needed=True)
]
Wrap = Annotated[float, quantity_option("--wrap", "rad", "ANGLE", "φ of the wanted wheel.", needed=True)]
EndTension = Annotated[
    float, quantity_option("--end-tension", "N", "FORCE", "F_B of the wanted wheel.", needed=True)
]
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
RopeDiameter = Annotated[
    float | None, quantity_option("--rope-diameter", "m", "LENGTH", "Needed with --law.", factor=0.5)
]
NConditions = Annotated[int, typer.Option("--conditions", min=1, help="Conditions to plan.")]
Repeats = Annotated[int, typer.Option(min=1, help="Pulls of each.")]
By = Annotated[
    str,
    typer.Option(
        "--criterion", metavar="v|d", help="The best for the wanted force (v), or the parameters (d)."
    ),
]
Within = Annotated[
    float | None, quantity_option("--scatter-within", "", "PART", 'Between repeats, such as "1.7 %".')
]
Between = Annotated[float | None, quantity_option("--scatter-between", "", "PART", "Between conditions.")]
UForce = Annotated[
    float | None, quantity_option("--u-force", "N", "FORCE", "Of a force, by the measuring chain.")
]
Levels = Annotated[int, typer.Option(min=2, help="Settings a range is divided into.")]
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
    rope_diameter: RopeDiameter = None,
    conditions: NConditions = 12,
    repeats: Repeats = 12,
    criterion: By = "v",
    scatter_within: Within = None,
    scatter_between: Between = None,
    u_force: UForce = None,
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
    from ropefric.fitting.next_tests import MeanScatter, planned_fit, planned_guess  # noqa: PLC0415
    from ropefric.fitting.next_tests import plan_tests as find_plan  # noqa: PLC0415
    from ropefric.fitting.plan_search import RigLimits  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.friction.condition import one_condition  # noqa: PLC0415
    from ropefric.friction.laws import ALL_LAWS  # noqa: PLC0415
    from ropefric.report.parts import plan_sections  # noqa: PLC0415

    exit_code, rope_m = 0, rope_diameter
    known: dict[str, object] = {}
    scatter = {"within": scatter_within, "between": scatter_between, "instrument_N": u_force}
    if fit is not None:
        stored = read_fit(fit, out)
        rope_m, exit_code = rope_radius(stored, rope_diameter), exit_code_of(stored.verdict)
        planned = planned_fit(stored, **scatter)
        known = {"fit": fit, "fit_status": stored.status.value}
    else:
        if scatter_within is None:
            text = 'how far do repeats scatter? Write it like "1.7 %"'
            raise typer.BadParameter(text, param_hint="--scatter-within")
        spread = MeanScatter(**{name: value or 0.0 for name, value in scatter.items()})
        at = parse_assignments(guess or [], option="--guess")
        planned = planned_guess(ALL_LAWS[law], at, spread, fixed=tuple(hold or ()))
    if rope_m is None:
        raise typer.BadParameter("a guessed law does not know its rope", param_hint="--rope-diameter")
    found = find_plan(
        planned,
        RigLimits(
            wheel_radius_m=radii_m,
            wrap_angle_rad=wraps_rad,
            end_tension_N=loads_N,
            rope_radius_m=rope_m,
            largest_force_N=max_force,
        ),
        one_condition(wheel_radius, rope_m, wrap, end_tension),
        n_conditions=conditions,
        repeats=repeats,
        criterion=criterion,  # type: ignore[arg-type]  # the library says what it may be
        level=level,
        starts=starts,
        seed=seed,
    )
    if file is not None:
        if before is not None and before != found.to_csv().encode():
            raise _taken(file)
        write_file(file, found.to_csv())
        out.note(f"wrote {file}")
    return Answer(
        data=found.to_dict() | known | {"written": file},
        show=lambda _: plan_sections(found),
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


COMMAND = Command(
    name="plan-tests",
    run=plan_tests,
    example='ropefric plan-tests --fit fits/prth-coupled.json --wheels "15 mm, 30 mm, 60 mm" '
    '--wraps "90 deg .. 1080 deg" --end-tensions "5 N .. 200 N" --max-force "800 N" --wheel-radius "100 mm" '
    '--wrap "720 deg" --end-tension "80 N"',
    order=150,
)
