"""A campaign's recordings -> trial table: in parallel, interruptible, without doing the same work twice."""

import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from pathlib import Path

from ropefric.errors import InputError, Problem
from ropefric.trials.cache import ResultCache
from ropefric.trials.campaign_model import Campaign
from ropefric.trials.conditions import summarise_conditions
from ropefric.trials.recording import content_hash, extract_recording
from ropefric.trials.result import ConditionSummary, Extraction, Outline, TrialResult
from ropefric.trials.trial_spec import TrialSpec

__all__ = ["ConditionSummary", "Extraction", "Outline", "TrialResult", "extract_campaign"]

CHUNK = 8
"""Recordings handed to a process at a time: the campaign travels with each hand-over."""

Progress = Callable[[int, int, str], None]
_Rows = tuple[TrialSpec, ...]
_Done = tuple[tuple[TrialResult, ...], bool]


def extract_campaign(
    campaign: Campaign,
    *,
    executor: Executor | None = None,
    jobs: int = 1,
    cache_dir: Path | None = None,
    progress: Progress | None = None,
) -> Extraction:
    """Return the break-away forces of all recordings of a campaign, and what the rejection rule keeps.

    One bad recording never ends the run: it gives a trial with a status and a problem. Results do not depend on
    `executor`, `jobs` or what is in the cache.

    Parameters
    ----------
    campaign : Campaign
        From `load_campaign`.
    executor : concurrent.futures.Executor, optional
        Runs the recordings; any will do, processes, threads or a cluster's. It is not shut down.
    jobs : int
        Without an executor: number of processes; 1 works in this one.
    cache_dir : Path, optional
        Where results are kept, so that unchanged recordings are not extracted again; every result is stored as soon
        as it is there, so an interrupted run goes on where it stopped.
    progress : callable, optional
        Called with recordings done, recordings in all, and "name status" of the last one.

    Raises
    ------
    InputError
        If `jobs` is not positive.
    """
    if jobs < 1:
        raise InputError(f"{jobs} processes cannot work", code="RF110", key="jobs", fix="use 1 or more")
    files = _by_file(campaign.trials)
    done: list[_Done] = [((), False)] * len(files)
    for count, (place, results) in enumerate(_run(campaign, files, executor, jobs, cache_dir), start=1):
        done[place] = results
        if progress is not None:
            worst = next((t for t in results[0] if t.breakaway.status != "ok"), results[0][0])
            progress(count, len(files), f"{worst.trial} {worst.breakaway.status.value}")
    trials, conditions, doubts = summarise_conditions(
        _in_list_order(campaign, files, [results for results, _ in done]), campaign.rejection
    )
    problems: list[Problem] = [*campaign.warnings]
    for trial in trials:
        problems.extend(trial.problems)
    return Extraction(
        name=campaign.name,
        trials=trials,
        conditions=conditions,
        problems=(*problems, *doubts),
        n_reused=sum(reused for _, reused in done),
    )


def _by_file(specs: Sequence[TrialSpec]) -> list[_Rows]:
    """Rows that name the same file together, so that a wide file is read once."""
    groups: dict[Path, list[TrialSpec]] = {}
    for spec in specs:
        groups.setdefault(spec.path, []).append(spec)
    return [tuple(group) for group in groups.values()]


def _in_list_order(
    campaign: Campaign, files: Sequence[_Rows], results: Sequence[tuple[TrialResult, ...]]
) -> list[TrialResult]:
    """Put the results of files back into the order of the trial list; a row may have given several."""
    order = {spec.trial: place for place, spec in enumerate(campaign.trials)}
    placed: list[tuple[int, int, TrialResult]] = []
    for rows, found in zip(files, results, strict=True):
        names = sorted((spec.trial for spec in rows), key=len, reverse=True)
        for number, result in enumerate(found):
            row = next(n for n in names if result.trial == n or result.trial.startswith(f"{n}#"))
            placed.append((order[row], number, result))
    return [result for _, _, result in sorted(placed, key=lambda item: item[:2])]


def _run(
    campaign: Campaign,
    files: Sequence[_Rows],
    executor: Executor | None,
    jobs: int,
    cache_dir: Path | None,
) -> Iterator[tuple[int, _Done]]:
    """Give place and results of each file, in the order they are finished."""
    if executor is None and (jobs == 1 or len(files) < 2):
        for place, rows in enumerate(files):
            yield place, _extract_file(campaign, rows, cache_dir)
        return
    own = ProcessPoolExecutor(jobs, initializer=_ignore_interrupts) if executor is None else None
    runner = executor or own
    try:
        starts = range(0, len(files), CHUNK)
        futures = {
            runner.submit(_extract_chunk, campaign, files[start : start + CHUNK], cache_dir): start  # type: ignore[union-attr]
            for start in starts
        }
        for future in as_completed(futures):
            for offset, results in enumerate(future.result()):
                yield futures[future] + offset, results
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)


def _ignore_interrupts() -> None:
    # Ctrl-C reaches every process of the terminal; only the first one may act on it, and it lets the others finish.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _extract_chunk(campaign: Campaign, files: Sequence[_Rows], cache_dir: Path | None) -> list[_Done]:
    return [_extract_file(campaign, rows, cache_dir) for rows in files]


def _extract_file(campaign: Campaign, rows: _Rows, cache_dir: Path | None) -> _Done:
    sha256 = content_hash(rows[0].path)
    if cache_dir is None:
        return extract_recording(campaign, rows, sha256=sha256), False
    cache = ResultCache(cache_dir, campaign.settings_fingerprint())
    stored = cache.load(rows, sha256)
    if stored is not None:
        return stored, True
    results = extract_recording(campaign, rows, sha256=sha256)
    cache.store(rows, sha256, results)
    return results, False
