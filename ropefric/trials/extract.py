"""A campaign's recordings -> trial table: in parallel, interruptible, without doing the same work twice.

A stored result is found by the content of the recording, the settings it was extracted with and the code of this
package; time stamps and paths of files do not matter. A damaged entry counts as none.
"""

import hashlib
import json
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import ConfigDict, TypeAdapter

from ropefric import __version__
from ropefric.errors import DataError, InputError, Problem, RopefricError
from ropefric.executors import spread
from ropefric.files.disk import InputFile, hash_file, read_file, use_file, write_file
from ropefric.glossary import counted
from ropefric.traces.readers import READERS, TEXT_FORMATS, find_reader, read_recordings
from ropefric.trials.campaign_model import Campaign, TrialSpec
from ropefric.trials.recording import blocks_of, extract_recording, tared_trace, unreadable
from ropefric.trials.result import Extraction, TrialResult, summarised
from ropefric.trials.trial_list import free_name
from ropefric.trials.workers import START_S, Lost, guarded

SCHEMA = "ropefric.extraction-cache/4"
MADE_BY = ("errors.py", "quantities.py", "registry.py", "files", "traces", "trials")
"""What a result comes from, beside what is stored with it; a change in any line makes all entries old."""


@lru_cache(maxsize=1)
def hash_sources() -> str:
    """Return the SHA-256 of the code that results are made by; of nothing where it cannot be looked at."""
    package, found = Path(__file__).parents[1], hashlib.sha256()
    for name in MADE_BY:
        place = package / name
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            with suppress(OSError):
                found.update(path.read_bytes())
    return found.hexdigest()


Results = tuple[tuple[TrialResult, ...], ...]
"""Of a recording's rows, each with one or more."""


@lru_cache(maxsize=1)
def _entries() -> TypeAdapter[Results]:
    return TypeAdapter(Results, config=ConfigDict(extra="forbid", strict=True, ser_json_inf_nan="constants"))


class ResultCache:
    """Results of recordings in a folder, one small file each."""

    def __init__(self, folder: Path, settings: str) -> None:
        self.folder = folder
        self._made_by = json.dumps([SCHEMA, hash_sources(), __version__, settings])

    def _path(self, specs: Sequence[TrialSpec], sha256: str) -> Path:
        rows = [
            [repr(getattr(spec, f.name)) for f in fields(spec) if f.name not in ("path", "line", "note")]
            for spec in specs
        ]
        key = json.dumps([self._made_by, sha256, rows])
        return self.folder / f"{_hash(key.encode())[:32]}.json"

    def load(self, specs: Sequence[TrialSpec], sha256: str) -> Results | None:
        """Return the stored results of a recording's rows, or None if there are none that can be used."""
        if not sha256:
            return None
        try:
            checksum, _, text = read_file(self._path(specs, sha256)).partition(b"\n")
            # A digit that changed on disk would still be a number.
            if checksum.decode() != _hash(text):
                return None
            found = _entries().validate_json(text)
        # Whatever is wrong with an entry, and with a right checksum too, it can be made again.
        except Exception:  # noqa: BLE001
            return None
        files = [{result.file for result in row} for row in found]
        return found if files == [{spec.file} for spec in specs] else None

    def store(self, specs: Sequence[TrialSpec], sha256: str, results: Results) -> None:
        """Keep the results of a recording; a folder that cannot be written is no reason to stop."""
        if sha256:
            text = _entries().dump_json(results)
            with suppress(DataError):
                write_file(self._path(specs, sha256), f"{_hash(text)}\n".encode() + text, durable=False)


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


Progress = Callable[[int, int, str], None]
_Rows = tuple[TrialSpec, ...]
_Done = tuple[Results, bool]


def extract_campaign(
    campaign: Campaign,
    *,
    jobs: int = 1,
    cache_dir: Path | None = None,
    progress: Progress | None = None,
    executor: Any = None,
) -> Extraction:
    """Return the break-away forces of all recordings of a campaign, and what the rejection rule keeps.

    One bad recording never ends the run: it gives a trial with a status and a problem. Results do not depend on
    `jobs`, the executor that reads in their stead, or what is in the cache.
    """
    by_row, n_reused = extract_rows(
        campaign, jobs=jobs, cache_dir=cache_dir, progress=progress, executor=executor
    )
    return summarised(campaign, [trial for _, trial in in_list_order(campaign, by_row)], n_reused=n_reused)


