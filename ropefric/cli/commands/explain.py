"""`ropefric explain`: which effects of a scene are simulated, why, and what they are worth."""

from typer import Option

from ropefric.cli.options import Answer, Command, SceneArgument
from ropefric.cli.output import Output


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


COMMAND = Command("explain", explain, "ropefric explain data/scenes/hoist.toml --measure", order=170)
