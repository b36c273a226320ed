"""A campaign under review: its trials, the decisions written to its list, and what these change."""

import threading
from collections import OrderedDict, deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from math import ceil, degrees, isfinite, log10
from pathlib import Path
from typing import Any

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.files.digits import GIVEN_DIGITS, significant
from ropefric.files.read import read_file
from ropefric.files.text import GZIP_MAGIC
from ropefric.files.write import write_file
from ropefric.pipeline.run import CampaignAnswer, answer_trials
from ropefric.review.decisions import with_decision
from ropefric.traces.breakaway import Status
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.excel import READER as EXCEL
from ropefric.traces.smoothing import smooth
from ropefric.trials.campaign import load_campaign
from ropefric.trials.campaign_model import Campaign, TrialSpec
from ropefric.trials.conditions import set_aside_impossible, summarised
from ropefric.trials.extract import ByRow, Progress, extract_rows, in_list_order
from ropefric.trials.recording import blocks_of, tared_trace
from ropefric.trials.result import ConditionSummary, Extraction, TrialResult, count_trials, no_force
from ropefric.trials.table import table_of_extraction

OWN_WORDS = "review: "
"""How a reason begins that nobody has written by hand."""
UNREADABLE = "RF101"
"""Code of the problem that reading a recording came to nothing, perhaps as it ended the process that did it."""
STEADY = 1e-5
MOST_UNDONE = 100
_HELD_TRACES = 3

Curves = tuple[FloatArray, FloatArray, FloatArray | None]
"""Time, force and smoothed force of a recording, samples that are missing left out."""


