"""A simulated campaign: its plan, its trials, and its files: campaign.toml, trials.csv, truth.toml, recordings."""

import gzip
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import InputError
from ropefric.files.disk import write_file
from ropefric.files.plain_text import csv_text, to_spreadsheet
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.rig.bench import Bench, RecordingTruth
from ropefric.rig.recording import FAULTS, ORDINARY, SATURATION_MARGIN, SimulatedRecording, simulate_recording

TRUTH_SCHEMA = "ropefric.rig-truth/1"
PRTH_SEED = 20260
"""The seed `data/prth-bench` was written with."""
_MOST_TRIALS = 100_000
_TEMPLATE = Path(__file__).with_name("campaign.toml")
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class RigCondition:
    """One condition: a wheel, a wrap, a weight."""

    wheel_radius_m: float
    wrap_angle_rad: float
    end_tension_N: float

    @property
    def wheel(self) -> str:
        """Return the wheel's name: W and its radius in millimetres."""
        return f"W{1e3 * self.wheel_radius_m:.6g}".replace(".", "p")


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignPlan:
    """Plan of a simulated campaign: true law, conditions, repeats, faults."""

    name: str
    law: str
    parameters: Mapping[str, float]
    rope_diameter_m: float
    conditions: tuple[RigCondition, ...]
    design: RigCondition
    unseen: tuple[RigCondition, ...] = ()
    repeats: int = 12
    faults: Mapping[str, float] = field(default_factory=lambda: dict(ORDINARY))
    bench: Bench = field(default_factory=Bench)

    def __post_init__(self) -> None:
        if not 0 < self.n_trials <= _MOST_TRIALS:
            message = f"{len(self.conditions)} conditions with {self.repeats} repeats are {self.n_trials} recordings"
            fix = "use fewer repeats, and at least one"
            raise InputError(f"{message}; the limit is {_MOST_TRIALS}", key="repeats", fix=fix)
        for name, rate in self.faults.items():
            FAULTS[name]  # refuses an unknown one
            if not 0.0 <= rate <= 1.0:
                raise InputError(f"fault '{name}': rate {rate:g} is not between 0 and 1", key="faults")
        self.lift_force_N(self.conditions)

    @property
    def n_trials(self) -> int:
        """Return the number of recordings."""
        return len(self.conditions) * self.repeats

    def lift_force_N(self, conditions: tuple[RigCondition, ...]) -> FloatArray:
        """Return the true lift force of conditions [N], shape (n,), without scatter."""
        law = ALL_LAWS[self.law]
        settings = (item.name for item in fields(RigCondition))
        columns = {name: np.array([getattr(one, name) for one in conditions]) for name in settings}
        pulls = Conditions(rope_radius_m=np.array(0.5 * self.rope_diameter_m), **columns)
        log_lift = law.log_lift(law.theta_from(self.parameters), pulls)
        if not float(log_lift.max()) < math.log(1e9):
            raise InputError(f"a lift force of e^{log_lift.max():.4g} N is beyond any rig", key="conditions")
        return np.exp(log_lift)


def prth_bench_plan() -> CampaignPlan:
    """Return the plan of `data/prth-bench`: 36 conditions of 12 repeats on five wheels, law `coupled`.

    It is the PRTH paper's series with a truth chosen here: the paper prints no fitted parameter; these were chosen so
    that the average μ runs from 0.20 to 0.10 and F_A/F_B from 1.3 to about 16.
    """
    # One factor at a time cannot tell a wrap effect from a load effect; the last conditions vary several at once. All
    # keep F_A above 60 N: below, a drop of a few counts would be lost in the noise of the 1 kN cell.
    points = [
        (30, 540, 60), *((other, 540, 60) for other in (15, 20, 40, 60)),  # mm, deg, N
        *((30, other, 60) for other in (90, 180, 270, 360, 720, 900, 1080)),
        *((30, 540, other) for other in (20, 40, 100, 150, 200)),
        (15, 180, 150), (60, 180, 150), (15, 360, 200), (60, 360, 200), (20, 270, 200), (40, 270, 100),
        (15, 720, 40), (60, 720, 40), (20, 720, 20), (40, 720, 15), (15, 900, 10), (60, 720, 10), (20, 1080, 80),
        (40, 900, 120), (15, 1080, 30), (60, 720, 5), (15, 1080, 200), (60, 900, 60), (60, 810, 150),
        (35, 400, 60), (25, 450, 50), (50, 630, 30),  # what is designed, and what stays unseen
    ]  # fmt: skip
    *conditions, design, unseen_1, unseen_2 = (
        RigCondition(wheel_radius_m=R / 1e3, wrap_angle_rad=math.radians(phi), end_tension_N=float(F))
        for R, phi, F in points
    )
    more = dict.fromkeys(("snag", "impact", "precursor"), 0.02)
    more |= dict.fromkeys(("rounded", "slow-fall", "zero-drift"), 0.01)
    # Recordings as short as the paper's phases allow: 432 of them are kept under version control.
    short: Any = {"idle_s": (0.27, 0.4), "dwell_s": (0.3, 0.5), "load_s": (1.0, 1.5), "slide_s": (0.6, 0.8)}
    return CampaignPlan(
        name="prth-bench",
        law="coupled",
        parameters={"mu_inf": 0.46, "a": -0.22, "b": -0.3, "c": -0.48, "d": 0.055},
        rope_diameter_m=0.0098,
        conditions=tuple(conditions),
        design=design,
        unseen=(unseen_1, unseen_2),
        faults=ORDINARY | {"hum": 0.05} | more,
        bench=Bench(**short, off_s=(0.15, 0.25)),
    )


