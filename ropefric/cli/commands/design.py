"""`ropefric design`: the smallest wrap, wheel or end tension that lifts a load."""

import math
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from typer import Option

from ropefric.cli.options import (
    NOT_TRUSTED,
    ROPE_DIAMETER,
    Answer,
    Command,
    FitOption,
    Force,
    exit_code_of,
    figure_names,
    folder_option,
    open_folder,
    quantity,
    read_fit,
    rope_radius,
)
from ropefric.cli.output import Output

if TYPE_CHECKING:
    from ropefric.files.folder import Folder
    from ropefric.fitting.design import Design
    from ropefric.fitting.result import FitResult
    from ropefric.report.section import Section


_SHOWN = {"wrap": ("wrap", math.degrees(1.0), "deg"), "radius": ("wheel radius", 1e3, "mm"),
          "end_tension": ("end tension", 1.0, "N")}  # fmt: skip


def design(
    out: Output,
    *,
    fit: FitOption,
    lift: float = quantity(..., "--lift", "N", "FORCE", 'The load, such as "900 N".'),
    solve_for: str = Option("wrap", metavar="wrap|radius|end-tension", help="What is looked for."),
    wheel_radius: float | None = quantity(None, "--wheel-radius", "m", "LENGTH", "R_w, unless looked for."),
    wrap: float | None = quantity(None, "--wrap", "rad", "ANGLE", "φ, unless looked for."),
    end_tension: float | None = quantity(None, "--end-tension", "N", "FORCE", "F_B, unless looked for."),
    rope_diameter: float | None = ROPE_DIAMETER,
    probability: float = Option(
        0.95, help="Probability, 0.5 or more, that one pull with a new rope lifts the load."
    ),
    on_average: bool = Option(False, "--on-average", help="Ask only that the mean law lifts the load."),
    chart: Path | None = folder_option(
        None, "--chart", help="Draw the lift force over wheel radius and wrap at this end tension there."
    ),
    force: Force = False,
) -> Answer:
    """Find the smallest wrap, wheel radius or end tension that lifts a load with a probability.

    Exits with 4 when there is none, or the law is not supported by its fit.
    """
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
            lift_N=lift,
            rope_radius_m=rope_radius(stored, rope_diameter),
            solve_for=solve_for.replace("-", "_"),  # type: ignore[arg-type]  # the library says what it may be
            probability=None if on_average else probability,
            wheel_radius_m=wheel_radius,
            wrap_angle_rad=wrap,
            end_tension_N=end_tension,
        )
        reached = bool(found.reached[0])
        files = _write_chart(stored, found, target, probability) if chart is not None and reached else ()
    for path in files:
        out.note(f"wrote {path}")
    return Answer(
        found.to_dict()
        | {"fit": fit, "law": stored.law, "fit_status": stored.status.value, "files": list(files)},
        [_section(found)],
        exit_code_of(stored.verdict) if reached else NOT_TRUSTED,
    )


def _write_chart(fit: "FitResult", found: "Design", folder: "Folder", probability: float) -> tuple[Path, ...]:
    """Draw the wheels and wraps that were tested, and some way beyond, at the design's end tension."""
    import numpy as np  # noqa: PLC0415  (these: quick start-up)

    from ropefric.fitting.design import design_chart  # noqa: PLC0415
    from ropefric.plotting.design_chart import draw_design_chart  # noqa: PLC0415
    from ropefric.plotting.figure import save_figure  # noqa: PLC0415

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
    "design",
    design,
    'ropefric design --fit fits/prth-coupled.json --lift "900 N" --solve-for wrap --wheel-radius "40 mm" '
    '--end-tension "80 N"',
    order=140,
)