class _OutdatedError(Exception):
    """What is being computed is of a state that is no more."""


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """A campaign as its files say, what every row of its list gives, and what all of them give together."""

    content: bytes
    campaign: Campaign
    by_row: ByRow
    extraction: Extraction
    specs: Mapping[str, TrialSpec]

    def rows(self) -> dict[str, dict[str, Any]]:
        """Return what the list of trials shows of each."""
        names = {name: self._name_of(one) for one in self.extraction.conditions for name in one.trials}
        return {trial.trial: _row(trial, names[trial.trial]) for trial in self.extraction.trials}

    def _name_of(self, one: ConditionSummary) -> str:
        """Return the settings of a condition in words."""
        slack = self.campaign.protocol.needs_lift_force
        known = f"F_A {one.lift_force_N:.4g} N" if slack else f"F_B {one.end_tension_N:.4g} N"
        return f"R {1e3 * one.wheel_radius_m:.4g} mm, {degrees(one.wrap_angle_rad):.4g}°, {known}"

    def condition(self, trial: str) -> dict[str, Any]:
        """Return mean, scatter and number of the repeats that a trial is one of."""
        one = next(one for one in self.extraction.conditions if trial in one.trials)
        numbers = {
            "mean_N": one.mean_kept_N,
            "std_N": one.std_kept_N,
            "n_kept": one.n_kept,
            "n": one.n_recorded,
        }
        return {"name": self._name_of(one), "rejected": list(one.rejected), **_plain(numbers)}


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
    cache_dir : Path, optional
        Where the results of recordings are kept.
    jobs : int
        Processes that extract what the cache does not hold.
    progress : callable, optional
        Told of every recording extracted.
    now : callable, optional
        The clock by which decisions are dated.
    """

    def __init__(
        self,
        campaign: Path,
        *,
        by: str,
        law: str = "",
        cache_dir: Path | None = None,
        jobs: int = 1,
        progress: Progress | None = None,
        now: Callable[[], datetime] = lambda: datetime.now().astimezone(),
    ) -> None:
        self._path, self.by, self._law, self._now = campaign, by, law, now
        self._cache_dir, self._jobs = cache_dir, jobs
        self.lock = threading.RLock()
        self.n_written = 0
        self._traces: OrderedDict[tuple[object, ...], Curves] = OrderedDict()
        self._undo: deque[tuple[bytes, bytes, str]] = deque(maxlen=MOST_UNDONE)
        self._state = self._load(None, progress=progress)
        self._change: dict[str, Any] | None = None
        self._number, self._computed = 0, -1
        self._doing = ""
        self._thread: threading.Thread | None = None
        self._first: dict[str, Any] | None = None
        self._before: dict[str, Any] | None = None
        self._answer: dict[str, Any] | None = None
        self._recompute()

    @property
    def trial_list(self) -> Path:
        """Return the list that decisions are written to."""
        return self._state.campaign.trial_list

    # --- the files ---

    def _load(
        self, before: _State | None, content: bytes | None = None, progress: Progress | None = None
    ) -> _State:
        """Return the campaign as its files say now; only rows that differ from those before are extracted."""
        if content is None:
            content = _content_of(load_campaign(self._path, missing_recordings="flag").trial_list)
        campaign = load_campaign(self._path, missing_recordings="flag")
        if _content_of(campaign.trial_list) != content:
            raise _changed(campaign.trial_list)
        known: dict[TrialSpec, tuple[TrialResult, ...]] = {}
        if before is not None and before.campaign.settings_fingerprint() == campaign.settings_fingerprint():
            known = {_bare(row): before.by_row[row.trial] for row in before.campaign.trials}
        kept = {
            row.trial: tuple(replace(one, own=row.own) for one in known[_bare(row)])
            for row in campaign.trials
            if _bare(row) in known
        }
        rows = tuple(row for row in campaign.trials if row.trial not in kept)
        seen = {} if before is None else before.by_row
        readable = (row.trial in seen and all(map(_is_readable, seen[row.trial])) for row in rows)
        new, n_reused = extract_rows(
            campaign.model_copy(update={"trials": rows, "warnings": ()}),
            jobs=self._jobs,
            cache_dir=self._cache_dir,
            progress=progress,
            trusted=all(readable),
        )
        by_row = {**kept, **new}
        placed = in_list_order(campaign, by_row)
        found = summarised(campaign, [result for _, result in placed], n_reused=n_reused)
        return _State(
            content=content,
            campaign=campaign,
            by_row=by_row,
            extraction=set_aside_impossible(found, campaign),
            specs={result.trial: row for row, result in placed},
        )

    def reload(self) -> dict[str, Any]:
        """Read the campaign again, which somebody has changed; what was decided before can no longer be undone."""
        with self.lock:
            self._state = self._load(self._state)
            self._undo.clear()
            self._change = None
            self._recompute()
            return self.overview()

    def decide(
        self, trial: str, action: str, *, pick_s: float | None = None, text: str = ""
    ) -> dict[str, Any]:
        """Write a decision about a trial into the list, and return what it changes.

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
            RF153 if somebody else changed the list meanwhile; another code if it cannot be written.
            The list is then as it was.
        """
        with self.lock:
            state, spec = self._state, self._spec(trial)
            signed: dict[str, str | float] = {
                "by": self.by,
                "when": self._now().isoformat(timespec="seconds"),
            }
            if action == "pick":
                values = {**signed, **self._picked(trial, pick_s, text)}
            elif action == "exclude":
                values = {**signed, "exclude": _needed(text, "an exclusion needs its reason")}
            elif action == "comment":
                values = {**signed, "why": _needed(text, "the comment is empty")}
            elif action == "clear":
                cleared = ("pick_s", "peak_N", "peak_std_N", "exclude", "why", "by", "when")
                values = dict.fromkeys(cleared, "")
            else:
                raise InputError(f"there is no action {action!r}", key="action", fix="reload the page")
            content = with_decision(state.content, spec.line, values, state.campaign.trial_list.as_posix())
            if content == state.content:
                raise InputError("this changes nothing in the list", code="RF110", key=trial)
            self._replace(content, trial)
            self._undo.append((state.content, content, trial))
            self.n_written += 1
            return self._changed_since(state, trial)

    def _picked(self, trial: str, pick_s: float | None, text: str) -> dict[str, str | float]:
        if pick_s is None or not isfinite(pick_s):
            fix = "click where the break-away is, or choose a candidate"
            raise InputError("no time is given for the break-away", code="RF121", key="pick_s", fix=fix)
        self.preview(trial, pick_s)  # which refuses a place without a peak
        spec, result = self._spec(trial), self._result(trial)
        events, outline = result.breakaway.candidates, result.outline
        near = [
            place for place, event in enumerate(events, 1) if abs(event.time_s - pick_s) < 1e-6 * abs(pick_s)
        ]
        said = f"candidate {near[0]} of {len(events)} accepted" if near else "set by hand"
        own = spec.why if not spec.why.startswith(OWN_WORDS) else ""
        if outline is not None:  # no finger is steadier than this part of the recording
            span_s = float(outline.time_s[-1] - outline.time_s[0])
            pick_s = round(pick_s, max(0, ceil(-log10(max(STEADY * span_s, 1e-12)))))
        emptied = dict.fromkeys(("peak_N", "peak_std_N", "exclude"), "")
        return {"pick_s": pick_s, "why": text.strip() or own or OWN_WORDS + said, **emptied}

    def undo(self) -> dict[str, Any]:
        """Give the list back the bytes it had before the last decision, and return what that changes."""
        with self.lock:
            if not self._undo:
                raise InputError("there is nothing to undo", code="RF110")
            state, (before, _, trial) = self._state, self._undo[-1]
            self._replace(before, trial)
            self._undo.pop()
            self.n_written -= 1
            return self._changed_since(state, trial)

    def _replace(self, content: bytes, trial: str) -> None:
        """Write the list, if it is what was read; if others than a trial's row changed by that, write it back."""
        state, path = self._state, self._state.campaign.trial_list
        if self._number < 0:
            raise DataError("the review has ended: nothing was written", path=path, fix="start it again")
        if read_file(path) != state.content:
            raise _changed(path)
        write_file(path, content)
        try:
            new = self._load(state, content)
            changed = {
                row.trial
                for row, was in zip(new.campaign.trials, state.campaign.trials, strict=True)
                if _bare(row) != _bare(was)
            }
            if not changed <= {state.specs[trial].trial}:
                raise _not_alone(changed, path)  # noqa: TRY301  (whatever is wrong, the list becomes what it was)
        except BaseException:
            if read_file(path) == content:
                write_file(path, state.content)
            raise
        self._state = new

    def _changed_since(self, state: _State, trial: str) -> dict[str, Any]:
        before, now = state.rows(), self._state.rows()
        self._change = {
            "trial": trial,
            "was": before[trial] | {"condition_was": state.condition(trial)},
            "is": now[trial] | {"condition_is": self._state.condition(trial)},
        }
        self._recompute()
        rows = {name: row for name, row in now.items() if row != before.get(name)}
        return {"rows": rows, "undo": len(self._undo), "counts": self._counts(), **self.answer()}

    # --- the answer, computed behind the scenes ---

    def _recompute(self) -> None:
        """Let what all trials say be found out again, by a thread of its own."""
        if self._computed == self._number:
            self._before = self._answer
        self._number += 1
        if self._thread is None:
            self._thread = threading.Thread(target=self._compute, name="fit", daemon=True)
            self._thread.start()

    def _compute(self) -> None:
        while True:
            with self.lock:
                number, state = self._number, self._state
                if number in (self._computed, -1):
                    self._thread = None
                    return

            def stop_if_outdated(law: str, done: int, total: int, number: int = number) -> None:
                self._doing = f"{law}, {done} of {total} laws"
                if number != self._number:
                    raise _OutdatedError

            try:
                said = _said(state, self._law, stop_if_outdated)
            except _OutdatedError:
                continue
            except RopefricError as error:
                said = {"error": error.problem.to_dict()}
            except Exception as error:  # noqa: BLE001  (a page that computes for ever says less)
                said = {
                    "error": {"code": "RF000", "message": f"internal fault, {type(error).__name__}: {error}"}
                }
            with self.lock:
                if number == self._number:
                    self._answer, self._computed = said, number
                    self._first = self._first or said

    def close(self) -> None:
        """Wait for a decision that is being written, a moment for the fit of a law; nothing comes after it."""
        with self.lock:
            self._number, thread = -1, self._thread
        if thread is not None:
            thread.join(2.0)

    def answer(self) -> dict[str, Any]:
        """Return the last decision, and what all trials say before and after it, as far as it is known."""
        with self.lock:
            ready = self._computed == self._number
            return {
                "change": self._change,
                "computing": "" if ready else self._doing or "fit",
                "first": self._first,
                "before": self._before,
                "now": self._answer if ready else None,
            }

    # --- what the page shows ---

    def overview(self) -> dict[str, Any]:
        """Return the whole list of trials, and what is known of all of them."""
        with self.lock:
            campaign = self._state.campaign
            return {
                "campaign": campaign.name,
                "list": campaign.trial_list.name,
                "by": self.by,
                "slack": campaign.protocol.needs_lift_force,
                "order": list(self._state.specs),
                "rows": self._state.rows(),
                "undo": len(self._undo),
                "counts": self._counts(),
                **self.answer(),
            }

    def _counts(self) -> dict[str, Any]:
        return count_trials(self._state.extraction)

    def _spec(self, trial: str) -> TrialSpec:
        if trial not in self._state.specs:
            raise InputError(f"there is no trial {trial!r}", code="RF120", key="trial", fix="reload the page")
        return self._state.specs[trial]

    def _result(self, trial: str) -> TrialResult:
        self._spec(trial)
        return next(one for one in self._state.extraction.trials if one.trial == trial)

    def trial(self, trial: str) -> dict[str, Any]:
        """Return all that is known of a trial but its samples."""
        with self.lock:
            spec, result = self._spec(trial), self._result(trial)
            found, condition = result.breakaway, self._state.condition(trial)
        numbers = (
            *("peak_N", "peak_raw_N", "peak_time_s", "kinetic_N", "kinetic_std_N", "drop_N", "noise_std_N"),
            *("window_s", "loading_rate_N_s", "n_slips", "two_line_N"),
        )
        tree = {
            **{name: getattr(found, name) for name in numbers},
            "start_s": spec.start_s,
            "stop_s": spec.stop_s,
            "mu": result.mu,
            "file": result.file,
            "picked": [result.measured_N, _std_of(result), found.peak_time_s],
            "detail": found.detail,
            "advice": "" if found.status is Status.OK else found.advice,
            "notes": found.notes,
            "problems": [f"{one.code}: {one.message}" for one in result.problems],
            "phases": [asdict(one) for one in found.phases],
            "events": [asdict(one) for one in found.events],
            "candidates": [asdict(one) for one in found.candidates],
            "condition": condition,
        }
        return {"trial": trial, **_plain(tree)}

    def preview(self, trial: str, pick_s: float) -> dict[str, Any]:
        """Return the force that a trial would have with its break-away at a time; nothing is written."""
        with self.lock:
            campaign, spec, was = self._state.campaign, self._spec(trial), self._result(trial)
        self._refuse_unread(was)
        decided = replace(spec, pick_s=pick_s, peak_N=None, peak_std_N=None, exclude="", why="-", by="-")
        one = campaign.model_copy(update={"trials": (decided,), "warnings": ()})
        results, _ = extract_rows(one, trusted=True)
        result = results[spec.trial][0]
        found = result.breakaway
        if found.status is not Status.OK:
            raise DataError(found.detail, code="RF244", key="pick_s", fix="choose another place")
        return {"picked": _plain([result.measured_N, _std_of(result), found.peak_time_s])}

    def curve(self, trial: str, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
        """Return a stretch of a recording as it is drawn; a time that is no number stands for the recording's end."""
        with self.lock:
            campaign, spec, result = self._state.campaign, self._spec(trial), self._result(trial)
        self._refuse_unread(result)
        window_s = result.breakaway.window_s
        key = (trial, result.sha256, campaign.settings_fingerprint(), window_s)
        if key not in self._traces:
            raws = read_recordings(spec.path, campaign.profile, shown_as=spec.file)
            raw = blocks_of(replace(spec, sample=result.sample), raws)[0]
            trace, _, _ = tared_trace(campaign, spec, raw)
            smoothed = smooth(trace, window_s).force_N if isfinite(window_s) else None
            present = np.isfinite(trace.force_N)
            shown = None if smoothed is None else smoothed[present]
            self._traces[key] = trace.time_s[present], trace.force_N[present], shown
        with self.lock:
            curves = self._traces[key]
            self._traces.move_to_end(key)
            while len(self._traces) > _HELD_TRACES:
                self._traces.popitem(last=False)
        return decimated(curves, start_s, stop_s, columns)

    def _refuse_unread(self, result: TrialResult) -> None:
        if not _is_readable(result):
            fix = "".join(problem.fix for problem in result.problems[-1:])
            raise DataError(result.breakaway.detail, path=result.file, fix=fix)


def decimated(curves: Curves, start_s: float, stop_s: float, columns: int) -> dict[str, Any]:
    """Return time, lowest, highest and smoothed force for each column of a picture that has a sample.

    A column holds all samples in its stretch of time, so no peak is lost; where there are fewer samples than
    two in a column, each stands for itself.
    """
    time_s, force_N, smoothed_N = curves
    if not time_s.size:
        raise DataError("no sample is there", fix="exclude the trial")
    begin_s, end_s = float(time_s[0]), float(time_s[-1])
    start_s = start_s if isfinite(start_s) else begin_s
    stop_s = stop_s if isfinite(stop_s) else end_s
    columns = min(max(int(columns), 10), 5000)
    if not start_s < stop_s:
        stop_s = start_s + 1e-9 * max(1.0, abs(start_s))
    first, last = np.searchsorted(time_s, start_s, "left"), np.searchsorted(time_s, stop_s, "right")
    if last - first <= 2 * columns:
        inside = slice(max(0, int(first) - 1), int(last) + 1)
        shown = [time_s[inside], force_N[inside], force_N[inside]]
        middle = np.arange(time_s.size)[inside]
    else:
        time, force = time_s[first:last], force_N[first:last]
        column = np.minimum(((time - start_s) * (columns / (stop_s - start_s))).astype(np.int64), columns - 1)
        starts = np.flatnonzero(np.diff(column, prepend=-1))
        counts = np.diff(np.append(starts, column.size))
        low, high = np.minimum.reduceat(force, starts), np.maximum.reduceat(force, starts)
        shown = [0.5 * (time[starts] + time[starts + counts - 1]), low, high]
        middle = first + starts + counts // 2
    if smoothed_N is not None:
        shown.append(smoothed_N[middle])
    names = ("time_s", "low_N", "high_N", "smoothed_N")
    tree = {name: _plain(values.tolist()) for name, values in zip(names, shown, strict=False)}
    span = (start_s, stop_s, begin_s, end_s)
    return dict(zip(("start_s", "stop_s", "begin_s", "end_s"), span, strict=True)) | tree


def _said(state: _State, law: str, progress: Callable[[str, int, int], None]) -> dict[str, Any]:
    """Return what all trials say, as few numbers as tell one answer from another."""
    campaign = state.campaign
    if (without := no_force(state.extraction, campaign.path)) is not None:
        raise without
    rope_m, table = campaign.rope.radius_m, table_of_extraction(state.extraction)
    answer = answer_trials(table, design=campaign.design, rope_radius_m=rope_m, law=law, progress=progress)
    parameters = [[one.name, one.value, one.std] for one in answer.fit.parameters if one.vary]
    return {
        "law": answer.fit.law,
        "verdict": answer.verdict.word,
        "reason": answer.verdict.reason,
        "doubts": list(answer.doubts),
        "parameters": _plain(parameters),
        "lift": _plain(_lift(answer)),
    }


def _lift(answer: CampaignAnswer) -> dict[str, Any] | None:
    if answer.prediction is None:
        return None
    found = answer.prediction
    low_N, high_N = found.interval_N[0].tolist()
    return {"force_N": float(found.lift_force_N[0]), "low_N": low_N, "high_N": high_N, "level": found.level}


def _row(trial: TrialResult, condition: str) -> dict[str, Any]:
    return {
        "file": trial.file,
        "condition": condition,
        "status": trial.breakaway.status.value,
        "outcome": trial.outcome,
        "excluded": trial.excluded,
        "decision": trial.decision,
        "why": trial.why,
        "by": trial.by,
        "force_N": _plain(trial.measured_N),
        "std_N": _plain(_std_of(trial)),
    }


def _std_of(trial: TrialResult) -> float:
    return trial.end_tension_std_N if trial.measures_slack else trial.peak_std_N


def _plain(tree: Any) -> Any:
    """Return a tree as JSON holds it: numbers without their last bits, None where there is none."""
    if isinstance(tree, float):
        return significant(tree, GIVEN_DIGITS) if isfinite(tree) else None
    if isinstance(tree, Mapping):
        return {key: _plain(item) for key, item in tree.items()}
    return [_plain(item) for item in tree] if isinstance(tree, list | tuple) else tree


def _needed(text: str, otherwise: str) -> str:
    if not text.strip():
        raise InputError(otherwise, code="RF121", fix="say in a few words what was seen")
    return text.strip()


def _bare(row: TrialSpec) -> TrialSpec:
    """Return a row without what its result does not depend on: its line, and columns of the user's own."""
    return replace(row, line=0, own=())


def _is_readable(result: TrialResult) -> bool:
    """Return whether a recording is no danger to this process: another one read it to its end."""
    return all(problem.code != UNREADABLE for problem in result.problems)


def _content_of(path: Path) -> bytes:
    """Return the bytes of a trial list that decisions can be written to."""
    what = ""
    if path.suffix.lower() in EXCEL.suffixes:
        what = "a workbook"
    elif (content := read_file(path)).startswith(GZIP_MAGIC):
        what = "packed"
    if what:
        why = f"the list of trials is {what}, which decisions are not written to"
        fix = 'save it as a CSV file, and name that in the campaign file: trials = "trials.csv"'
        raise DataError(why, code="RF154", path=path, fix=fix)
    return content


def _not_alone(changed: set[str], path: Path) -> DataError:
    why = f"the decision would change other trials too: {', '.join(sorted(changed))}"
    return DataError(why, path=path, fix="write it into the list by hand")


def _changed(path: Path) -> DataError:
    why = "somebody else has changed the list of trials since it was read: nothing was written"
    return DataError(why, code="RF153", path=path, fix="read it again, then decide anew")
