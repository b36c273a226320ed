"""A whole simulated campaign on disk: campaign.toml, trials.csv, traces and the truth."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.files.write import write_file
from ropefric.rig.bench import simulate_recording
from ropefric.rig.faults import FAULTS, SATURATION_MARGIN
from ropefric.rig.files import campaign_text, known_force, packed, recording_text, table_text, toml_value
from ropefric.rig.plan import CampaignPlan, RigCondition
from ropefric.rig.protocols import RIG_PROTOCOLS
from ropefric.rig.story import RecordingTruth, SimulatedRecording

TRUTH_SCHEMA = "ropefric.rig-truth/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedTrial:
    """One recording to be made."""

    name: str
    index: int
    condition: RigCondition
    lift_force_N: float
    cell: str
    faults: tuple[str, ...]

    @property
    def file(self) -> str:
        """Return where its recording is, within the campaign."""
        return f"traces/{self.name}.csv.gz"


def plan_trials(plan: CampaignPlan, *, seed: int) -> tuple[PlannedTrial, ...]:
    """Return every recording of a campaign: its static friction with scatter, its cell, its faults.

    Faults are dealt out by quota, rate times number of recordings, so that a small campaign has them too. At
    most one fault of the mechanics befalls a recording; faults of samples and file come on top.
    """
    if seed < 0:
        raise InputError(f"seed {seed} is negative", key="seed", fix="use 0 or more")
    law_N = plan.lift_force_N(plan.conditions)
    way = RIG_PROTOCOLS[plan.protocol]
    rng = np.random.default_rng([seed, 0])
    by_condition = 1.0 + plan.bench.condition_scatter * rng.standard_normal((law_N.size, 1))
    by_trial = 1.0 + plan.bench.trial_scatter * rng.standard_normal((law_N.size, plan.repeats))
    scattered_N = law_N[:, np.newaxis] * by_condition * (1.0 if way.scatters_inside else by_trial)
    lift_N = np.broadcast_to(scattered_N, by_trial.shape).ravel()
    dealt = _deal_faults(plan, np.repeat(law_N, plan.repeats), np.random.default_rng([seed, 1]))
    cells = [
        plan.bench.cell_for(force_N if way.measures_lift else condition.end_tension_N).name
        for condition, force_N in zip(plan.conditions, law_N.tolist(), strict=True)
    ]
    return tuple(
        PlannedTrial(
            name=f"c{index // plan.repeats + 1:02d}-r{index % plan.repeats + 1:02d}",
            index=index,
            condition=plan.conditions[index // plan.repeats],
            lift_force_N=force_N,
            cell=cells[index // plan.repeats],
            faults=tuple(dealt[index]),
        )
        for index, force_N in enumerate(lift_N.tolist())
    )


def _deal_faults(plan: CampaignPlan, law_N: FloatArray, rng: np.random.Generator) -> list[list[str]]:
    dealt: list[list[str]] = [[] for _ in range(law_N.size)]
    spoilt = np.zeros(law_N.size, dtype=bool)
    for name, rate in plan.faults.items():
        fault = FAULTS[name]
        can = ~spoilt if fault.on_setup else np.ones_like(spoilt)
        if name == "saturation":
            # The honest cause is a cell too small for the force; only where there is none does a rope jam. Whole
            # conditions lie above it: choosing the strongest trials would bias the mean of those that are left.
            least_N = (1.0 - 4.0 * plan.bench.trial_scatter) * law_N
            over = can & (least_N >= SATURATION_MARGIN * plan.bench.cells[0].full_scale_N)
            can = over if over.any() else can
        places = np.flatnonzero(can)
        n = min(round(rate * law_N.size), places.size)
        for index in np.sort(rng.choice(places, size=n, replace=False)).tolist():
            dealt[index].append(name)
            spoilt[index] |= fault.on_setup is not None
    return dealt


def record_trial(plan: CampaignPlan, trial: PlannedTrial, *, seed: int) -> tuple[SimulatedRecording, bytes]:
    """Return one recording of a campaign and the bytes of its file; needs none of the other recordings."""
    recording = simulate_recording(
        plan.bench,
        lift_force_N=trial.lift_force_N,
        end_tension_N=trial.condition.end_tension_N,
        rng=np.random.default_rng([seed, 2, trial.index]),
        faults=trial.faults,
        protocol=plan.protocol,
        cell=trial.cell,
    )
    data = packed(recording_text(recording))
    file_rng = np.random.default_rng([seed, 3, trial.index])
    for name in trial.faults:
        on_bytes = FAULTS[name].on_bytes
        if on_bytes:
            data = on_bytes(data, file_rng)
    return recording, data


def simulate_campaign(
    folder: str | Path,
    plan: CampaignPlan,
    *,
    seed: int,
    progress: Callable[[int, int, str], None] | None = None,
) -> tuple[Path, ...]:
    """Write a campaign with known truth and return the paths written: campaign.toml, trials.csv, truth.toml, traces.

    The same plan and seed write the same bytes.
    """
    base = Path(folder)
    trials = plan_trials(plan, seed=seed)
    truths: list[RecordingTruth] = []
    try:
        (base / "traces").mkdir(parents=True, exist_ok=True)
        taken = sorted(path.name for path in base.iterdir() if path.name != "traces" or path.is_symlink())
        taken += sorted(f"traces/{path.name}" for path in (base / "traces").iterdir())
        if taken:
            raise InputError(
                f"the folder already holds {taken[0]}; nothing is overwritten",
                path=base,
                fix="name an empty or a new folder",
            )
        for done, trial in enumerate(trials, start=1):
            recording, data = record_trial(plan, trial, seed=seed)
            write_file(base / trial.file, data, durable=False)
            truths.append(recording.truth)
            if progress is not None:
                progress(done, len(trials), trial.name)
        texts = {
            "campaign.toml": campaign_text(plan),
            "trials.csv": _trials_text(plan, trials, truths),
            "truth.toml": "\n".join([*_truth_lines(plan, trials, truths, seed), ""]),
        }
        for name, text in texts.items():
            write_file(base / name, text)
    except OSError as error:
        raise InputError(
            f"cannot write there: {error.strerror or error}", path=base, fix="name a folder you may write to"
        ) from error
    return (*(base / name for name in texts), *(base / trial.file for trial in trials))


def _trials_text(plan: CampaignPlan, trials: tuple[PlannedTrial, ...], truths: list[RecordingTruth]) -> str:
    column, _ = known_force(plan, trials[0].condition, trials[0].lift_force_N)
    columns = ["trial", "file", "wheel", "wrap_angle_deg", column, "cell", "rope_id", "dwell_s", "exclude"]
    rows = []
    for trial, truth in zip(trials, truths, strict=True):
        _, force_N = known_force(plan, trial.condition, trial.lift_force_N)
        wrap_deg = f"{np.degrees(trial.condition.wrap_angle_rad):.10g}"
        dwell = "" if np.isnan(truth.dwell_s) else f"{truth.dwell_s:.3f}"
        rope = f"sim-rope-{trial.index + 1:03d}"
        wheel = trial.condition.wheel
        rows.append([trial.name, trial.file, wheel, wrap_deg, f"{force_N:.10g}", truth.cell, rope, dwell, ""])
    return table_text(columns, rows)


def _truth_lines(
    plan: CampaignPlan, trials: tuple[PlannedTrial, ...], truths: list[RecordingTruth], seed: int
) -> Iterator[str]:
    yield "# What is true of this simulated campaign. An analysis must not read it; a test of one may."
    yield f"schema = {toml_value(TRUTH_SCHEMA)}"
    yield "simulated = true"
    yield f"seed = {seed}"
    yield f"law = {toml_value(plan.law)}"
    yield f"parameters = {toml_value({k: float(v) for k, v in plan.parameters.items()})}"
    yield f"rope_radius_m = {toml_value(0.5 * plan.rope_diameter_m)}"
    yield f"trial_scatter = {toml_value(plan.bench.trial_scatter)}"
    yield f"condition_scatter = {toml_value(plan.bench.condition_scatter)}"
    for kind, conditions in (("conditions", plan.conditions), ("unseen", (plan.design, *plan.unseen))):
        for condition, force_N in zip(conditions, plan.lift_force_N(conditions).tolist(), strict=True):
            yield f"\n[[{kind}]]"
            yield f"wheel_radius_m = {toml_value(condition.wheel_radius_m)}"
            yield f"wrap_angle_rad = {toml_value(condition.wrap_angle_rad)}"
            yield f"end_tension_N = {toml_value(condition.end_tension_N)}"
            yield f"lift_force_N = {toml_value(force_N)}"
    yield "\n[trials]"
    for trial, truth in zip(trials, truths, strict=True):
        yield f"{trial.name} = {toml_value(_truth_of(plan, truth))}"


def _truth_of(plan: CampaignPlan, truth: RecordingTruth) -> dict[str, object]:
    numbers = {
        "lift_force_N": truth.lift_force_N,
        "breakaway_time_s": truth.breakaway_time_s,
        "kinetic_N": truth.kinetic_N,
    }
    lists = {"tooth_tops_N": truth.tooth_tops_N, "plateaus_N": truth.plateaus_N}
    inside = RIG_PROTOCOLS[plan.protocol].scatters_inside
    return {
        "status": truth.status.value,
        "faults": truth.faults,
        **{key: value for key, value in numbers.items() if not np.isnan(value)},
        **{key: value for key, value in lists.items() if inside and value},
    }
