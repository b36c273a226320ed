"""Make the weights of the picker again: draw recordings, train, set the temperature, write weights and model card.

`python -m ropefric.training [--out FOLDER] [--jobs 2]` writes `picker.npz` and `picker.md`. It learns from
drawn recordings and three rigs. The fourth rig is left for the temperature, together with other draws of the second,
and for the check. It needs the extra `train`; nothing else in ropefric imports it.
"""

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from math import isfinite, log, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

try:
    import torch
    from torch import nn
except ModuleNotFoundError as error:
    missing = "ropefric.training needs PyTorch; install it with: pip install 'ropefric[train]'"
    found = SystemExit(missing) if __name__ == "__main__" else ModuleNotFoundError(missing, name="torch")
    raise found from error

from ropefric.arrays import FloatArray, IntArray, median
from ropefric.rig.bench import Bench, RecordingTruth
from ropefric.rig.further import Rig, chains, contacts, pulls
from ropefric.rig.recording import FAULTS, simulate_recording
from ropefric.rig.sampling import DAMAGED, Samples, damaged_state, maybe
from ropefric.rig.stories import LabelledRecording, draw_recording, draw_recordings
from ropefric.rig.strangers import FAMILIES, Recording, recordings
from ropefric.traces import decision, picker
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.calibration import Calibration
from ropefric.traces.clock import mend_clock
from ropefric.traces.picker import BINS, REASONS, State, closer, forward, seen
from ropefric.traces.segments import MIN_SAMPLES, prepare
from ropefric.traces.trace import ForceTrace

SEED, DRAWN, STEPS = 21, 36_000, 7_000
BATCH, RATE, DECAY = 64, 3e-3, 1e-3
BLUR_BINS, SMOOTHING = 0.8, 0.03
"""Standard deviation in bins over which a label is spread; fraction of it that all answers share."""
STATES = 0.3
"""Weight of the states of the bins against the break-away."""
ELSEWHERE = 0.35
"""How often the closer look is somewhere else than at the break-away."""
PIECE, UNKNOWN = 500, 255
"""Recordings drawn at a time; the state of bins of which none is known, as of all recordings but the drawn ones."""
LEFT_OUT = 777
"""Seed of recordings that nothing is trained on."""
UNSEEN = "fourth rig, of which nothing was trained on"
TEMPERATURES = (0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5)
RARER = {Status.NO_BREAKAWAY: 0.5, Status.NO_PEAK: 0.5}
"""How much rarer recordings of a campaign are, without a break-away or a peak, than drawn ones that are learnt from."""
RIGHT, NEAR = 0.02, 0.01
"""Largest error of a force that is right, as a part of it; of a time, as a part of the recording."""


class Lesson(NamedTuple):
    """The input of the network, the bin of the break-away or BINS + the number of the reason, the state of every bin."""

    channels: FloatArray
    answer: float
    states: IntArray


def _lesson(
    time_s: FloatArray, force_N: FloatArray, state: IntArray, answer_s: float, reason: Status
) -> Lesson:
    channels, edges_s = seen(time_s, force_N)
    middle_s = 0.5 * (edges_s[1:] + edges_s[:-1])
    states = state[np.minimum(np.searchsorted(time_s, middle_s), state.size - 1)]
    if isfinite(answer_s):
        answer = min((answer_s - edges_s[0]) / (edges_s[1] - edges_s[0]), BINS - 0.001)
    else:
        answer = float(BINS + REASONS.index(reason))
    return Lesson(channels, answer, states)


