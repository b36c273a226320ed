"""`ropefric plan-tests`: the conditions to test next, so that a wanted lift force becomes as certain as it can."""

import math
from pathlib import Path

from typer import BadParameter, Option

from ropefric.cli.options import (
    Answer,
    Command,
    Level,
    exit_code_of,
    parse_assignments,
    quantity,
    read_fit,
    read_quantity,
    rope_radius,
)
from ropefric.cli.output import Output
from ropefric.errors import InputError
from ropefric.files.write import refuse_input, refuse_special, write_file


def plan_tests(
    out: Output,
    *,
    wheels: str = Option(..., metavar="LENGTHS", help='The wheels there are: "15 mm, 20 mm, 40 mm".'),
    wraps: str = Option(..., metavar="ANGLES", help='A list, or a range: "90 deg .. 1080 deg".'),
    end_tensions: str = Option(..., metavar="FORCES", help='A list, or a range: "5 N .. 200 N".'),
    max_force: float = quantity(..., "--max-force", "N", "FORCE", "The largest F_A the cell takes."),
    wheel_radius: float = quantity(..., "--wheel-radius", "m", "LENGTH", "R_w of the wanted wheel."),
    wrap: float = quantity(..., "--wrap", "rad", "ANGLE", "φ of the wanted wheel."),
    end_tension: float = quantity(..., "--end-tension", "N", "FORCE", "F_B of the wanted wheel."),
    fit: Path | None = Option(None, metavar="FIT.json", help="What is known already."),
    law: str = Option("", help="Without a fit: the law."),
    guess: list[str] | None = Option(None, metavar="NAME=VALUE", help="Its parameters, guessed; repeatable."),
    hold: list[str] | None = Option(
        None, metavar="NAME", help="A guessed parameter taken as known; repeatable."
    ),
    rope_diameter: float | None = quantity(
        None, "--rope-diameter", "m", "LENGTH", "Needed with --law.", factor=0.5
    ),
    conditions: int = Option(12, min=1, help="Conditions to plan."),
    repeats: int = Option(12, min=1, help="Pulls of each."),
    criterion: str = Option(
        "v", metavar="v|d", help="The best for the wanted force (v), or the parameters (d)."
    ),
    scatter_within: float | None = quantity(
        None, "--scatter-within", "", "PART", 'Between repeats, such as "1.7 %".'
    ),
    scatter_between: float | None = quantity(None, "--scatter-between", "", "PART", "Between conditions."),
    u_force: float | None = quantity(None, "--u-force", "N", "FORCE", "Of a force, by the measuring chain."),
    levels: int = Option(12, min=2, help="Settings a range is divided into."),
    level: Level = 0.95,
    starts: int = Option(10, min=1, help="Starts of the search."),
    seed: int = Option(0, min=0, help="Of those drawn at random."),
    file: Path | None = Option(None, "--out", "-o", metavar="PLAN.csv", help="Write the plan there."),
    force: bool = Option(False, "--force", help="Write over a file that holds anything else than this plan."),
) -> Answer:
    """Plan the conditions to test next, within what the rig can do, for one wanted lift force.

    Starts from a stored fit, or from a law with guessed parameters, and shows the plan's worth beside that of an
    equal number of tests that vary one factor at a time. Exits with 4 unless the fit supports its law.
    """
    if (fit is None) == (not law):
        raise BadParameter("give a fit, or a law with --guess, and not both", param_hint="--fit")
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
            raise BadParameter(text, param_hint="--scatter-within")
        repeats_scatter = MeanScatter(**{name: value or 0.0 for name, value in scatter.items()})
        at = parse_assignments(guess or [], option="--guess")
        planned = planned_guess(ALL_LAWS[law], at, repeats_scatter, fixed=tuple(hold or ()))
    if rope_m is None:
        raise BadParameter("a guessed law does not know its rope", param_hint="--rope-diameter")
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
    return Answer(found.to_dict() | known | {"written": file}, plan_sections(found), exit_code)


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
    "plan-tests",
    plan_tests,
    'ropefric plan-tests --fit fits/prth-coupled.json --wheels "15 mm, 30 mm, 60 mm" '
    '--wraps "90 deg .. 1080 deg" --end-tensions "5 N .. 200 N" --max-force "800 N" --wheel-radius "100 mm" '
    '--wrap "720 deg" --end-tension "80 N"',
    order=150,
)
