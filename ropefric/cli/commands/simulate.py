"""`ropefric simulate`: a campaign on the virtual rig, whose truth is known."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ropefric.cli.assignments import parse_assignments
from ropefric.cli.command import Answer, Command
from ropefric.cli.output import Output
from ropefric.cli.progress import Progress
from ropefric.glossary import counted

if TYPE_CHECKING:
    from rich.console import Console

    from ropefric.rig.campaign import CampaignPlan


Folder = Annotated[Path, typer.Argument(help="A new or empty folder.")]
Seed = Annotated[
    int | None, typer.Option(min=0, help="The same seed writes the same bytes; default: the bench's own.")
]
Bench = Annotated[str, typer.Option(help="Which campaign to simulate: prth-bench.")]
Law = Annotated[str, typer.Option(help="The friction law that is true, instead of the bench's own.")]
Parameters = Annotated[
    list[str] | None,
    typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="A true parameter of the law; repeatable."),
]
Repeats = Annotated[int | None, typer.Option(min=1, help="Recordings per condition.")]
Conditions = Annotated[int | None, typer.Option(min=1, help="Only the first so many conditions.")]
Fault = Annotated[
    list[str] | None,
    typer.Option("--fault", metavar="NAME=RATE", help="Only this fault, at this rate (0 to 1); repeatable."),
]
NoFaults = Annotated[bool, typer.Option("--no-faults", help="Nothing goes wrong.")]


def simulate(
    out: Output,
    folder: Folder = Path("simulated"),
    *,
    seed: Seed = None,
    bench: Bench = "prth-bench",
    law: Law = "",
    parameter: Parameters = None,
    repeats: Repeats = None,
    conditions: Conditions = None,
    fault: Fault = None,
    no_faults: NoFaults = False,
) -> Answer:
    """Simulate a campaign with known truth: campaign.toml, trials.csv, recordings and truth.toml.

    Rope and cell stiffness, motor ramp, scatter, stick-slip, noise, converter and the usual faults are simulated.
    Without options it writes data/prth-bench again, byte for byte.
    """
    from ropefric.rig.campaign import simulate_campaign  # noqa: PLC0415  (quick start-up)

    plan, own_seed = _bench_plan(bench)
    faults = [] if no_faults and fault is None else fault
    plan = _changed(
        plan, law=law, parameters=parameter, repeats=repeats, conditions=conditions, faults=faults
    )
    seed = own_seed if seed is None else seed
    with Progress(out, "simulate") as progress:
        written = simulate_campaign(folder, plan, seed=seed, progress=progress.update)
    campaign = next(path for path in written if path.name == "campaign.toml")
    out.note(f"next: ropefric extract {campaign} --out out")
    data = {
        "campaign": campaign,
        "bench": bench,
        "seed": seed,
        "law": plan.law,
        "parameters": dict(plan.parameters),
        "faults": dict(plan.faults),
        "n_conditions": len(plan.conditions),
        "n_trials": plan.n_trials,
    }

    def show(console: "Console") -> None:
        made = f"{counted(plan.n_trials, 'recording')} of {counted(len(plan.conditions), 'condition')}"
        text = f"{made}, law {plan.law}, seed {seed}"
        console.print(f"{text} → {campaign}", markup=False, soft_wrap=True)

    return Answer(data=data, show=show)


def _bench_plan(name: str) -> tuple["CampaignPlan", int]:
    from ropefric.errors import UnknownNameError  # noqa: PLC0415
    from ropefric.registry import did_you_mean  # noqa: PLC0415
    from ropefric.rig.campaign import PRTH_SEED, prth_bench_plan  # noqa: PLC0415

    benches = {"prth-bench": (prth_bench_plan, PRTH_SEED)}
    if name not in benches:
        raise UnknownNameError(f"unknown bench {name!r}", fix=did_you_mean(name, benches))
    make, seed = benches[name]
    return make(), seed


def _changed(
    plan: "CampaignPlan",
    *,
    law: str,
    parameters: list[str] | None,
    repeats: int | None,
    conditions: int | None,
    faults: list[str] | None,
) -> "CampaignPlan":
    changes: dict[str, Any] = {}
    if law and law != plan.law:
        changes |= {"law": law, "parameters": parse_assignments(parameters or (), option="--parameter")}
    elif parameters:
        changes["parameters"] = {**plan.parameters, **parse_assignments(parameters, option="--parameter")}
    if repeats is not None:
        changes["repeats"] = repeats
    if conditions is not None:
        changes["conditions"] = plan.conditions[:conditions]
    if faults is not None:
        changes["faults"] = parse_assignments(faults, option="--fault")
    return replace(plan, **changes) if changes else plan


COMMAND = Command(
    name="simulate", run=simulate, example="ropefric simulate my-bench --seed 7 --repeats 6", order=40
)
