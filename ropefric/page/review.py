"""A campaign under review: its trials, the decisions beside its list, and their effect on the answer."""

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from functools import cached_property, partial
from math import ceil, degrees, isclose, isfinite, log10
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError, RopefricError, known_error
from ropefric.files.disk import read_file, take_back
from ropefric.files.plain_text import GIVEN_DIGITS, rounded_tree
from ropefric.friction.laws import ALL_LAWS
from ropefric.page.work import REPORT_WITH, Step, Work
from ropefric.pipeline import CampaignAnswer, CampaignRun, answer_campaign
from ropefric.traces.breakaway import PickSettings, Status
from ropefric.traces.decision import judge
from ropefric.traces.readers import read_recordings
from ropefric.traces.segments import prepare
from ropefric.traces.smoothing import smooth
from ropefric.traces.trace import ForceTrace
from ropefric.trials import numbers
from ropefric.trials import result as results
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import Campaign, TrialSpec
from ropefric.trials.decisions import Decision, add_decisions, content_of, decision_of
from ropefric.trials.extract import ByRow, blocks_of, extract_rows, in_list_order, tared_trace
from ropefric.trials.result import TrialResult
from ropefric.trials.table import table_of_extraction

Curves = tuple[FloatArray, FloatArray, FloatArray | None]
"""Time, force and smoothed force of a recording, samples that are missing left out."""
OWN_WORDS = "review: "
"""Begin of a reason that the page has written."""
UNREADABLE = "RF101"
"""Code of a recording that could not be read, perhaps because its reading process ended."""
FEW = 20
"""Largest number of recordings, all of them read before, that are read in this process."""
STEADY = 1e-5
"""Part of a recording within which no finger is steady."""
_NO_TEXT = {"exclude": "an exclusion needs its reason", "comment": "the comment is empty"}

_plain = partial(rounded_tree, digits=GIVEN_DIGITS)


def row_of(trial: TrialResult, condition: str) -> dict[str, Any]:
    """Return what the list of trials shows of one."""
    own = {name: getattr(trial, name) for name in ("file", "outcome", "excluded", "decision", "why", "by")}
    force = {"force_N": trial.measured_N, "std_N": _std_of(trial), "probability": trial.breakaway.probability}
    known = {name: value if isfinite(value) else None for name, value in force.items()}
    return {**own, "condition": condition, "status": trial.breakaway.status.value, **known}


def facts_of(result: TrialResult) -> dict[str, Any]:
    """Return the results and remarks of a trial, without its samples."""
    found = result.breakaway
    tree = {name: getattr(found, name) for name in ("window_s", "detail", "notes")}
    for name in ("phases", "events", "candidates"):
        tree[name] = [asdict(one) for one in getattr(found, name)]
    tree |= {"numbers": numbers.on_page(result), "mu": result.mu}
    tree["advice"] = "" if found.status is Status.OK else found.advice
    tree["problems"] = [f"{one.code}: {one.message}" for one in result.problems]
    return {**_plain(tree), **pick_of(result)}


def pick_of(result: TrialResult) -> dict[str, Any]:
    """Return the force of a trial, its standard uncertainty, and when it was reached."""
    return {"picked": _plain([result.measured_N, _std_of(result), result.breakaway.peak_time_s])}


def repeats_of(one: results.ConditionSummary) -> dict[str, Any]:
    """Return mean, scatter and number of the repeats of a condition, and those that the rule rejects."""
    numbers: dict[str, Any] = rounded_tree({"mean_N": one.mean_kept_N, "std_N": one.std_kept_N})
    return numbers | {"n_kept": one.n_kept, "n": one.n_recorded, "rejected": list(one.rejected)}


def _std_of(trial: TrialResult) -> float:
    return trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N


def drawn_of(campaign: Campaign, spec: TrialSpec, result: TrialResult) -> tuple[Curves, dict[str, Any]]:
    """Return a recording as it was picked from, calibrated, tared and smoothed; and where the break-away may be."""
    raws = read_recordings(spec.path, campaign.profile, shown_as=spec.file)
    raw = blocks_of(replace(spec, sample=result.sample), raws)[0]
    trace, _ = tared_trace(campaign, spec, raw)
    window_s, present = result.breakaway.window_s, np.isfinite(trace.force_N)
    smoothed_N = smooth(trace, window_s).force_N[present] if isfinite(window_s) else None
    curves = trace.time_s[present], trace.force_N[present], smoothed_N
    return curves, likely_in(campaign, spec, trace)


