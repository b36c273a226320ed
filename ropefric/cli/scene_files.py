"""What `ropefric solve --out` writes beside the answer: figures, and the histories of a start-up."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ropefric.files.folder import Folder
    from ropefric.plotting.figure import FigureWithData
    from ropefric.scenes.solve import Solution


def write_scene_files(solution: "Solution", folder: "Folder") -> list[Path]:
    """Write the figures and tables of a solved scene, as far as its system has any; return their paths."""
    from ropefric.plotting.figure import save_figure  # noqa: PLC0415  (quick start-up)

    written: list[Path] = []
    for stem, figure in _figures(solution):
        written += save_figure(figure, folder, stem)
    start_up = getattr(solution.answer, "start_up", None)
    if start_up is not None:
        from ropefric.scenes.histories import start_up_columns  # noqa: PLC0415
        from ropefric.scenes.table import columns_text  # noqa: PLC0415

        written += folder.write({"start_up.csv": columns_text(start_up_columns(start_up))})
    return written


def _figures(solution: "Solution") -> "list[tuple[str, FigureWithData]]":
    """Return a system's figures by file name; a hoist's are its sweeps."""
    if solution.scene.kind.name == "press" and solution.answer.start_up is not None:
        from ropefric.plotting.press import draw_press_start_up  # noqa: PLC0415

        return [("start_up_figure", draw_press_start_up(solution.answer.start_up))]
    if solution.scene.kind.name == "bandsaw":
        return _saw_figures(solution)
    return []


def _saw_figures(solution: "Solution") -> "list[tuple[str, FigureWithData]]":
    from ropefric.plotting.saw_chart import draw_saw_chart  # noqa: PLC0415
    from ropefric.scenes.kinds.saw_report import planned_saw, speeds_m_s  # noqa: PLC0415
    from ropefric.systems.bandsaw.campbell import saw_chart  # noqa: PLC0415
    from ropefric.systems.bandsaw.saw import Side  # noqa: PLC0415

    problem = solution.scene.problem
    saw = planned_saw(solution.answer, problem)
    if saw is None or not problem.excitations:
        return []
    speeds = min((speeds_m_s(saw, side) for side in (Side.TIGHT, Side.SLACK)), key=lambda one: float(one[-1]))
    chart = saw_chart(saw, problem.excitations, speeds, min(problem.n_modes, 4))
    return [("campbell", draw_saw_chart(chart))]
