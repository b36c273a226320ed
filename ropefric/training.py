"""Make the weights of the picker again: draw recordings, train, set the temperature, write weights and model card.

`python -m ropefric.training [--seed 1] [--recordings 40000] [--steps 6000] [--out ropefric/traces/picker.npz]`. It needs
the extra `train`; nothing else in ropefric imports it.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import nn

from ropefric.arrays import FloatArray, IntArray
from ropefric.rig.stories import LabelledRecording, draw_recording
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.picker import (
    BINS,
    CHANNELS,
    POOLED,
    REASONS,
    WEIGHT_GRID,
    WIDTHS,
    State,
    closer,
    forward,
    seen,
)
from ropefric.traces.segments import prepare
from ropefric.traces.trace import ForceTrace

BATCH, RATE, DECAY = 64, 3e-3, 1e-3
BLUR_BINS, SMOOTHING = 0.8, 0.03
"""A label is spread over so many bins (standard deviation), and a part of it over all answers alike."""
STATES = 0.3
"""What the states of the bins count against the break-away."""
ELSEWHERE = 0.35
"""How often the closer look is somewhere else than at the break-away."""
PIECE = 500


class Lesson(NamedTuple):
    """What the network sees, the bin of the break-away or BINS + the number of the reason, the state of every bin."""

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
    if prepared is None:
        return
    time_s, force_N, state = prepared.time_s, prepared.force_N, one.state
    whole = _lesson(time_s, force_N, state, one.breakaway_s, one.status)
    yield whole
    edges_s = np.linspace(time_s[0], time_s[-1], BINS + 1)
    is_there = isfinite(one.breakaway_s) and rng.random() > ELSEWHERE
    around = int(whole.answer) if is_there else _somewhere(whole.states, rng)
    first_s, last_s = closer(time_s, around, whole.states, edges_s)
    wide_s = (last_s - first_s) * float(np.exp(0.3 * rng.standard_normal()))
    middle_s = 0.5 * (first_s + last_s) + 0.15 * wide_s * rng.standard_normal()
    part = slice(*np.searchsorted(time_s, (middle_s - 0.5 * wide_s, middle_s + 0.5 * wide_s)))
    within_s = time_s[part]
    if within_s.size < 50:
        return
    holds = within_s[0] < one.breakaway_s < within_s[-1]
    reason = one.status
    if not holds and isfinite(one.breakaway_s):
        reason = Status.NO_PEAK if state[part][0] in {State.SLIP, State.SLIDING} else Status.NO_BREAKAWAY
    yield _lesson(within_s, force_N[part], state[part], one.breakaway_s if holds else np.nan, reason)


def _somewhere(states: IntArray, rng: np.random.Generator) -> int:
    """Return a bin in which one state ends and another begins, or any."""
    ends = np.flatnonzero(np.diff(states))
    return int(rng.choice(ends)) if ends.size and rng.random() < 0.8 else int(rng.integers(BINS))


def _piece(task: tuple[int, int]) -> tuple[Any, Any, Any]:
    """Return the lessons of a piece of all recordings, as arrays."""
    seed, number = task
    made = []
    for n in range(number * PIECE, (number + 1) * PIECE):
        rng = np.random.default_rng([seed, n])
        made.extend(lessons_of(draw_recording(rng), rng))
    channels = np.array([lesson.channels for lesson in made], dtype=np.float16)
    answers = np.array([lesson.answer for lesson in made], dtype=np.float32)
    return channels, answers, np.array([lesson.states for lesson in made], dtype=np.uint8)


def draw_lessons(seed: int, recordings: int, jobs: int = 1) -> tuple[Any, Any, Any]:
    """Return channels, answers and states of the lessons of so many recordings; the same ones however many jobs."""
    tasks = [(seed, number) for number in range(-(-recordings // PIECE))]
    with ProcessPoolExecutor(jobs) as pool:
        pieces = list(pool.map(_piece, tasks))
    return tuple(np.concatenate([piece[k] for piece in pieces]) for k in range(3))  # type: ignore[return-value]


class Network(nn.Module):
    """The network of `picker.forward`, as what can be trained: every layer with its normalisation."""

    def __init__(self) -> None:
        super().__init__()
        self.layers = nn.ModuleDict()
        channels = torch.zeros(2, CHANNELS, BINS)
        forward(channels, self._added, _twice, _beside)
        self.pool, self.reason = nn.Linear(2 * WIDTHS[-1], POOLED), nn.Linear(POOLED, len(REASONS))

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
        return {name: np.rint(values.numpy() * WEIGHT_GRID) / WEIGHT_GRID for name, values in found.items()}


def _twice(values: Any) -> Any:
    return values.repeat_interleave(2, dim=2)


def _beside(left: Any, right: Any) -> Any:
    return torch.cat([left, right], dim=1)


def _targets(answers: Any) -> Any:
    """Return the share of every answer: spread over neighbouring bins, a little over all."""
    bins = torch.arange(BINS) + 0.5
    near = torch.exp(-0.5 * ((bins[None] - answers[:, None]) / BLUR_BINS) ** 2)
    place = (answers < BINS).float()[:, None] * near / near.sum(dim=1, keepdim=True).clamp_min(1e-9)
    reasons = (answers[:, None] == BINS + torch.arange(len(REASONS))[None]).float()
    wanted = torch.cat([place, reasons], dim=1)
    return (1.0 - SMOOTHING) * wanted + SMOOTHING / wanted.shape[1]


def train(
    lessons: tuple[Any, Any, Any], steps: int, seed: int, say: Callable[[str], object] = lambda _: None
) -> Network:
    """Return the network that has learnt from lessons."""
    torch.manual_seed(seed)
    rng = np.random.default_rng([seed, 1])
    network = Network()
    channels, answers, states = lessons
    optimizer = torch.optim.AdamW(network.parameters(), RATE, betas=(0.9, 0.98), weight_decay=DECAY)
    plan = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=steps, pct_start=0.1)
    order, mean_loss = np.zeros(0, dtype=np.intp), 0.0
    for step in range(steps):
        if order.size < BATCH:
            order = rng.permutation(len(answers))
        chosen, order = np.sort(order[:BATCH]), order[BATCH:]
        batch = torch.from_numpy(channels[chosen].astype(np.float32)).transpose(1, 2).contiguous()
        shift = rng.standard_normal((BATCH, 1)) * 0.01 * (rng.random((BATCH, 1)) < 0.3)
        batch[:, 0] += torch.from_numpy(shift.astype(np.float32))
        places, kinds = network(batch)
        wanted = _targets(torch.from_numpy(answers[chosen]))
        loss = -(wanted * torch.log_softmax(places, dim=1)).sum(dim=1).mean()
        loss = loss + STATES * nn.functional.cross_entropy(
            kinds, torch.from_numpy(states[chosen].astype(np.int64))
        )
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        plan.step()
        mean_loss += (float(loss.detach()) - mean_loss) * max(0.01, 1.0 / (step + 1))
        if step % 100 == 99:
            say(f"step {step + 1} of {steps}: loss {mean_loss:.3f}")
    return network.eval()
