"""The commands of scenes: the answer to one or to a grid of them, and how it is come by."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typer import Option

from ropefric.cli.options import (
    NOT_TRUSTED,
    Answer,
    Force,
    SceneArgument,
    command,
    figure_names,
    folder_option,
    open_folder,
    publish,
)
from ropefric.cli.output import Output, Progress, json_text

if TYPE_CHECKING:
    from ropefric.files.folder import Folder
    from ropefric.scenes.scene import Scene
    from ropefric.scenes.solve import Solution
    from ropefric.scenes.sweep import Sweep


_LISTED_POINTS = 1000
_TOLD = ("failed", "first_failure", "error_bound", "accuracy", "failures", "warnings")
_SWEPT = ("sweep.csv", *figure_names("sweep_figure"))


@command("ropefric solve data/scenes/hoist.toml --sweep wheel.wrap=90deg:1440deg:50 --out out/", order=160)
def solve(
    out: Output,
    scene: SceneArgument,
    *,
    sweep: list[str] | None = Option(
        None,
        "--sweep",
        metavar="KEY=START:STOP:COUNT",
        help="Solve over a range, or KEY=A,B,C over a list, of any number in the scene; several make a grid.",
    ),
    level: float = Option(0.95, help="Coverage of the intervals, between 0 and 1; a sweep has none."),
    folder: Path | None = folder_option(
        None, "--out", "-o", help="Write the answer (and a sweep's CSV and figure) there."
    ),
    plot: str = Option("", help="Which number of a sweep the figure shows; by default the first."),
    force: Force = False,
) -> Answer:
    """Solve a scene: a hoist, belt press, band saw, traction sheave or belt drive, with the effects it calls for.

    Exits with 4 when the friction behind the answer is not supported, when the error may be larger than the accuracy
    wanted, and when the machine does not do what it is for: a hoist that does not lift its payload, a press that
    slips. A traction sheave is checked by one clause of EN 81-50, which is no certificate. A sweep says at how many
    points that is so, and exits with 4 for the error alone.
    """
    from ropefric.scenes.scene import load_scene  # noqa: PLC0415  (quick start-up)

    loaded = load_scene(scene)
    family, names = ("sweep", _SWEPT) if sweep else ("scene", _solved_names())
    # Before the work, so that a folder that cannot be used costs nothing.
    with open_folder(
        folder, family=family, names=names, inputs=(scene, *_fits(loaded)), force=force
    ) as target:
        return _swept(out, loaded, sweep, target, plot) if sweep else _solved(out, loaded, level, target)


def _solved_names() -> tuple[str, ...]:
    """Return what a solved scene of any kind may write: a folder may hold the answer to another one."""
    from ropefric.scenes.kinds import KINDS  # noqa: PLC0415  (quick start-up)

    kinds = KINDS.values()
    histories = [name for kind in kinds for name in kind.histories]
    return ("answer.json", *histories, *figure_names(*(stem for kind in kinds for stem in kind.figures)))


def _fits(scene: "Scene") -> list[Path]:
    """Return where the fit may be that a scene names."""
    friction = scene.document.data.get("friction")
    name = friction.get("fit") if isinstance(friction, dict) else None
    return [scene.folder / name, Path(name)] if isinstance(name, str) else []


def _solved(out: Output, scene: "Scene", level: float, folder: "Folder | None") -> Answer:
    from ropefric.report.scene import solution_sections  # noqa: PLC0415  (quick start-up)
    from ropefric.scenes.solve import solve_scene  # noqa: PLC0415

    solution = solve_scene(scene, level=level)
    tree = solution.to_dict()
    files = [] if folder is None else _write(out, solution, tree, folder)
    return Answer(
        tree | {"files": files},
        solution_sections(solution, tree),
        0 if solution.stands else NOT_TRUSTED,
    )


def _write(out: Output, solution: "Solution", tree: dict[str, Any], folder: "Folder") -> Sequence[Path]:
    from ropefric.plotting.chart import scene_figures  # noqa: PLC0415
    from ropefric.plotting.figure import save_figure  # noqa: PLC0415
    from ropefric.scenes.sweep import columns_text  # noqa: PLC0415

    files = [*folder.write({"answer.json": json_text(tree)})]
    for stem, figure in scene_figures(solution):
        files += save_figure(figure, folder, stem)
    for name, history in solution.scene.kind.histories.items():
        columns = history(solution.answer)
        if columns is not None:
            files += folder.write({name: columns_text(columns)})
    return publish(out, folder, "answer", files)


def _swept(out: Output, scene: "Scene", asked: list[str], folder: "Folder | None", plot: str) -> Answer:
    from ropefric.report.scene import sweep_sections  # noqa: PLC0415
    from ropefric.scenes.sweep import parse_axis, sweep_scene  # noqa: PLC0415

    axes = tuple(parse_axis(scene, text) for text in asked)
    with Progress(out, "solve") as progress:
        found = sweep_scene(scene, axes, progress=progress.update)
    files = [] if folder is None else _write_sweep(out, found, folder, plot)
    return Answer(
        _tree(found) | {"files": files},
        sweep_sections(found),
        0 if found.keeps_accuracy else NOT_TRUSTED,
    )


def _write_sweep(out: Output, found: "Sweep", folder: "Folder", plot: str) -> Sequence[Path]:
    from ropefric.scenes.sweep import write_sweep  # noqa: PLC0415

    files = [write_sweep(found, folder, "sweep.csv")]
    if len(found.axes) <= 2:
        from ropefric.plotting.chart import draw_sweep  # noqa: PLC0415
        from ropefric.plotting.figure import save_figure  # noqa: PLC0415

        files += save_figure(draw_sweep(found, quantity=plot), folder, "sweep_figure")
    return publish(out, folder, "answer", files)


def _tree(found: "Sweep") -> dict[str, Any]:
    axes = [
        {"key": axis.key, "unit": axis.unit, "values": [float(value / axis.factor) for value in axis.values]}
        for axis in found.axes
    ]
    points = next(iter(found.columns.values())).size
    # A million numbers on a terminal serve nobody; the CSV of --out has them.
    listed = points <= _LISTED_POINTS
    columns = {
        name: [None if value != value else float(value) for value in values] if listed else None  # noqa: PLR0124
        for name, values in found.columns.items()
    }
    return {
        "axes": axes,
        "points": points,
        "columns": columns,
        "effects": {"simulated": found.simulated},
        **{key: getattr(found, key) for key in _TOLD},
    }


@command("ropefric explain data/scenes/hoist.toml --measure", order=170)
def explain(
    _out: Output,
    scene: SceneArgument,
    *,
    measure: bool = Option(
        False, "--measure", help="Solve with and without each effect, for its worth and its time."
    ),
) -> Answer:
    """Explain how a scene is solved: the effects that are simulated, those that are not, the method, and why."""
    from ropefric.report.scene import explanation_sections  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.scenes.plan import explain_scene  # noqa: PLC0415
    from ropefric.scenes.scene import load_scene  # noqa: PLC0415

    found = explain_scene(load_scene(scene), measure=measure)
    return Answer(found.to_dict(), explanation_sections(found))
