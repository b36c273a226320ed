"""`ropefric check`: everything that is wrong with a campaign or a scene, before an hour of work."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropefric.cli.campaign_file import campaign_file
from ropefric.cli.command import Answer, Command
from ropefric.cli.holdings import count_holdings, show_holdings
from ropefric.cli.output import Output
from ropefric.errors import DataError, raise_problems

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.errors import Problem


CheckedFile = Annotated[
    Path,
    typer.Argument(
        metavar="CAMPAIGN.toml|SCENE.toml", help="A campaign: its file or its folder. Or a scene."
    ),
]


def check(out: Output, campaign: CheckedFile) -> Answer:
    """List everything that is wrong or doubtful in a campaign, all at once, and tell what it holds.

    A scene is checked too. Nothing is extracted, solved or written. Exit code 3 if there are errors; warnings alone
    leave it at 0.
    """
    from ropefric.trials.campaign import check_campaign, load_campaign  # noqa: PLC0415  (quick start-up)

    campaign = campaign_file(campaign)
    scene = _is_scene(campaign)
    problems = _scene_problems(campaign) if scene else check_campaign(campaign)
    n_errors = sum(problem.severity == "error" for problem in problems)
    if not out.json:
        out.problems(problems)
    tally = f"{_count(n_errors, 'error')}, {_count(len(problems) - n_errors, 'warning')}"
    data: dict[str, Any] = {"ok": n_errors == 0, "problems": [_problem_dict(problem) for problem in problems]}
    try:
        raise_problems(problems)
    except DataError as failure:
        data |= failure.to_dict()
        return Answer(
            data=data,
            show=lambda console: _say(console, f"{campaign}: {tally}"),
            exit_code=DataError.exit_code,
        )
    if scene:
        return Answer(data=data, show=lambda console: _say(console, f"{campaign}: {tally}"))
    holdings = count_holdings(load_campaign(campaign))
    data["campaign"] = holdings

    def show(console: "Console") -> None:
        _say(console, f"{campaign}: {tally}")
        show_holdings(holdings, console)

    return Answer(data=data, show=show)


def _is_scene(path: Path) -> bool:
    """Return whether a file is a scene; one that cannot be read is for the check of campaigns to tell of."""
    from ropefric.files.toml import is_scene, read_toml  # noqa: PLC0415  (quick start-up)

    try:
        return is_scene(read_toml(path).data)
    except DataError:
        return False


def _scene_problems(path: Path) -> "tuple[Problem, ...]":
    from ropefric.scenes.scene import check_scene  # noqa: PLC0415  (quick start-up)

    return check_scene(path)


def _say(console: "Console", text: str) -> None:
    console.print(text, markup=False, soft_wrap=True)


def _count(n: int, what: str) -> str:
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def _problem_dict(problem: "Problem") -> dict[str, str]:
    return {
        "code": problem.code,
        "severity": problem.severity,
        "message": problem.message,
        "where": problem.where,
        "fix": problem.fix,
    }


COMMAND = Command(name="check", run=check, example="ropefric check data/prth-bench/campaign.toml", order=30)