def lessons_of(one: LabelledRecording, rng: np.random.Generator) -> Iterator[Lesson]:
    """Yield the lesson of a whole recording and that of a closer look at a part of it."""
    prepared = prepare(ForceTrace(time_s=one.time_s, force_N=one.force_N), PickSettings())
    if prepared is None or (not isfinite(one.breakaway_s) and one.status not in REASONS):
        return
    time_s, force_N, state = prepared.time_s, prepared.force_N, one.state
    whole = _lesson(time_s, force_N, state, one.breakaway_s, one.status)
    yield whole
    edges_s = np.linspace(time_s[0], time_s[-1], BINS + 1)
    is_there = isfinite(one.breakaway_s) and rng.random() > ELSEWHERE
    if is_damaged := one.status is Status.DOUBTFUL:
        around = int(np.argmax(whole.states == State.DAMAGED))
    else:
        around = int(whole.answer) if is_there else _somewhere(whole.states, rng)
    first_s, last_s = closer(around, whole.states, edges_s)
    wide_s = (last_s - first_s) * float(np.exp(0.3 * rng.standard_normal()))
    middle_s = 0.5 * (first_s + last_s) + 0.15 * wide_s * rng.standard_normal()
    part = slice(*np.searchsorted(time_s, (middle_s - 0.5 * wide_s, middle_s + 0.5 * wide_s)))
    within_s = time_s[part]
    if within_s.size < MIN_SAMPLES or (is_damaged and np.unique(state[part] == State.DAMAGED).size < 2):
        return
    holds = within_s[0] < one.breakaway_s < within_s[-1]
    reason = one.status
    if not holds and isfinite(one.breakaway_s):
        slid = within_s[0] >= one.breakaway_s
        if slid and state[part][0] not in {State.SLIP, State.SLIDING}:
            return  # a tooth that is loaded looks like a pull
        reason = Status.NO_PEAK if slid else Status.NO_BREAKAWAY
    yield _lesson(within_s, force_N[part], state[part], one.breakaway_s if holds else np.nan, reason)


def _somewhere(states: IntArray, rng: np.random.Generator) -> int:
    """Return a bin in which one state ends and another begins, or any."""
    ends = np.flatnonzero(np.diff(states))
    return int(rng.choice(ends)) if ends.size and rng.random() < 0.8 else int(rng.integers(BINS))


Labelled = Iterator[tuple[LabelledRecording, np.random.Generator]]


def _perhaps_damaged(one: LabelledRecording, rng: np.random.Generator) -> LabelledRecording:
    """Return a recording of a rig, now and then with a file that is damaged during the pull."""
    if not maybe(rng, DAMAGED) or one.force_N.size <= 2 * MIN_SAMPLES:
        return one
    step_s, rng_of_file = float(median(np.diff(one.time_s))), np.random.default_rng(rng.integers(2**63))
    time_s = np.arange(float(one.force_N.size)) * step_s
    file = Samples(rng_of_file, time_s, one.force_N, one.force_N.copy(), noise=0.0)
    if (state := damaged_state(file, one.state)) is None:
        return one
    made: Any = {"time_s": file.time_s, "force_N": file.force, "state": state, "status": Status.DOUBTFUL}
    return replace(one, **made, breakaway_s=nan, peak_N=nan)


def _drawn(seed: int, piece: int) -> Labelled:
    for n in range(piece * PIECE, (piece + 1) * PIECE):
        rng = np.random.default_rng([seed, n])
        yield draw_recording(rng), rng


def _of_first_rig(seed: int, piece: int) -> Labelled:
    for n in range(piece * PIECE, (piece + 1) * PIECE):
        rng = np.random.default_rng([seed, n, 1])
        yield _perhaps_damaged(labelled(*rig_recording(rng)), rng), rng


