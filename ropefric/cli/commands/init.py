"""`ropefric init`: a commented campaign, or commented scenes, to fill in."""

from pathlib import Path

from typer import Argument, Option

from ropefric.cli.options import Answer, Command
from ropefric.cli.output import Output


def init(
    out: Output,
    *,
    folder: Path = Argument(Path(), help="Where to write them; made where it is missing."),
    scenes: bool = Option(False, "--scenes", help="Write all scenes instead of a campaign."),
    scene: list[str] | None = Option(
        None,
        "--scene",
        metavar="NAME",
        help="Write this scene: hoist, climbing-hoist, belt-press, band-saw, traction, belt-drive, …; repeatable.",
    ),
    force: bool = Option(False, "--force", help="Write over files that are already there."),
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
    return Answer({"written": written}, "\n".join(f"wrote {path}" for path in written))


COMMAND = Command("init", init, "ropefric init my-scenes --scene hoist", order=10)