class PlannedTrial(NamedTuple):
    """One recording to be made."""

    name: str
    place: int
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
    law_N = plan.lift_force_N(plan.conditions)
    rng = np.random.default_rng([seed, 0])
    by_condition = 1.0 + plan.bench.condition_scatter * rng.standard_normal((law_N.size, 1))
    by_trial = 1.0 + plan.bench.trial_scatter * rng.standard_normal((law_N.size, plan.repeats))
    lift_N = law_N[:, np.newaxis] * by_condition * by_trial
    ends_N = np.array([one.end_tension_N for one in plan.conditions])
    if weak := np.argwhere(lift_N <= ends_N[:, np.newaxis]).tolist():
        (first, repeat), n = weak[0], f"{len(weak)} of {lift_N.size} break-away forces"
        example = f"{lift_N[first, repeat]:.4g} N at {ends_N[first]:.4g} N"
        text = f"with the scatter of the bench {n} do not exceed their end tension; the first is {example}"
        raise InputError(text, key="parameters", fix="choose parameters that give more friction")
    dealt = _deal_faults(plan, np.repeat(law_N, plan.repeats), np.random.default_rng([seed, 1]))
    trials = []
    for number, (condition, force_N) in enumerate(zip(plan.conditions, law_N.tolist(), strict=True)):
        cell = plan.bench.cell_for(force_N).name
        for repeat in range(plan.repeats):
            index = number * plan.repeats + repeat
            name, one_N = f"c{number + 1:02d}-r{repeat + 1:02d}", float(lift_N[number, repeat])
            trials.append(PlannedTrial(name, index, condition, one_N, cell, tuple(dealt[index])))
    return tuple(trials)


def _deal_faults(plan: CampaignPlan, law_N: FloatArray, rng: np.random.Generator) -> list[list[str]]:
    dealt: list[list[str]] = [[] for _ in range(law_N.size)]
    spoilt = np.zeros(law_N.size, dtype=bool)
    for name, rate in plan.faults.items():
        mechanical = FAULTS[name].is_mechanical
        can = ~spoilt if mechanical else np.ones_like(spoilt)
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
            spoilt[index] |= mechanical
    return dealt


def record_trial(plan: CampaignPlan, trial: PlannedTrial, *, seed: int) -> tuple[SimulatedRecording, bytes]:
    """Return one recording of a campaign and the bytes of its file; needs none of the other recordings."""
    forces: dict[str, Any] = {
        "lift_force_N": trial.lift_force_N,
        "end_tension_N": trial.condition.end_tension_N,
    }
    rng = np.random.default_rng([seed, 2, trial.place])
    recording = simulate_recording(plan.bench, rng=rng, faults=trial.faults, cell=trial.cell, **forces)
    buffer = io.BytesIO()
    # Without name and time, so that the same text gives the same bytes. Level 9 takes five times as long for a
    # thousandth of the size: time stamps are what fills these files.
    with gzip.GzipFile(filename="", mode="wb", compresslevel=6, fileobj=buffer, mtime=0) as stream:
        stream.write(recording_text(recording).encode())
    data = buffer.getvalue()
    file_rng = np.random.default_rng([seed, 3, trial.place])
    for name in trial.faults:
        if on_bytes := FAULTS[name].on_bytes:
            data = on_bytes(data, file_rng)
    return recording, data


