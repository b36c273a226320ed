"""`ropefric simulate`: a campaign on the virtual rig, whose truth is known."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from typer import Argument, Option

from ropefric.cli.options import Answer, Command, parse_assignments
from ropefric.cli.output import Output, Progress
from ropefric.errors import UnknownNameError
from ropefric.glossary import counted
from ropefric.registry import did_you_mean


def simulate(
    out: Output,
    folder: Path = Argument(Path("simulated"), help="A new or empty folder."),
    *,
    seed: int | None = Option(
        None, min=0, help="The same seed writes the same bytes; default: the bench's own."
    ),
    bench: str = Option("prth-bench", help="Which campaign to simulate: prth-bench."),
    law: str = Option("", help="The friction law that is true, instead of the bench's own."),
    parameter: list[str] | None = Option(
        None, "--parameter", "-p", metavar="NAME=VALUE", help="A true parameter of the law; repeatable."
    ),
    repeats: int | None = Option(None, min=1, help="Recordings per condition."),
    conditions: int | None = Option(None, min=1, help="Only the first so many conditions."),
    fault: list[str] | None = Option(
        None, metavar="NAME=RATE", help="Only this fault, at this rate (0 to 1); repeatable."
    ),
    no_faults: bool = Option(False, "--no-faults", help="Nothing goes wrong."),
) -> Answer:
    """Simulate a campaign with known truth: campaign.toml, trials.csv, recordings and truth.toml.

    Rope and cell stiffness, motor ramp, scatter, stick-slip, noise, converter and the usual faults are simulated.
    Without options it writes data/prth-bench again, byte for byte.
    """
    from ropefric.rig.campaign import PRTH_SEED, prth_bench_plan, simulate_campaign  # noqa: PLC0415  (quick start-up)

    benches = {"prth-bench": (prth_bench_plan, PRTH_SEED)}
    if bench not in benches:
        raise UnknownNameError(f"unknown bench {bench!r}", fix=did_you_mean(bench, benches))
    make, own_seed = benches[bench]
    plan = make()
    given = parse_assignments(parameter or (), option="--parameter")
    changes: dict[str, Any] = {}
    if law and law != plan.law:
        changes |= {"law": law, "parameters": given}
    elif given:
        changes["parameters"] = {**plan.parameters, **given}
    if repeats is not None:
        changes["repeats"] = repeats
    if conditions is not None:
        changes["conditions"] = plan.conditions[:conditions]
    if fault is not None or no_faults:
        changes["faults"] = parse_assignments(fault or (), option="--fault")
    plan = replace(plan, **changes)
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
    made = f"{counted(plan.n_trials, 'recording')} of {counted(len(plan.conditions), 'condition')}"
    return Answer(data, f"{made}, law {plan.law}, seed {seed} → {campaign}")


COMMAND = Command("simulate", simulate, "ropefric simulate my-bench --seed 7 --repeats 6", order=40)
