"""`ropefric check`: everything that is wrong with a campaign or a scene, before an hour of work."""

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typer import Argument

from ropefric.cli.options import Answer, Command, campaign_file
from ropefric.cli.output import Output, make_table, number
from ropefric.errors import DataError, raise_problems
from ropefric.glossary import counted

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.trials.campaign_model import Campaign


def check(
    out: Output,
    campaign: Path = Argument(
        ..., metavar="CAMPAIGN.toml|SCENE.toml", help="A campaign: its file or its folder. Or a scene."
    ),
) -> Answer:
    """List everything that is wrong or doubtful in a campaign, all at once, and tell what it holds.

    A scene is checked too. Nothing is extracted, solved or written. Exit code 3 if there are errors; warnings alone
    leave it at 0.
    """
    from ropefric.scenes.scene import check_scene  # noqa: PLC0415  (all of these: quick start-up)
    from ropefric.trials.campaign import check_campaign, load_campaign  # noqa: PLC0415

    campaign = campaign_file(campaign)
    scene = _is_scene(campaign)
    problems = check_scene(campaign) if scene else check_campaign(campaign)
    n_errors = sum(problem.severity == "error" for problem in problems)
    if not out.json:
        out.problems(problems)
    summary = f"{campaign}: {counted(n_errors, 'error')}, {counted(len(problems) - n_errors, 'warning')}"
    listed = [problem.to_dict() | {"severity": problem.severity} for problem in problems]
    data: dict[str, Any] = {"ok": n_errors == 0, "problems": listed}
    try:
        raise_problems(problems)
    except DataError as failure:
        return Answer(data | failure.to_dict(), summary, DataError.exit_code)
    if scene:
        return Answer(data, summary)
    content = _content(load_campaign(campaign))

    def show(console: "Console") -> None:
        console.print(summary, markup=False, soft_wrap=True)
        _show_content(content, console)

    return Answer(data | {"campaign": content}, show)


def _is_scene(path: Path) -> bool:
    """Return whether a file is a scene; one that cannot be read is for the check of campaigns to tell of."""
    from ropefric.files.toml import is_scene, read_toml  # noqa: PLC0415  (quick start-up)

    try:
        return is_scene(read_toml(path).data)
    except DataError:
        return False


def _content(campaign: "Campaign") -> dict[str, Any]:
    """Return what a campaign holds, in SI: trials, conditions, radii, wraps, end tensions, repeats."""
    from ropefric.friction.condition import condition_groups  # noqa: PLC0415  (quick start-up)

    trials = campaign.trials
    settings = [
        (t.wheel_radius_m, t.rope_radius_m, t.wrap_angle_rad, t.end_tension_N or 0.0, t.lift_force_N or 0.0)
        for t in trials
    ]
    repeats = Counter(condition_groups(*zip(*settings, strict=True)).tolist() if settings else ())
    keys = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "lift_force_N")
    return {
        "name": campaign.name,
        "n_trials": len(trials),
        "n_files": len({t.path for t in trials}),
        "n_excluded": sum(bool(t.exclude) for t in trials),
        "n_conditions": len(repeats),
        "repeats": {"fewest": min(repeats.values(), default=0), "most": max(repeats.values(), default=0)},
        **{key: sorted({value for t in trials if (value := getattr(t, key)) is not None}) for key in keys},
        "rejection": campaign.rejection,
    }


def _show_content(content: dict[str, Any], console: "Console") -> None:
    """Print what a campaign holds in the units people use at the rig."""
    fewest, most = content["repeats"]["fewest"], content["repeats"]["most"]
    excluded = f", {content['n_excluded']} of them excluded" if content["n_excluded"] else ""
    rows = [
        ("campaign", content["name"] or "(no name)"),
        ("trials", f"{content['n_trials']} in {content['n_files']} files{excluded}"),
        ("conditions", f"{content['n_conditions']}"),
        ("repeats", f"{fewest}" if fewest == most else f"{fewest} to {most} per condition"),
        ("wheel radius R_w", _listed(content["wheel_radius_m"], 1e3, "mm")),
        ("rope radius R_r", _listed(content["rope_radius_m"], 1e3, "mm")),
        ("wrap φ", _listed(content["wrap_angle_rad"], math.degrees(1.0), "deg")),
        ("end tension F_B", _listed(content["end_tension_N"], 1.0, "N")),
        ("lift force F_A", _listed(content["lift_force_N"], 1.0, "N")),
        ("rejection", content["rejection"]),
    ]
    table = make_table(("", " "), [row for row in rows if row[1]])
    table.show_header = False
    console.print(table)


def _listed(values: Iterable[float], factor: float, unit: str) -> str:
    """Return values as a list with their unit; of very many only how many and their limits."""
    texts = list(dict.fromkeys(number(value * factor, ".6g") for value in values))
    if len(texts) > 12:
        return f"{len(texts)} values from {texts[0]} to {texts[-1]} {unit}"
    return f"{', '.join(texts)} {unit}" if texts else ""


COMMAND = Command("check", check, "ropefric check data/prth-bench/campaign.toml", order=30)
