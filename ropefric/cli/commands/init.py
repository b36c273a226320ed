"""`ropefric init`: a commented campaign, or commented scenes, to fill in."""

from pathlib import Path
from typing import Annotated

import typer

from ropefric.cli.options import Answer, Command
from ropefric.cli.output import Output

Folder = Annotated[Path, typer.Argument(help="Where to write them; made where it is missing.")]
Scenes = Annotated[bool, typer.Option("--scenes", help="Write all scenes instead of a campaign.")]
SceneName = Annotated[
    list[str] | None,
    typer.Option(
        "--scene",
        metavar="NAME",
        help="Write this scene: hoist, climbing-hoist, belt-press, band-saw, traction, belt-drive, …; repeatable.",
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Write over files that are already there.")]


def init(
    out: Output,
    *,
    folder: Folder = Path(),
    scenes: Scenes = False,
    scene: SceneName = None,
    force: Force = False,
) -> Answer:
    """Write commented templates to fill in: a campaign, or with --scenes machines to solve: hoists, presses, …."""
    if scenes or scene:
        from ropefric.scenes.scene_templates import write_scenes  # noqa: PLC0415  (quick start-up)

        written = write_scenes(folder, () if scenes else scene or (), overwrite=force)
        first = folder / "hoist.toml"
        out.note(f"next: ropefric solve {first if first in written else written[0]}")
    else:
        from ropefric.trials.campaign import write_templates  # noqa: PLC0415  (quick start-up)

        written = write_templates(folder, overwrite=force)
        out.note(f"next: fill them in, then  ropefric check {written[0]}")
    return Answer(data={"written": written}, show=lambda _: "\n".join(f"wrote {path}" for path in written))


COMMAND = Command(name="init", run=init, example="ropefric init my-scenes --scene hoist", order=10)