def _of_second_rig(seed: int, piece: int) -> Labelled:
    made = recordings(10_000 * seed + piece, per_family=PIECE // len(FAMILIES))
    return _each_with_its_own(map(labelled_stranger, made), seed, piece, 2)


def _of_third_rig(seed: int, piece: int) -> Labelled:
    return _each_with_its_own(pulls(np.random.default_rng([seed, piece, 3]), PIECE, chains), seed, piece, 3)


def _each_with_its_own(made: Iterable[LabelledRecording], seed: int, piece: int, rig: int) -> Labelled:
    """Yield the recordings of a rig, perhaps damaged, each with a generator of its own."""
    for n, one in enumerate(made):
        rng = np.random.default_rng([seed, piece, n, rig])
        yield _perhaps_damaged(one, rng), rng


SOURCES = {
    "drawn": (1, _drawn), "first rig": (10, _of_first_rig), "second rig": (3, _of_second_rig),
    "third rig": (10, _of_third_rig),
}  # fmt: skip
"""Recordings to learn from: one for how many drawn ones, and how a piece of them is drawn."""


def _piece(task: tuple[str, int, int]) -> tuple[Any, Any, Any]:
    """Return the lessons of a piece of a source as arrays."""
    name, seed, number = task
    made = [lesson for one, rng in SOURCES[name][1](seed, number) for lesson in lessons_of(one, rng)]
    states = np.array([lesson.states for lesson in made], dtype=np.uint8)
    channels = np.array([lesson.channels for lesson in made], dtype=np.float16)
    answers = np.array([lesson.answer for lesson in made], dtype=np.float32)
    return channels, answers, states if name == "drawn" else np.full_like(states, UNKNOWN)


def draw_lessons(seed: int, count: int, jobs: int = 1) -> tuple[Any, Any, Any]:
    """Return channels, answers and states of the lessons of all sources; `jobs` does not change them.

    `count` recordings are drawn piece by piece, and of each rig its part of that.
    """
    tasks = [
        (name, seed, number)
        for name, (one_in, _) in SOURCES.items()
        for number in range(-(-count // (one_in * PIECE)))
    ]
    with ProcessPoolExecutor(jobs) as pool:
        pieces = list(pool.map(_piece, tasks))
    return tuple(np.concatenate([piece[k] for piece in pieces]) for k in range(3))  # type: ignore[return-value]


def rig_recording(rng: np.random.Generator) -> tuple[ForceTrace, RecordingTruth]:
    """Return a recording of the first rig as the picker gets it, with a fault that a recording survives, or none."""
    usable = [one.name for one in FAULTS.values() if not one.on_bytes]
    bench, name = Bench(), str(rng.choice(["", *usable]))
    lift_N = float(np.exp(rng.uniform(log(60.0), log(700.0))))
    given: Any = {"lift_force_N": lift_N, "end_tension_N": lift_N * rng.uniform(0.1, 0.6), "rng": rng}
    one = simulate_recording(bench, **given, faults=[name] if name else [])
    counts = np.where(np.isnan(one.counts), -1, one.counts).astype(np.int64)
    calibration = Calibration(cell=bench.cell_named(one.truth.cell), adc=bench.adc)
    if counts.size >= MIN_SAMPLES:
        calibration, _ = calibration.with_tare(counts[: max(20, counts.size // 20)])
    force_N, saturation = calibration.apply(counts)
    keep, time_s, _ = mend_clock(one.time_s, [force_N])
    trace = ForceTrace(
        time_s=time_s, force_N=force_N[keep], saturation=saturation, name=name or "nothing wrong"
    )
    return trace, one.truth


def labelled(trace: ForceTrace, truth: RecordingTruth) -> LabelledRecording:
    """Return a recording of the first rig with its truth; its phases serve for states."""
    names = {"idle": State.REST, "loading": State.LOADING, "sliding": State.SLIDING, "held": State.HELD}
    ends_s, states = [phase.end_s for phase in truth.phases], [*truth.phases, *truth.phases[-1:]]
    state = np.array([names.get(phase.name, State.LET_DOWN) for phase in states] or [State.REST])
    numbers = truth.breakaway_time_s, truth.lift_force_N
    return _with_truth(trace, state[np.searchsorted(ends_s, trace.time_s)], truth.status, *numbers)


def labelled_stranger(one: Recording) -> LabelledRecording:
    """Return a recording of the second rig with its truth: at rest, loading until the top, then sliding."""
    trace, truth = one.trace(), one.truth
    state = np.where(trace.time_s < one.loaded_s, State.REST, State.LOADING)
    if truth.status is Status.OK:
        state[trace.time_s > truth.time_s] = State.SLIDING
    return _with_truth(trace, state, truth.status, truth.time_s, truth.peak_N)


def _with_truth(
    trace: ForceTrace, state: IntArray, status: Status, at_s: float, peak_N: float
) -> LabelledRecording:
    """Return the samples of a trace that are there, with their states; time and force only of a break-away."""
    here, is_seen = np.isfinite(trace.force_N), status is Status.OK
    return LabelledRecording(
        kind=trace.name, time_s=trace.time_s[here], force_N=trace.force_N[here], state=state[here], status=status,
        breakaway_s=at_s if is_seen else nan, peak_N=peak_N if is_seen else nan,
    )  # fmt: skip


class Network(nn.Module):
    """The network of `picker.forward`, as what can be trained: every layer with its normalisation."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleDict()
        channels = torch.zeros(2, picker.CHANNELS, BINS)
        forward(channels, self._added, _twice, _beside)
        self.pool, self.reason = (
            nn.Linear(2 * picker.WIDTHS[-1], picker.POOLED),
            nn.Linear(picker.POOLED, len(REASONS)),
        )

    def _added(
        self, name: str, values: Any, width: int, reach: int, every: int = 1, *, is_last: bool = False
    ) -> Any:
        convolve = nn.Conv1d(values.shape[1], width, reach, every, reach // 2, bias=is_last)
        self.layers[name] = convolve if is_last else nn.Sequential(convolve, nn.BatchNorm1d(width))
        return self._layer(name, values, is_last=is_last)

    def _layer(self, name: str, values: Any, *_: int, is_last: bool = False, **__: int) -> Any:
        found = self.layers[name](values)
        return found if is_last else torch.relu(found)

    def forward(self, channels: Any) -> tuple[Any, Any]:
        """Return the logits of all answers, and of the states of all bins."""
        bins, deepest = forward(channels, self._layer, _twice, _beside)
        pooled = torch.cat([deepest.mean(dim=2), deepest.amax(dim=2)], dim=1)
        reasons = self.reason(torch.relu(self.pool(pooled)))
        return torch.cat([bins[:, 0], reasons], dim=1), bins[:, 1:]

    def weights(self) -> dict[str, Any]:
        """Return the weights as `picker.look` wants them: normalisation folded in, kernels as matrices, rounded."""
        found: dict[str, Any] = {}
        for name, layer in self.layers.items():
            convolve, norm = (layer, None) if isinstance(layer, nn.Conv1d) else tuple(layer)
            kernel = convolve.weight.detach().double()
            bias = convolve.bias.detach().double() if norm is None else torch.zeros(kernel.shape[0]).double()
            if norm is not None:
                scale = norm.weight.detach().double() / torch.sqrt(norm.running_var.double() + norm.eps)
                kernel = kernel * scale[:, None, None]
                bias = norm.bias.detach().double() - norm.running_mean.double() * scale
            # (out, in, reach) to (reach * in, out), as windows of bins are laid out.
            found[f"{name}.w"] = kernel.permute(2, 1, 0).reshape(-1, kernel.shape[0])
            found[f"{name}.b"] = bias
        for name, dense in (("pool", self.pool), ("reason", self.reason)):
            found[f"{name}.w"] = dense.weight.detach().double().T[None]
            found[f"{name}.b"] = dense.bias.detach().double()
        grid = picker.WEIGHT_GRID
        return {name: np.rint(values.numpy() * grid) / grid for name, values in found.items()}


def _twice(values: Any) -> Any:
    return values.repeat_interleave(2, dim=2)


def _beside(left: Any, right: Any) -> Any:
    return torch.cat([left, right], dim=1)


def _targets(answers: Any) -> Any:
    """Return the share of every answer: spread over neighbouring bins, a little over all."""
    bins = torch.arange(BINS) + 0.5
    near = torch.exp(-0.5 * ((bins[None] - answers[:, None]) / BLUR_BINS) ** 2)
    place = (answers < BINS).float()[:, None] * near / near.sum(dim=1, keepdim=True).clamp_min(1e-9)
    numbers = BINS + torch.arange(len(REASONS))
    reasons = (answers[:, None] == numbers[None]).float()
    wanted = torch.cat([place, reasons], dim=1)
    return (1.0 - SMOOTHING) * wanted + SMOOTHING / wanted.shape[1]


def train(
    lessons: tuple[Any, Any, Any],
    steps: int,
    seed: int,
    say: Callable[[str], object] = lambda _: None,
) -> Network:
    """Return the network that has learnt from lessons; its layers calculate in bfloat16."""
    torch.manual_seed(seed)
    rng = np.random.default_rng([seed, 1])
    network = Network()
    channels, answers, states = map(torch.from_numpy, lessons)
    optimizer = torch.optim.AdamW(network.parameters(), RATE, betas=(0.9, 0.98), weight_decay=DECAY)
    plan = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=steps, pct_start=0.1)
    order, mean_loss = np.zeros(0, dtype=np.intp), torch.zeros(())
    for step in range(steps):
        if order.size < BATCH:
            order = rng.permutation(len(answers))
        chosen, order = torch.from_numpy(np.sort(order[:BATCH])), order[BATCH:]
        batch = channels[chosen].float().transpose(1, 2).contiguous()
        shift = rng.standard_normal((len(batch), 1)) * 0.01 * (rng.random((len(batch), 1)) < 0.3)
        batch[:, 0] += torch.from_numpy(shift.astype(np.float32))
        with torch.autocast("cpu", torch.bfloat16):
            places, kinds = network(batch)
        places, kinds = places.float(), kinds.float()
        wanted = _targets(answers[chosen])
        loss = -(wanted * torch.log_softmax(places, dim=1)).sum(dim=1).mean()
        loss = loss + STATES * nn.functional.cross_entropy(kinds, states[chosen].long(), ignore_index=UNKNOWN)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        plan.step()
        mean_loss += (loss.detach() - mean_loss) * max(0.01, 1.0 / (step + 1))
        if step % 100 == 99:
            say(f"step {step + 1} of {steps}: loss {float(mean_loss):.3f}")
    return network.eval()


class Known(NamedTuple):
    """A recording that is not trained on, and its truth."""

    kind: str
    trace: ForceTrace
    status: Status
    peak_N: float
    at_s: float


def _known(one: LabelledRecording) -> Known:
    trace = ForceTrace(time_s=one.time_s, force_N=one.force_N - one.zero_N, name=one.kind)
    return Known(one.kind, trace, one.status, one.peak_N, one.breakaway_s)


def of_the_first_rig(count: int) -> Iterator[Known]:
    """Yield recordings of the virtual rig of a seed of their own."""
    for number in range(count):
        trace, truth = rig_recording(np.random.default_rng([LEFT_OUT, number, 1]))
        yield Known(trace.name, trace, truth.status, truth.lift_force_N, truth.breakaway_time_s)


def of_the_second_rig(per_family: int, seed: int = LEFT_OUT) -> Iterator[Known]:
    """Yield recordings of the rigs of `rig.strangers`."""
    for one in recordings(seed, per_family=per_family):
        truth = one.truth
        yield Known(f"{one.tier}: {one.family}", one.trace(), truth.status, truth.peak_N, truth.time_s)


def of_further_rig(rig: Rig, count: int, seed: int = LEFT_OUT) -> Iterator[Known]:
    """Yield recordings of the third or the fourth rig."""
    yield from map(_known, pulls(np.random.default_rng(seed), count, rig))


def answers_of(one: Known, weights: picker.Weights) -> dict[tuple[Status, float], float]:
    """Return how likely each answer is: a time, with the forces within a hundredth of its own, or a reason for none."""
    prepared = prepare(one.trace, PickSettings())
    if prepared is None:
        return {}
    found, time_s = decision.judge(prepared, weights), prepared.blocks.time_s
    answers = {(reason, nan): share for reason, share in found.reasons.items()}
    return answers | {
        (Status.OK, float(time_s[top.block])): decision.share_near(found, top) for top in found.candidates
    }


def is_right(one: Known, answer: tuple[Status, float]) -> bool:
    """Return whether an answer is true; by its time, for the zero of the force is none of the network's."""
    status, at_s = answer
    near_s = NEAR * float(one.trace.time_s[-1] - one.trace.time_s[0])
    return status is one.status and (status is not Status.OK or abs(at_s - one.at_s) < near_s)


def stated_and_right(ones: Iterable[Known], weights: picker.Weights) -> tuple[float, float]:
    """Return the mean probability of the most probable answers, and the share of them that are right."""
    answers = [(one, found) for one in ones if (found := answers_of(one, weights))]
    best = [(one, *max(found.items(), key=lambda answer: answer[1])) for one, found in answers]
    stated, right = np.mean([(share, is_right(one, answer)) for one, answer, share in best], axis=0)
    return float(stated), float(right)


def card(sets: Mapping[str, list[Known]], weights: picker.Weights) -> str:
    """Return the model card: how the picker does on recordings it was not trained on, by set and by kind."""
    lines = [
        "| recordings | number | right | wrong though `ok` | doubtful | another reason |",
        "|---|---|---|---|---|---|",
    ]
    for name, ones in sets.items():
        kinds: dict[str, Counter[str]] = defaultdict(Counter)
        for one in ones:
            settings = PickSettings(rest="unknown" if name in {"first rig", "second rig"} else "pretension")
            prepared = prepare(one.trace, settings)
            if prepared is None:
                continue
            found = decision.pick_prepared(one.trace, prepared, settings, weights)
            kinds[one.kind][_fate(one, found.status, found.peak_N)] += 1
        lines += [_row(f"**{name}**", sum(kinds.values(), Counter()))]
        lines += [
            _row(kind, counts) for kind, counts in sorted(kinds.items()) if counts["right"] < counts.total()
        ]
    stated, right = stated_and_right(sets[UNSEEN], weights)
    said = f"Of the {UNSEEN}: {stated:.3f} stated on average, {right:.3f} of the answers right."
    return "\n".join([*lines, "", said, ""])


def _fate(one: Known, status: Status, peak_N: float) -> str:
    if status is Status.OK:
        return "right" if one.status is Status.OK and abs(peak_N / one.peak_N - 1.0) <= RIGHT else "wrong"
    return "right" if status is one.status else "doubtful" if status is Status.DOUBTFUL else "other"


def _row(name: str, counts: Mapping[str, int]) -> str:
    total = sum(counts.values())
    parts = (
        f"{100.0 * counts.get(word, 0) / total:.1f} %" for word in ("right", "wrong", "doubtful", "other")
    )
    return f"| {name} | {total} | {' | '.join(parts)} |"


def main() -> None:
    """Draw, train, set the temperature, and write weights and model card into a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=picker.STORED.parent)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    torch.set_num_threads(given.jobs)
    say = partial(print, flush=True)
    lessons = draw_lessons(SEED, DRAWN, given.jobs)
    say(f"{len(lessons[1])} lessons of {DRAWN} drawn recordings and their parts of three rigs")
    write(given.out, train(lessons, STEPS, SEED, say).weights(), say)


def write(folder: Path, weights: dict[str, Any], say: Callable[[str], object]) -> None:
    """Set the temperature of trained weights; write them, and how they do, into a folder."""
    stored: dict[str, Any] = {name: np.asarray(values, dtype=np.float16) for name, values in weights.items()}
    stored["rarer"] = np.log([RARER.get(reason, 1.0) for reason in REASONS])
    other = [*of_the_second_rig(6, LEFT_OUT + 1), *of_further_rig(contacts, 400, LEFT_OUT + 1)]
    path = folder / "picker.npz"
    gaps = {}
    for one in TEMPERATURES:
        stated, right = stated_and_right(other, picker.multiplied({**stored, "temperature": one}))
        gaps[one] = abs(stated - right)
        say(f"temperature {one:g}: {stated:.3f} stated, {right:.3f} right")
    stored["temperature"] = np.float64(min(gaps, key=lambda one: gaps[one]))
    np.savez(path, **stored)
    sets = {
        "drawn": list(map(_known, draw_recordings(LEFT_OUT, 1000))),
        "first rig": list(of_the_first_rig(400)),
        "second rig": list(of_the_second_rig(12)),
        "third rig": list(of_further_rig(chains, 250)),
        UNSEEN: list(of_further_rig(contacts, 500)),
    }
    (folder / "picker.md").write_text(card(sets, picker.multiplied(stored)), encoding="utf-8")


if __name__ == "__main__":
    main()
