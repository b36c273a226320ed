"""`ropefric explain`: which effects of a scene are simulated, why, and what they are worth."""

from pathlib import Path
from typing import Annotated

import typer

from ropefric.cli.command import Answer, Command
from ropefric.cli.fitting_options import show_sections
from ropefric.cli.output import Output

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE.toml", help="What to explain.")]
Measure = Annotated[
    bool, typer.Option("--measure", help="Solve with and without each effect, for its worth and its time.")
]


def explain(out: Output, scene: SceneFile, *, measure: Measure = False) -> Answer:  # noqa: ARG001  (a command takes it)
    """Explain how a scene is solved: the effects that are simulated, those that are not, the method, and why."""
    from ropefric.report.scene import explanation_sections  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.scenes.plan import explain_scene  # noqa: PLC0415
    from ropefric.scenes.scene import load_scene  # noqa: PLC0415

    told = explain_scene(load_scene(scene), measure=measure)
    return Answer(
        data=told.to_dict(), show=lambda console: show_sections(explanation_sections(told), console)
    )


COMMAND = Command(
    name="explain", run=explain, example="ropefric explain data/scenes/hoist.toml --measure", order=170
)