ByRow = Mapping[str, tuple[TrialResult, ...]]
"""The results of each row of a trial list, by the row's name."""


def extract_rows(
    campaign: Campaign,
    *,
    jobs: int = 1,
    cache_dir: Path | None = None,
    progress: Progress | None = None,
    executor: Any = None,
    trusted: bool = False,
) -> tuple[ByRow, int]:
    """Return what the recording of every row gives by itself, and how many recordings were in the cache.

    Recordings that are `trusted`, since they were read before, are read at once, in this process.
    """
    if jobs < 1:
        raise InputError(f"{jobs} processes cannot work", code="RF110", key="jobs", fix="use 1 or more")
    by_file: dict[Path, list[TrialSpec]] = {}  # so that a wide file is read once
    for spec in campaign.trials:
        by_file.setdefault(spec.path, []).append(spec)
    files = tuple(map(tuple, by_file.values()))
    done: list[_Done] = [((), False)] * len(files)
    cache = None
    if cache_dir is not None:
        cache = ResultCache(cache_dir.absolute(), campaign.settings_fingerprint())
    without_rows = campaign.model_copy(update={"trials": (), "warnings": ()})
    work = _Work(campaign=without_rows, files=files, cache=cache)
    running: Generator[tuple[int, _Done]]
    if trusted:
        running = ((place, work(place)) for place in range(len(files)))
    else:
        _preload(work)
        running = _results(work, jobs, executor)
    with closing(running):  # ends its processes
        for count, (place, results) in enumerate(running, start=1):
            done[place] = results
            if progress is not None:
                found = [trial for row in results[0] for trial in row]
                worst = next((t for t in found if t.breakaway.status != "ok"), found[0])
                progress(count, len(files), f"{worst.trial} {worst.breakaway.status.value}")
    by_row = {
        spec.trial: found
        for rows, (of_file, _) in zip(files, done, strict=True)
        for spec, found in zip(rows, of_file, strict=True)
    }
    return by_row, sum(reused for _, reused in done)


def in_list_order(campaign: Campaign, by_row: ByRow) -> list[tuple[TrialSpec, TrialResult]]:
    """Return each row of the trial list with each of its results, which has a name of its own."""
    taken = set(by_row)
    placed = []
    for row in campaign.trials:
        for result in by_row[row.trial]:
            # A row may be called as the block or tooth of another: "w#2".
            name = row.trial if result.trial == row.trial else free_name(result.trial, taken)
            taken.add(name)
            placed.append((row, result if name == result.trial else replace(result, trial=name)))
    return placed


@dataclass(frozen=True, slots=True, kw_only=True)
class _Work:
    """What every process is given once: the campaign without its rows, the files with theirs, the cache."""

    campaign: Campaign
    files: tuple[_Rows, ...]
    cache: ResultCache | None

    def __call__(self, place: int) -> _Done:
        """Return the results of a file, and whether they were there already."""
        rows = self.files[place]
        try:
            return use_file(rows[0].path, lambda file: self._extract(rows, file), shown=rows[0].file)
        except RopefricError as error:
            return unreadable(self.campaign, rows, error), False
        except MemoryError:
            raise
        except Exception as error:  # noqa: BLE001  (whatever a recording brings about, it ends that recording)
            message = f"internal fault, {type(error).__name__}: {error}"
            fix = "this is a bug in ropefric: please report it with the recording"
            fault = RopefricError(message, code="RF000", path=rows[0].file, fix=fix)
            return unreadable(self.campaign, rows, fault), False

    def _extract(self, rows: _Rows, file: InputFile) -> _Done:
        if self.cache is not None:
            stored = self.cache.load(rows, file.sha256)
            if stored is not None:
                return stored, True
        results = extract_recording(self.campaign, rows, file=file)
        if self.cache is not None and file.is_steady:
            self.cache.store(rows, file.sha256, results)
        return results, False

    def lost(self, place: int, why: Lost) -> _Done:
        """Return the results of a file that could not be read to its end."""
        rows = self.files[place]
        error = DataError(why.reason, code="RF101", path=rows[0].file, fix=why.fix)
        try:
            sha256 = hash_file(rows[0].path)
        except DataError:
            sha256 = ""
        return unreadable(self.campaign, rows, error, sha256=sha256), False