def likely_in(campaign: Campaign, spec: TrialSpec, trace: ForceTrace) -> dict[str, Any]:
    """Return in which stretches of time the break-away may be and how likely, and the reasons why there may be none.

    Without any where something else than probabilities decides.
    """
    protocol = campaign.protocol
    decides = (protocol.name, protocol.ending, protocol.picker) == ("breakaway", "sliding", "trained")
    prepared = prepare(trace, PickSettings(start_s=spec.start_s, stop_s=spec.stop_s)) if decides else None
    if prepared is None:
        return {"places": [], "reasons": []}
    found = judge(prepared)
    places = [[one.first_s, one.last_s, one.probability] for one in found.candidates]
    reasons = [[reason.value, probability] for reason, probability in found.reasons.items()]
    return {"places": _plain(places), "reasons": reasons}


def decimated(curves: Curves, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
    """Return time, lowest, highest and smoothed force for each column of a picture that has a sample.

    A column holds all samples in its stretch of time, so no peak is lost; where there are fewer samples than
    two in a column, each is drawn.
    """
    time_s, force_N, smoothed_N = curves
    if not time_s.size:
        raise DataError("no sample is there", fix="exclude the trial")
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    start_s = start_s if isfinite(start_s) else begin_s
    stop_s = stop_s if isfinite(stop_s) else end_s
    columns = min(max(columns, 10), 5000)
    if not start_s < stop_s:
        stop_s = start_s + 1e-9 * max(1.0, abs(start_s))
    first, last = int(np.searchsorted(time_s, start_s, "left")), int(np.searchsorted(time_s, stop_s, "right"))
    if last - first <= 2 * columns:  # each sample, and one beyond each end
        first, last = max(0, first - 1), min(last + 1, time_s.size)
        starts = np.arange(last - first)
    else:
        column = ((time_s[first:last] - start_s) * (columns / (stop_s - start_s))).astype(np.int64)
        starts = np.flatnonzero(np.diff(np.minimum(column, columns - 1), prepend=-1))
    time_s, force_N = time_s[first:last], force_N[first:last]
    ends = np.append(starts[1:], last - first) - 1
    drawn = [0.5 * (time_s[starts] + time_s[ends])]
    drawn += [np.minimum.reduceat(force_N, starts), np.maximum.reduceat(force_N, starts)]
    if smoothed_N is not None:
        drawn.append(smoothed_N[first + (starts + ends + 1) // 2])
    names = ("time_s", "low_N", "high_N", "smoothed_N")
    tree = {name: _plain(values.tolist()) for name, values in zip(names, drawn, strict=False)}
    return {"start_s": start_s, "stop_s": stop_s, "begin_s": begin_s, "end_s": end_s} | tree


Stamps = Mapping[Path, tuple[int, ...]]
"""Time of change and size of each recording; nothing of one that is not there."""


@dataclass(frozen=True, eq=False)
class _State:
    """A campaign as its files state it, the results of every row of its list, and the results of all."""

    content: tuple[bytes, ...]
    stamps: Stamps
    campaign: Campaign
    by_row: ByRow
    extraction: results.Extraction
    specs: Mapping[str, TrialSpec]

    def kept_in(self, campaign: Campaign, stamps: Stamps) -> ByRow:
        """Return the results that hold in a changed campaign: same rows but for their lines, recordings, settings."""
        if self.campaign.settings_fingerprint() != campaign.settings_fingerprint():
            return {}
        were, kept = {row.trial: row for row in self.campaign.trials}, dict[str, tuple[TrialResult, ...]]()
        for row in campaign.trials:
            was = were.get(row.trial)
            is_same = was is not None and replace(row, line=was.line) == was
            if is_same and stamps[row.path] == self.stamps.get(row.path):
                kept[row.trial] = self.by_row[row.trial]
        return kept

    def has_read(self, row: TrialSpec, stamps: Stamps) -> bool:
        """Return whether another process read the recording of a row to its end, as the recording is now."""
        found = self.by_row.get(row.trial, ())
        is_same = self.stamps.get(row.path) == stamps[row.path]
        return is_same and bool(found) and all(map(_is_readable, found))

    @cached_property
    def trials(self) -> dict[str, TrialResult]:
        """Return the result of each trial."""
        return {one.trial: one for one in self.extraction.trials}

    @cached_property
    def rows(self) -> dict[str, dict[str, Any]]:
        """Return the row of each trial in the list."""
        conditions = self.extraction.conditions
        words = {name: self.words_of(one) for one in conditions for name in one.trials}
        return {name: row_of(trial, words[name]) for name, trial in self.trials.items()}

    def words_of(self, one: results.ConditionSummary) -> str:
        """Return the settings of a condition in words, as short as a narrow list needs them."""
        slack = self.campaign.protocol.needs_lift_force
        known = f"F_A {one.lift_force_N:.4g} N" if slack else f"F_B {one.end_tension_N:.4g} N"
        return f"R {1e3 * one.wheel_radius_m:.4g} mm, {degrees(one.wrap_angle_rad):.4g}°, {known}"

    def condition_of(self, trial: str) -> results.ConditionSummary:
        """Return the condition of a trial."""
        return next(one for one in self.extraction.conditions if trial in one.trials)

    def facts_of(self, trial: str) -> dict[str, Any]:
        """Return the row of a trial, and the numbers of its repeats."""
        return self.rows[trial] | {"repeats": repeats_of(self.condition_of(trial))}


class Review:
    """A campaign under review by one person, in any number of threads.

    Parameters
    ----------
    campaign : Path
        The campaign file.
    by : str
        Who decides.
    law : str
        The law to use, "" for the best.
    jobs : int
        Processes that read the recordings.
    progress : callable, optional
        Called after every recording.
    now : callable, optional
        The clock by which decisions are dated.
    """

    def __init__(
        self,
        campaign: Path,
        *,
        by: str,
        law: str = "",
        jobs: int = 1,
        progress: Step | None = None,
        now: Callable[[], datetime] = lambda: datetime.now().astimezone(),
    ) -> None:
        self.campaign_file, self.by, self.law, self._now = campaign, by, law, now
        self._jobs = jobs
        self._deciding = threading.RLock()  # held while a decision is written and measured
        self.lock = threading.RLock()  # held for a moment, so that nobody who only looks has to wait
        self._drawn: tuple[TrialResult, Curves, dict[str, Any]] | None = None
        self._undo: list[tuple[str, list[Decision]]] = []
        self.n_written = self._number = 0
        self._change: dict[str, Any] | None = None
        self._first: dict[str, Any] | None = None
        self._before: dict[str, Any] | None = None
        self._fit = Work()
        self._state = self._load(None, self._loaded(), progress)
        self._recompute()

    @property
    def campaign(self) -> Campaign:
        """Return the campaign as it was read; its list of trials is never written."""
        return self._state.campaign

    # --- the files ---

    def _loaded(self) -> Campaign:
        return load_campaign(self.campaign_file, missing_recordings="flag")

    def _load(self, before: _State | None, seen: Campaign, progress: Step | None = None) -> _State:
        """Return the campaign as the files of the one seen state it; only what differs from before is extracted."""
        content, campaign = _contents(seen), self._loaded()
        if _contents(campaign) != content:
            raise changed_meanwhile(campaign.trial_list)
        stamps = {path: _stamp(path) for path in dict.fromkeys(row.path for row in campaign.trials)}
        kept = {} if before is None else before.kept_in(campaign, stamps)
        rows = tuple(row for row in campaign.trials if row.trial not in kept)
        trusted = (
            before is not None and len(rows) <= FEW and all(before.has_read(row, stamps) for row in rows)
        )
        of_rows = campaign.model_copy(update={"trials": rows, "warnings": ()})
        by_row = {**kept, **extract_rows(of_rows, jobs=self._jobs, progress=progress, trusted=trusted)}
        placed = in_list_order(campaign, by_row)
        found = results.summarised(campaign, [result for _, result in placed])
        specs = {result.trial: row for row, result in placed}
        return _State(content, stamps, campaign, by_row, results.set_aside_impossible(found, campaign), specs)

    def reload(self, progress: Step | None = None) -> None:
        """Read the changed campaign again; earlier decisions can no longer be undone."""
        before = self._state
        state = self._load(before, self._loaded(), progress)
        with self._deciding, self.lock:
            if self._state is not before:
                raise changed_meanwhile(state.campaign.trial_list)
            self._state = state
            self._undo.clear()
            self._change = None
            self._recompute()

    def decide(
        self, trial: str, action: str, *, pick_s: float | None = None, text: str = ""
    ) -> dict[str, Any]:
        """Write a decision about a trial beside the list, and return its effects.

        Parameters
        ----------
        trial : str
            Its name.
        action : {"pick", "exclude", "comment", "clear"}
            `pick` sets the time of the break-away; `clear` takes back whatever a person decided.
        pick_s : float, optional
            When F_A was reached [s].
        text : str
            The reason, or comment.

        Raises
        ------
        InputError
            If it is no possible decision.
        DataError
            RF153 if somebody else changed the list or the decisions meanwhile; another code if it cannot be written.
            Nothing has changed then.
        """
        with self._deciding:
            was = decision_of(self._spec(trial))
            return self._keep(trial, [(was, self._decided(trial, was, action, pick_s, text.strip()))])

    def switch(self, trial: str, text: str) -> dict[str, Any]:
        """Exclude all trials of a trial's condition for a reason; or, without one, take such a reason back."""
        with self._deciding:
            reason = "" if text else self._spec(trial).exclude
            names = self._state.condition_of(trial).trials
            alike = {spec.trial: decision_of(spec) for spec in map(self._spec, names)}
            changes = [(was, was._replace(exclude=text)) for was in alike.values() if was.exclude == reason]
            return self._keep(trial, changes)

    def _decided(self, trial: str, was: Decision, action: str, pick_s: float | None, text: str) -> Decision:
        """Return the decision that an action makes of the one before."""
        if action in _NO_TEXT and not text:
            raise InputError(_NO_TEXT[action], code="RF121", fix="say in a few words what was seen")
        if action == "pick":
            return self._picked(trial, was, pick_s, text)
        made = {
            "exclude": was._replace(exclude=text),
            "comment": was._replace(why=text),
            "clear": Decision(was.trial, file=was.file),
        }
        if action not in made:
            raise InputError(f"there is no action {action!r}", key="action", fix="reload the page")
        return made[action]

    def _picked(self, trial: str, was: Decision, pick_s: float | None, text: str) -> Decision:
        if pick_s is None or not isfinite(pick_s):
            fix = "click where the break-away is, or choose a candidate"
            raise InputError("no time is given for the break-away", code="RF121", key="pick_s", fix=fix)
        self.preview(trial, pick_s)  # which refuses a place without a peak
        result = self._state.trials[trial]
        events, outline = result.breakaway.candidates, result.outline
        near = [i for i, event in enumerate(events, 1) if isclose(event.time_s, pick_s, rel_tol=1e-6)]
        said = f"candidate {near[0]} of {len(events)} accepted" if near else "set by hand"
        own = was.why if not was.why.startswith(OWN_WORDS) else ""
        if outline is not None:
            span_s = float(outline.time_s[-1] - outline.time_s[0])
            pick_s = round(pick_s, max(0, ceil(-log10(max(STEADY * span_s, 1e-12)))))
        return Decision(was.trial, pick_s=pick_s, why=text or own or OWN_WORDS + said, file=was.file)

    def undo(self) -> dict[str, Any]:
        """Write the state before the last decision again, and return the changes."""
        with self._deciding:
            if not self._undo:
                raise InputError("no decision can be undone", code="RF110")
            state, (trial, were) = self._state, self._undo[-1]
            self._write(were)
            self._undo.pop()
            self.n_written -= len(were)
            return self._changed_since(state, trial)

    def _keep(self, trial: str, changes: Sequence[tuple[Decision, Decision]]) -> dict[str, Any]:
        """Write what replaces decisions, and return the effects."""
        state, changed = self._state, [(was, now) for was, now in changes if was != now]
        if not changed:
            raise InputError("this changes nothing", code="RF110", key=trial)
        when = self._now().isoformat(timespec="seconds")
        self._write([now._replace(by=self.by, when=when) for _, now in changed])
        self._undo.append((trial, [was for was, _ in changed]))
        self.n_written += len(changed)
        return self._changed_since(state, trial)

    def _write(self, decisions: Sequence[Decision]) -> None:
        """Write decisions, if all files are what was read; take them back if the campaign refuses them."""
        state, path = self._state, self.campaign.decisions
        if self._number < 0:
            raise DataError("the review has ended, so nothing was written", path=path, fix="start it again")
        if _contents(state.campaign) != state.content:
            raise changed_meanwhile(state.campaign.trial_list)
        before = state.content[-1]
        added = add_decisions(path, decisions, before)
        try:
            changed = self._load(state, state.campaign)
        except BaseException:
            take_back(path, before, added)
            raise
        with self.lock:
            self._state = changed
            self._recompute()

    def _changed_since(self, state: _State, trial: str) -> dict[str, Any]:
        before, now = state.rows, self._state.rows
        with self.lock:
            if before.keys() != now.keys():  # what was one trial has become several
                self._change = None
                return self.overview()
            self._change = {"trial": trial, "was": state.facts_of(trial), "is": self._state.facts_of(trial)}
            rows = {name: row for name, row in now.items() if row != before.get(name)}
            return {"rows": rows, "undo": len(self._undo), "counts": self._counts(), **self.answer()}

    # --- the answer, computed behind the scenes ---

    def use_law(self, law: str) -> dict[str, str]:
        """Use a law, "" for the best."""
        if law:
            ALL_LAWS[law]
        with self.lock:
            self.law = law
            self._recompute()
        return {"law": law}

    def _recompute(self) -> None:
        """Compute the answer to all trials again."""
        if (said := self._said()) is not None:
            self._before, self._first = said, self._first or said
        self._number += 1
        self._fit.begin("fit", partial(_fitted, self._state, self.law), instead=True)

    def _said(self) -> dict[str, Any] | None:
        """Return the numbers of the answer, or why there is none; None while it is computed."""
        run = self._fit.state().get("result")
        if isinstance(run, RopefricError):
            return run.to_dict()
        return None if run is None else _said_of(run.answer)

    def run(self) -> CampaignRun | None:
        """Return the run behind the answer to all trials, None while it is computed; raise why there is no answer."""
        run: CampaignRun | RopefricError | None = self._fit.state().get("result")
        if isinstance(run, RopefricError):
            raise run
        return run

    def close(self) -> None:
        """Wait for a decision that is being written, and a moment for the fit of a law; nothing is written later."""
        with self._deciding, self.lock:
            self._number = -1
        self._fit.close()

    def answer(self) -> dict[str, Any]:
        """Return the last decision, and the answer to all trials before and after it, as far as it is computed."""
        with self.lock:
            now, fit = self._said(), self._fit.state()
            laws = f"{fit['item']}, {fit['done']} of {fit['total']} laws" if fit["total"] else "fit"
            tree = {"number": self._number, "change": self._change, "computing": "" if now else laws}
            return tree | {"first": self._first or now, "before": self._before, "now": now}

    # --- what the page shows ---

    def overview(self) -> dict[str, Any]:
        """Return the whole list of trials, their counts, and the answer to all of them."""
        with self.lock:
            campaign = self._state.campaign
            names = {"campaign": campaign.name, "list": campaign.decisions.name, "by": self.by}
            trials = {"order": list(self._state.specs), "rows": self._state.rows, "counts": self._counts()}
            slack = campaign.protocol.needs_lift_force
            return {**names, "slack": slack, **trials, "undo": len(self._undo), **self.answer()}

    def _counts(self) -> dict[str, Any]:
        return results.count_trials(self._state.extraction)

    def conditions_of(self, run: CampaignRun) -> list[dict[str, Any]]:
        """Return the conditions in words with their means, and why all trials of one are excluded, "" if not all are."""
        with self.lock:
            tree = []
            for one in run.extraction.conditions:
                why = {self._spec(name).exclude for name in one.trials}
                off = why.pop() if len(why) == 1 else ""
                words = {"words": self._state.words_of(one), "trial": one.trials[0], "off": off}
                tree.append(words | repeats_of(one))
            return tree

    def _spec(self, trial: str) -> TrialSpec:
        if trial not in self._state.specs:
            raise InputError(f"there is no trial {trial!r}", code="RF120", key="trial", fix="reload the page")
        return self._state.specs[trial]

    def _seen(self, trial: str) -> tuple[_State, TrialSpec, TrialResult]:
        """Return the present state, and the row and the result of a trial in it."""
        with self.lock:
            return self._state, self._spec(trial), self._state.trials[trial]

    def trial(self, trial: str) -> dict[str, Any]:
        """Return the results and remarks of a trial, without its samples."""
        return facts_of(self._seen(trial)[2]) | {"trial": trial}

    def preview(self, trial: str, pick_s: float) -> dict[str, Any]:
        """Return the force that a trial would have with its break-away at a time; nothing is written."""
        state, spec, was = self._seen(trial)
        _refuse_unread(was)
        decided = replace(spec, pick_s=pick_s, peak_N=None, peak_std_N=None, exclude="", why="-", by="-")
        one = state.campaign.model_copy(update={"trials": (decided,), "warnings": ()})
        result = extract_rows(one, trusted=True)[spec.trial][0]
        _refuse_unread(result)
        if result.breakaway.status is not Status.OK:
            raise DataError(result.breakaway.detail, code="RF244", key="pick_s", fix="choose another place")
        return pick_of(result)

    def curve(self, trial: str, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
        """Return a stretch of a recording as it is drawn; NaN means the begin or the end of the recording."""
        state, spec, result = self._seen(trial)
        _refuse_unread(result)
        drawn = self._drawn
        if drawn is None or drawn[0] is not result:
            drawn = self._drawn = (result, *drawn_of(state.campaign, spec, result))
        _, curves, likely = drawn
        return decimated(curves, start_s, stop_s, columns) | likely


def _fitted(state: _State, law: str, step: Step) -> CampaignRun | RopefricError:
    """Return the answer to all trials, as `ropefric run` finds it; or why there is none."""

    def progress(law: str, done: int, total: int) -> None:
        step(done, total, law)

    try:
        return _answered(state, law, progress)
    except Exception as error:  # noqa: BLE001  (a page that computes for ever says less)
        return known_error(error, report_with=REPORT_WITH)


def _answered(state: _State, law: str, progress: Callable[[str, int, int], None]) -> CampaignRun:
    campaign, extraction = state.campaign, state.extraction
    if (without := results.no_force(extraction, campaign.path)) is not None:
        raise without
    answer = answer_campaign(campaign, table_of_extraction(extraction), law=law, progress=progress)
    return CampaignRun(campaign=campaign, extraction=extraction, answer=answer, written=())


def _said_of(answer: CampaignAnswer) -> dict[str, Any]:
    """Return the numbers of an answer that a decision may change."""
    parameters = [[one.name, one.value, one.std] for one in answer.fit.parameters if one.vary]
    lift = None if answer.prediction is None else answer.prediction.to_dict()
    said = {"law": answer.fit.law, "verdict": answer.verdict.word, "reason": answer.verdict.reason}
    return {**said, "parameters": _plain(parameters), "lift": _plain(lift)}


def _is_readable(result: TrialResult) -> bool:
    """Return whether a recording is no danger to this process: another one read it to its end."""
    return all(problem.code != UNREADABLE for problem in result.problems)


def _refuse_unread(result: TrialResult) -> None:
    if not _is_readable(result):
        fix = "".join(problem.fix for problem in result.problems[-1:])
        raise DataError(result.breakaway.detail, path=result.file, fix=fix)


def _stamp(path: Path) -> tuple[int, ...]:
    with suppress(OSError):
        found = path.stat()
        return found.st_mtime_ns, found.st_size
    return ()


def _contents(campaign: Campaign) -> tuple[bytes, ...]:
    """Return the bytes of a campaign file, of its list of trials, and of the decisions beside it."""
    return read_file(campaign.path), read_file(campaign.trial_list), content_of(campaign.decisions)


def changed_meanwhile(path: Path) -> DataError:
    """Return the refusal to write over what was changed since it was read."""
    why = (
        "somebody else has changed the campaign, its list or its decisions meanwhile, so nothing was written"
    )
    return DataError(why, code="RF153", path=path, fix="read it again, then change or decide anew")
