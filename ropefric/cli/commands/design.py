"""`ropefric design`: the smallest wrap, wheel or end tension that lifts a load."""

import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import (
    NOT_TRUSTED,
    FitOption,
    exit_code_of,
    read_fit,
    rope_radius,
    show_sections,
)
from ropefric.cli.out_folder import Force, figure_names, folder_option, open_folder
from ropefric.cli.output import Output
from ropefric.cli.quantity_option import read_quantity

if TYPE_CHECKING:
    from ropefric.files.folder import Folder
    from ropefric.fitting.design import Design
    from ropefric.fitting.result import FitResult
    from ropefric.report.section import Section


Lift = Annotated[str, typer.Option("--lift", metavar="FORCE", help='The load, such as "900 N".')]
SolveFor = Annotated[
    str, typer.Option("--solve-for", metavar="wrap|radius|end-tension", help="What is looked for.")
]
WheelRadius = Annotated[str, typer.Option("--wheel-radius", metavar="LENGTH", help="R_w, unless looked for.")]
Wrap = Annotated[str, typer.Option("--wrap", metavar="ANGLE", help="φ, unless looked for.")]
EndTension = Annotated[str, typer.Option("--end-tension", metavar="FORCE", help="F_B, unless looked for.")]
RopeDiameter = Annotated[
    str, typer.Option("--rope-diameter", metavar="LENGTH", help="Of another rope than that of the trials.")
]
Probability = Annotated[
    float, typer.Option(help="Probability, 0.5 or more, that one pull with a new rope lifts the load.")
]
Chart = Annotated[
    Path | None,
    folder_option(
        "--chart", help="Draw the lift force over wheel radius and wrap at this end tension there."
    ),
]
OnAverage = Annotated[bool, typer.Option("--on-average", help="Ask only that the mean law lifts the load.")]

_SHOWN = {"wrap": ("wrap", math.degrees(1.0), "deg"), "radius": ("wheel radius", 1e3, "mm"),
          "end_tension": ("end tension", 1.0, "N")}  # fmt: skip


def design(
    out: Output,
    *,
    fit: FitOption,
    lift: Lift,
    solve_for: SolveFor = "wrap",
    wheel_radius: WheelRadius = "",
    wrap: Wrap = "",
    end_tension: EndTension = "",
    rope_diameter: RopeDiameter = "",
    probability: Probability = 0.95,
    on_average: OnAverage = False,
    chart: Chart = None,
    force: Force = False,
) -> Answer:
    """Find the smallest wrap, wheel radius or end tension that lifts a load with a probability.

    Exits with 4 when there is none, or the law is not supported by its fit.
    """
    R_w = read_quantity(wheel_radius, "m", "--wheel-radius") if wheel_radius else None
    phi = read_quantity(wrap, "rad", "--wrap") if wrap else None
    F_B = read_quantity(end_tension, "N", "--end-tension") if end_tension else None
    load_N = read_quantity(lift, "N", "--lift")
    rope_m = 0.5 * read_quantity(rope_diameter, "m", "--rope-diameter") if rope_diameter else None
    from ropefric.fitting.design import design as find_design  # noqa: PLC0415  (quick start-up)

    stored = read_fit(fit, out)
    with ExitStack() as stack:
        if chart is not None:  # before the work
            target = stack.enter_context(
                open_folder(
                    chart, family="chart", names=figure_names("design_chart"), inputs=[fit], force=force
                )
            )
        found = find_design(
            stored,
            lift_N=load_N,
            rope_radius_m=rope_radius(stored, rope_m),
            solve_for=solve_for.replace("-", "_"),  # type: ignore[arg-type]  # the library says what it may be
            probability=None if on_average else probability,
            wheel_radius_m=R_w,
            wrap_angle_rad=phi,
            end_tension_N=F_B,
        )
        reached = bool(found.reached[0])
        files = _write_chart(stored, found, target, probability) if chart is not None and reached else ()
    for path in files:
        out.note(f"wrote {path}")
    return Answer(
        data=found.to_dict()
        | {"fit": fit, "law": stored.law, "fit_status": stored.status.value, "files": list(files)},
        show=lambda console: show_sections([_section(found)], console),
        exit_code=exit_code_of(stored.verdict) if reached else NOT_TRUSTED,
    )


def _write_chart(fit: "FitResult", found: "Design", folder: "Folder", probability: float) -> tuple[Path, ...]:
    """Draw the wheels and wraps that were tested, and some way beyond, at the design's end tension."""
    import numpy as np  # noqa: PLC0415  (these: quick start-up)

    from ropefric.fitting.design import design_chart  # noqa: PLC0415
    from ropefric.plotting.design_chart import draw_design_chart  # noqa: PLC0415
    from ropefric.plotting.save import save_figure  # noqa: PLC0415

    (small_m, large_m), (_, most_rad) = fit.validity["wheel_radius_m"], fit.validity["wrap_angle_rad"]
    radii_m = np.unique(np.append(np.linspace(small_m, large_m, 4), found.wheel_radius_m[0]))
    farthest_rad = 1.2 * max(most_rad, float(found.wrap_angle_rad[0]))
    chart = design_chart(
        fit,
        radii_m,
        np.linspace(farthest_rad / 80, farthest_rad, 80),
        float(found.end_tension_N[0]),
        rope_radius_m=float(found.rope_radius_m[0]),
        probability=probability,
    )
    drawn = draw_design_chart(chart, required_N=float(found.required_N[0]))
    files = save_figure(drawn, folder, "design_chart")
    folder.publish("chart")
    return files


def _section(found: "Design") -> "Section":
    from ropefric.report.section import Section  # noqa: PLC0415

    title = f"A design for {found.required_N[0]:.4g} N"
    if not found.reached[0]:
        return Section(title=title, lines=(found.explain(),))
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
    return Section(title=title, lines=tuple(lines), notes=notes)


COMMAND = Command(
    name="design",
    run=design,
    example='ropefric design --fit fits/prth-coupled.json --lift "900 N" --solve-for wrap --wheel-radius "40 mm" '
    '--end-tension "80 N"',
    order=140,
)