_PIECE = 16
"""Files that a worker elsewhere is handed at a time."""


def _results(work: _Work, jobs: int, executor: Any = None) -> Generator[tuple[int, _Done]]:
    """Yield place and results of each file: read by processes of this one, or where an executor says."""
    if executor is None:
        for place, done in guarded(work, len(work.files), jobs=jobs, limits=work.campaign.limits):
            yield place, work.lost(place, done) if isinstance(done, Lost) else done
        return
    # Elsewhere another folder is the present one.
    files = [tuple(replace(row, path=row.path.absolute()) for row in rows) for rows in work.files]
    starts = range(0, len(files), _PIECE)
    pieces = (replace(work, files=tuple(files[start : start + _PIECE])) for start in starts)
    patience_s = _PIECE * work.campaign.limits.time_s + START_S
    with closing(spread(_all_of, pieces, executor, again=_again, patience_s=patience_s)) as running:
        for start, found in zip(starts, running, strict=True):
            yield from enumerate(found, start)


def _all_of(work: _Work) -> list[_Done]:
    """Return the results of all files, read in this process."""
    for rows in work.files:
        rows[0].path.stat()
    return [work(place) for place in range(len(work.files))]


def _again(work: _Work, error: BaseException) -> list[_Done]:
    """Return the results of files that another process did not come to the end of: one of them may be to blame."""
    if isinstance(error, FileNotFoundError) and Path(path := str(error.filename)).exists():
        fix = "keep the recordings in a folder that all machines have under the same name"
        raise DataError("a worker does not find this file", code="RF101", path=path, fix=fix) from None
    found = dict(_results(work, jobs=1))
    return [found[place] for place in range(len(found))]


def check_recordings(campaign: Campaign) -> tuple[tuple[str, ...], tuple[Problem, ...]]:
    """Return what was recognised in one recording of every kind, and why such a one cannot be read.

    Recordings are of one kind if their names end alike, in one of the endings that readers know. Where the first cannot
    be read, the last is tried before the kind is given up: a single bad recording ends no campaign.
    """
    kinds: dict[str, list[TrialSpec]] = {}
    endings = [ending for reader in READERS.values() for ending in reader.suffixes]
    for spec in campaign.trials:
        if not spec.exclude:
            name = spec.path.name.lower()
            kinds.setdefault(next(filter(name.endswith, endings), ""), []).append(spec)
    found: list[_Looked] = [((), ())] * len(kinds)
    with closing(guarded(partial(_look, campaign, kinds), len(kinds), limits=campaign.limits)) as running:
        for place, looked in running:
            if isinstance(looked, Lost):
                path = [*kinds.values()][place][0].file
                problem = Problem(code="RF101", message=looked.reason, path=path, fix=looked.fix)
                looked = (), (problem,)  # noqa: PLW2901
            found[place] = looked
    return tuple(chain(*(said for said, _ in found))), tuple(chain(*(problems for _, problems in found)))


_Looked = tuple[tuple[str, ...], tuple[Problem, ...]]


def _look(campaign: Campaign, kinds: Mapping[str, Sequence[TrialSpec]], place: int) -> _Looked:
    ending, specs = [*kinds.items()][place]
    failed: list[Problem] = []
    for spec in (specs[0], specs[-1])[: len(specs)]:
        try:
            raws = blocks_of(spec, read_recordings(spec.path, campaign.profile, shown_as=spec.file))
            trace, _, problems = tared_trace(campaign, spec, raws[0])
        except RopefricError as error:
            failed += error.problems
            continue
        facts = f"{spec.file}: {counted(trace.force_N.size, 'sample')}, {trace.sampling_rate_Hz:.5g} Hz"
        told = (replace(problem, severity="warning") for problem in failed)
        return ("; ".join([facts, *trace.notes]),), (*told, *problems)
    more = f"; so it is with others of the {len(specs)} that end in {ending!r}" if len(specs) > 1 else ""
    return (), (replace(failed[0], message=f"{failed[0].message}{more}"),)


def _preload(work: _Work) -> None:
    """Load what every process will need once, before they are forked."""
    if work.files and (work.cache is None or not work.cache.folder.exists()):
        with suppress(RopefricError):
            if find_reader(work.files[0][0].path, work.campaign.profile).name in TEXT_FORMATS:
                import pandas  # noqa: ICN001, F401, PLC0415