def simulate_campaign(
    folder: str | Path, plan: CampaignPlan, *, seed: int, progress: Progress | None = None
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
            message = f"the folder already holds {taken[0]}; nothing is overwritten"
            raise InputError(message, path=base, fix="name an empty or a new folder")
        for done, trial in enumerate(trials, start=1):
            recording, data = record_trial(plan, trial, seed=seed)
            write_file(base / trial.file, data, durable=False)
            truths.append(recording.truth)
            if progress is not None:
                progress(done, len(trials), trial.name)
        texts = {
            "campaign.toml": campaign_text(plan),
            "trials.csv": _trials_text(trials, truths),
            "truth.toml": "\n".join([*_truth_lines(plan, trials, truths, seed), ""]),
        }
        for name, text in texts.items():
            write_file(base / name, text)
    except OSError as error:
        message, fix = f"cannot write there: {error.strerror or error}", "name a folder you may write to"
        raise InputError(message, path=base, fix=fix) from error
    return (*(base / name for name in texts), *(base / trial.file for trial in trials))


def recording_text(recording: SimulatedRecording) -> str:
    """Return a recording as CSV text: `time_s` with 6 decimals, `counts` as whole numbers, empty where missing."""
    samples = zip(recording.time_s.tolist(), recording.counts.tolist(), strict=True)
    rows = [f"{time:.6f},{'' if math.isnan(count) else int(count)}" for time, count in samples]
    return "\n".join(["time_s,counts", *rows, ""])


def campaign_text(plan: CampaignPlan) -> str:
    """Return the `campaign.toml` of a plan."""
    radii_m = {
        one.wheel: one.wheel_radius_m for one in sorted(plan.conditions, key=lambda one: one.wheel_radius_m)
    }
    wheel = '[wheels.{}]\nradius = "{:.10g} mm"\nmaterial = "aluminium (simulated)"\n\n'
    numbers = {
        "diameter": 1e3 * plan.rope_diameter_m,
        "rate": 1e-3 * plan.bench.sampling_rate_Hz,
        "idle": math.floor(20.0 * (plan.bench.idle_s[0] - 0.01)) / 20.0,
        "radius": 1e3 * plan.design.wheel_radius_m,
        "wrap": math.degrees(plan.design.wrap_angle_rad),
        "tension": plan.design.end_tension_N,
    }
    return Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        {key: f"{number:.10g}" for key, number in numbers.items()},
        name=plan.name,
        wheels="".join(wheel.format(name, 1e3 * radius_m) for name, radius_m in radii_m.items()),
    )


def _trials_text(trials: tuple[PlannedTrial, ...], truths: list[RecordingTruth]) -> str:
    rows = [
        ["trial", "file", "wheel", "wrap_angle_deg", "end_tension_N", "cell", "rope_id", "dwell_s", "exclude"]
    ]
    for trial, truth in zip(trials, truths, strict=True):
        condition = trial.condition
        wrap_deg = f"{np.degrees(condition.wrap_angle_rad):.10g}"
        force, dwell = f"{condition.end_tension_N:.10g}", f"{truth.dwell_s:.3f}"
        rope = f"sim-rope-{trial.place + 1:03d}"
        rows.append([trial.name, trial.file, condition.wheel, wrap_deg, force, truth.cell, rope, dwell, ""])
    return csv_text(map(to_spreadsheet, row) for row in rows)


def _truth_lines(
    plan: CampaignPlan, trials: tuple[PlannedTrial, ...], truths: list[RecordingTruth], seed: int
) -> Iterator[str]:
    yield "# The truth of this simulated campaign. An analysis must not read it; a test of one may."
    yield from _keys(schema=TRUTH_SCHEMA, simulated=True, seed=seed)
    parameters = {name: float(value) for name, value in plan.parameters.items()}
    yield from _keys(law=plan.law, parameters=parameters, rope_radius_m=0.5 * plan.rope_diameter_m)
    yield from _keys(trial_scatter=plan.bench.trial_scatter, condition_scatter=plan.bench.condition_scatter)
    for kind, conditions in (("conditions", plan.conditions), ("unseen", (plan.design, *plan.unseen))):
        for condition, force_N in zip(conditions, plan.lift_force_N(conditions).tolist(), strict=True):
            yield from _table(f"[{kind}]", **asdict(condition), lift_force_N=force_N)
    yield from _table("trials")
    for trial, truth in zip(trials, truths, strict=True):
        numbers = {key: getattr(truth, key) for key in ("lift_force_N", "breakaway_time_s", "kinetic_N")}
        known = {key: value for key, value in numbers.items() if not math.isnan(value)}
        yield from _keys(**{trial.name: {"status": truth.status.value, "faults": truth.faults, **known}})


def _keys(**values: object) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in values.items()]


def _table(title: str, /, **values: object) -> list[str]:
    return ["", f"[{title}]", *_keys(**values)]


def _toml(value: object) -> str:
    """Return a TOML literal of a string, number, boolean, list or (inline) table; floats to 12 digits."""
    if isinstance(value, float):
        return repr(float(f"{value:.12g}"))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_keys(**value)) + " }"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return json.dumps(value, ensure_ascii=False)  # of these, TOML is written as JSON is
