"""What a campaign holds, counted: trials, conditions, radii, wraps, end tensions, repeats."""

import math
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ropefric.cli.tables import make_table, number

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.trials.campaign_model import Campaign


def count_holdings(campaign: "Campaign") -> dict[str, Any]:
    """Return what a campaign holds, in SI, as `check --json` prints it."""
    trials = campaign.trials
    from ropefric.friction.condition import condition_groups  # noqa: PLC0415  (quick start-up)

    settings = [
        (t.wheel_radius_m, t.rope_radius_m, t.wrap_angle_rad, t.end_tension_N or 0.0, t.lift_force_N or 0.0)
        for t in trials
    ]
    repeats = Counter(condition_groups(*zip(*settings, strict=True)).tolist() if settings else ())
    return {
        "name": campaign.name,
        "n_trials": len(trials),
        "n_files": len({t.path for t in trials}),
        "n_excluded": sum(bool(t.exclude) for t in trials),
        "n_conditions": len(repeats),
        "repeats": {"fewest": min(repeats.values(), default=0), "most": max(repeats.values(), default=0)},
        "wheel_radius_m": _values(t.wheel_radius_m for t in trials),
        "rope_radius_m": _values(t.rope_radius_m for t in trials),
        "wrap_angle_rad": _values(t.wrap_angle_rad for t in trials),
        "end_tension_N": _values(t.end_tension_N for t in trials),
        "lift_force_N": _values(t.lift_force_N for t in trials),
        "rejection": campaign.rejection,
    }


def show_holdings(holdings: dict[str, Any], console: "Console") -> None:
    """Print what a campaign holds in the units people use at the rig."""
    fewest, most = holdings["repeats"]["fewest"], holdings["repeats"]["most"]
    excluded = f", {holdings['n_excluded']} of them excluded" if holdings["n_excluded"] else ""
    rows = [
        ("campaign", holdings["name"] or "(no name)"),
        ("trials", f"{holdings['n_trials']} in {holdings['n_files']} files{excluded}"),
        ("conditions", f"{holdings['n_conditions']}"),
        ("repeats", f"{fewest}" if fewest == most else f"{fewest} to {most} per condition"),
        ("wheel radius R_w", _listed(holdings["wheel_radius_m"], 1e3, "mm")),
        ("rope radius R_r", _listed(holdings["rope_radius_m"], 1e3, "mm")),
        ("wrap φ", _listed(holdings["wrap_angle_rad"], math.degrees(1.0), "deg")),
        ("end tension F_B", _listed(holdings["end_tension_N"], 1.0, "N")),
        ("lift force F_A", _listed(holdings["lift_force_N"], 1.0, "N")),
        ("rejection", holdings["rejection"]),
    ]
    table = make_table(("", " "), [row for row in rows if row[1]])
    table.show_header = False
    console.print(table)


def _values(values: Iterable[float | None]) -> list[float]:
    return sorted({value for value in values if value is not None})


def _listed(values: list[float], factor: float, unit: str) -> str:
    """Return values as a list with their unit; of very many only how many and their limits."""
    if not values:
        return ""
    texts = list(dict.fromkeys(number(value * factor, ".6g") for value in values))
    if len(texts) > 12:
        return f"{len(texts)} values from {texts[0]} to {texts[-1]} {unit}"
    return f"{', '.join(texts)} {unit}"
