"""The commands of scenes: the answer to one or to a grid of them, how it is come by, and what accuracy costs."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from math import prod
from pathlib import Path
from typing import Any

from typer import Argument, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, Force, Words, command, exit_code_of, flag, option, out_folder
from ropefric.cli.output import Output, Progress, json_text
from ropefric.errors import InputError

with on_first_use():
    from ropefric import executors
    from ropefric.accuracy import measure
    from ropefric.accuracy import studies as all_studies
    from ropefric.files import folder as folders
    from ropefric.report import cost_page, parts
    from ropefric.scenes import draws as drawing
    from ropefric.scenes import explain as explaining
    from ropefric.scenes import kinds
    from ropefric.scenes import scene as scenes
    from ropefric.scenes import solve as solving
    from ropefric.scenes import sweep as sweeping


class TableFormat(StrEnum):
    """How the table of a sweep or of draws is written."""

    CSV = "csv"
    PARQUET = "parquet"


_LISTED_POINTS = 1000
_TOLD = ("failed", "first_failure", "error_bound", "accuracy", "failures", "extrapolated_at", "warnings")


@command("ropefric solve data/scenes/hoist.toml --sweep wheel.wrap=90deg:1440deg:50 --out out/", order=160)
def solve(
    out: Output,
    scene: options.SceneArgument,
    *,
    sweep: Words = option(
        "KEY=START:STOP:COUNT",
        "Solve over a range, or KEY=A,B,C over a list, of any number in the scene; several make a grid.",
        "--sweep",
    ),
    draws: int = option(
        "N",
        "Solve for this many random draws of the fit's parameters and of the values with [tolerances].",
        default=0,
    ),
    seed: int = Option(0, min=0, help="Of the draws."),
    level: float = Option(
        0.95, help="Coverage of the intervals, between 0 and 1; of draws, between their outer quantiles."
    ),
    folder: Path | None = out_folder("Write the answer (and the table of a sweep or of draws) there."),
    plot: str = Option("", help="Which number of a sweep the figure shows; by default the first."),
    table: TableFormat = option(
        "",
        "How the table of a sweep or of draws is written; Parquet needs pyarrow.",
        "--table",
        default=TableFormat.CSV,
    ),
    cluster: options.Cluster = "",
    force: Force = False,
) -> Answer:
    """Solve a scene: a hoist, press, saw, traction sheave, belt drive or line, with the effects it calls for.

    Exits with 4 when the friction behind the answer is not supported, when the error may be larger than the accuracy
    wanted, and when the machine does not do what it is for: a hoist that does not lift its payload, a press that
    slips. A traction sheave is checked by one clause of EN 81-50, which is no certificate. A sweep says at how many
    points that is so, draws in which share of them, and both exit with 4 for the error alone.
    """
    if cluster and not (sweep or draws):
        fix = "add --sweep or --draws, or leave it out"
        raise InputError("one scene is no work to share", key="--cluster", fix=fix)
    if sweep and draws:
        raise InputError("a sweep is not drawn", key="--draws", fix="use either --sweep or --draws")
    loaded = scenes.load_scene(scene)
    family = "sweep" if sweep else "draws" if draws else "scene"
    fit = loaded.document.table("friction").get("fit")
    inputs = (scene, loaded.folder / fit, Path(fit)) if isinstance(fit, str) else (scene,)
    # Before the work, so that a folder that cannot be used costs nothing.
    with options.open_folder(
        folder, family=family, names=_names_of(family), inputs=inputs, force=force
    ) as target:
        if sweep:
            return _swept(out, loaded, sweep, target, f"sweep.{table}", cluster, plot=plot)
        if draws:
            return _drawn(out, loaded, draws, target, f"draws.{table}", cluster, seed=seed, level=level)
        solution = solving.solve_scene(loaded, level=level)
        tree = solution.to_dict()
        files = [] if target is None else _write(out, solution, tree, target)
        shown = parts.solution_sections(solution, tree)
        return Answer(tree | {"files": files}, shown, exit_code_of(solution.stands))


def _names_of(family: str) -> tuple[str, ...]:
    """Return what may be written: of a scene that of any kind, since a folder may hold the answer to another one."""
    if family == "sweep":
        return ("sweep.csv", "sweep.parquet", *options.figure_names("sweep_figure"))
    if family == "draws":
        return ("draws.csv", "draws.parquet", "draws.json")
    histories = [name for kind in kinds.KINDS.values() for name in kind.histories]
    stems = [stem for kind in kinds.KINDS.values() for stem in kind.figures]
    return ("answer.json", *histories, *options.figure_names(*stems))


@contextmanager
def _at_work(
    out: Output, folder: "folders.Folder | None", name: str, cluster: str
) -> Iterator[dict[str, Any]]:
    """Give what a sweep and draws have in common: progress, and who does the work."""
    if folder is not None:
        sweeping.check_table(name)
    with Progress(out, "solve") as progress, executors.cluster(cluster) as executor:
        yield {"progress": progress.update, "executor": executor}


def _swept(  # noqa: PLR0917  (as the command has them)
    out: Output,
    scene: "scenes.Scene",
    texts: Sequence[str],
    folder: "folders.Folder | None",
    name: str,
    cluster: str,
    *,
    plot: str,
) -> Answer:
    axes = tuple(sweeping.parse_axis(scene, text) for text in texts)
    with _at_work(out, folder, name, cluster) as how:
        found = sweeping.sweep_scene(scene, axes, **how)
    files = [] if folder is None else _publish_sweep(out, found, folder, name, plot)
    shown = parts.sweep_sections(found)
    return Answer(_tree(found) | {"files": files}, shown, exit_code_of(found.keeps_accuracy))


def _drawn(  # noqa: PLR0917  (as the command has them)
    out: Output,
    scene: "scenes.Scene",
    count: int,
    folder: "folders.Folder | None",
    name: str,
    cluster: str,
    **how: Any,
) -> Answer:
    with _at_work(out, folder, name, cluster) as of_work:
        found = drawing.draw_scene(scene, count, **how, **of_work)
    data: dict[str, Any] = found.to_dict()
    files: Sequence[Path] = ()
    if folder is not None:
        sweeping.write_table(folder, name, found.table)
        written = [folder.path / name, *folder.write({"draws.json": json_text(data)})]
        files = options.publish(out, folder, "answer", written)
    shown = parts.draws_sections(found, scene.kind.words)
    return Answer(data | {"files": files}, shown, exit_code_of(found.stands))


def _write(
    out: Output, solution: "solving.Solution", tree: dict[str, Any], folder: "folders.Folder"
) -> Sequence[Path]:
    from ropefric.plotting import figure, machines  # noqa: PLC0415  (its package loads matplotlib)

    files = [*folder.write({"answer.json": json_text(tree)})]
    for stem, drawn in machines.scene_figures(solution):
        files += figure.save_figure(drawn, folder, stem)
    for name, history in solution.scene.kind.histories.items():
        columns = history(solution.answer)
        if columns is not None:
            files += folder.write({name: sweeping.columns_text(columns)})
    return options.publish(out, folder, "answer", files)


def _publish_sweep(
    out: Output, found: "sweeping.Sweep", folder: "folders.Folder", name: str, plot: str
) -> Sequence[Path]:
    from ropefric.plotting import figure, machines  # noqa: PLC0415  (its package loads matplotlib)

    sweeping.write_table(folder, name, found.table)
    files = [folder.path / name]
    if len(found.axes) <= 2:
        files += figure.save_figure(machines.draw_sweep(found, quantity=plot), folder, "sweep_figure")
    return options.publish(out, folder, "answer", files)


def _tree(found: "sweeping.Sweep") -> dict[str, Any]:
    points = prod(found.shape)
    # A million numbers on a terminal serve nobody; the CSV of --out has them.
    listed = points <= _LISTED_POINTS
    axes = [(axis.key, axis.unit, (axis.values / axis.factor).tolist()) for axis in found.axes]
    return {
        "axes": [dict(zip(("key", "unit", "values"), one, strict=True)) for one in axes],
        "points": points,
        "columns": {name: values if listed else None for name, values in found.columns.items()},
        "effects": {"simulated": found.simulated, "left_out_at": found.left_out},
        **{key: getattr(found, key) for key in _TOLD},
    }


@command("ropefric explain data/scenes/hoist.toml --measure --out out/", order=170)
def explain(
    out: Output,
    scene: options.SceneArgument,
    *,
    measure_: bool = flag("--measure", "Also read the clock: what time each effect takes."),
    folder: Path | None = out_folder("Write the explanation and its figure into this folder."),
    force: Force = False,
) -> Answer:
    """Explain how a scene is solved: the effects that are simulated, those that are not, the method, and why."""
    names = ("explanation.json", *options.figure_names("effects"))
    with options.open_folder(folder, family="explain", names=names, inputs=(scene,), force=force) as target:
        found = explaining.explain_scene(scenes.load_scene(scene), measure=measure_)
        tree, files = found.to_dict(), list[Path]()
        if target is not None:
            from ropefric.plotting import figure, machines  # noqa: PLC0415  (its package loads matplotlib)

            files += target.write({"explanation.json": json_text(tree)})
            files += figure.save_figure(machines.draw_explanation(found), target, "effects")
            options.publish(out, target, "explanation", files)
        return Answer(tree | {"files": files}, parts.explanation_sections(found))


@command("ropefric cost integral --out cost --quick", order=180)
def cost(
    out: Output,
    studies: Words = Argument(None, metavar="[STUDY …]", help="Studies to measure, all by default."),
    *,
    folder: Path = out_folder("Where figures, tables and page are written.", Path("cost")),
    quick: bool = flag("--quick", "Some settings only, and little time for each."),
    force: Force = False,
) -> Answer:
    """Measure what accuracy costs in time on this machine.

    Of the lift-force integral, break-away peaks and their pickers, intervals, press, blade and scenes.

    For every study it writes NAME.csv, NAME.png (time over error, the best settings marked), and for all of them
    cost.html with the cheapest method for each accuracy from 1e-2 to 1e-12.
    """
    chosen = [all_studies.STUDIES[name] for name in dict.fromkeys(studies or all_studies.STUDIES)]
    pairs = [f"{study.name}.{ending}" for study in chosen for ending in ("png", "csv")]
    # Before the work, so that a folder that cannot be used costs nothing.
    names = ["cost.html", *pairs]
    with options.open_folder(folder, family="cost", names=names, force=force) as target:
        machine = measure.this_machine()
        out.note(f"measuring on {machine.line}")
        with Progress(out, "cost") as progress:
            results = measure.measure_studies(chosen, quick=quick, progress=progress.update)
        written = cost_page.write_cost(results, machine, target)
    studied = [result.to_dict() for result in results]
    data = {"machine": machine._asdict(), "quick": quick, "studies": studied, "written": list(written)}
    said = options.written_to(folder, "cost.html, …")
    return Answer(data, [*cost_page.cost_sections(results, machine), said])
