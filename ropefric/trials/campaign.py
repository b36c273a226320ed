"""From campaign.toml and its trial list to a `Campaign`, or to everything that is wrong with them."""

import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ropefric.errors import PATH, DataError, Problem, UnknownNameError, raise_problems
from ropefric.files.disk import kind_of_file, write_files
from ropefric.files.toml import TomlDocument, is_scene, parse_toml, read_toml
from ropefric.files.toml_edit import Keys, with_values
from ropefric.files.toml_model import validate_document
from ropefric.plugins import load_named
from ropefric.registry import did_you_mean
from ropefric.traces.breakaway import SIDES
from ropefric.traces.formulas import evaluate_derived
from ropefric.traces.signals import COUNTS, signal_unit
from ropefric.trials.campaign_model import (
    AboutTable,
    Campaign,
    CampaignFile,
    Protocol,
    Rope,
    Round,
    protocol_names,
)
from ropefric.trials.trial_list import (
    MISSING_RECORDING,
    advise,
    radius_doubt,
    read_trials,
)

_HOW_TO_READ = "# How to read the recordings"
MISSING_WAYS = ("error", "flag")
TEMPLATES = ("campaign.toml", "trials.csv")
"""The files of a new campaign."""


def write_templates(
    folder: str | os.PathLike[str], *, trials: bytes | None = None, section: str = "", overwrite: bool = False
) -> tuple[Path, ...]:
    """Return the paths of the commented campaign.toml and trials.csv just written; or, beside a campaign, of a list.

    A section takes the place of the template's own on how to read recordings.
    """
    contents = template_texts(section)
    if trials is not None:
        contents[TEMPLATES[1]] = trials
        if (Path(folder) / TEMPLATES[0]).exists():
            del contents[TEMPLATES[0]]
    return write_files(folder, contents, overwrite=overwrite)


def template_texts(section: str = "", settings: Mapping[Keys, Any] | None = None) -> dict[str, bytes]:
    """Return the commented files of a new campaign by name, with values for some keys of campaign.toml."""
    source = files("ropefric.trials") / "templates"
    contents = {name: (source / name).read_bytes() for name in TEMPLATES}
    text, mark, own = contents[TEMPLATES[0]].decode().partition(_HOW_TO_READ)
    text = with_values(text, settings or {}).rstrip() + "\n\n"
    contents[TEMPLATES[0]] = (text + (section or mark + own)).encode()
    return contents


def load_campaign(
    path: str | os.PathLike[str], *, missing_recordings: Literal["error", "flag"] = "error"
) -> Campaign:
    """Return a campaign with its trial list, checked, with defaults filled in, in SI.

    No recording is opened; it is only made sure that they are there.

    Parameters
    ----------
    path : path-like
        The campaign.toml.
    missing_recordings : {"error", "flag"}
        Whether a recording that is not there is an error, or a warning and a trial like any other, whose
        extraction will say `unreadable`.

    Raises
    ------
    DataError
        With every error of both files in `.problems`. Warnings are in `Campaign.warnings`.
    UnknownNameError
        For another word.

    Examples
    --------
    >>> import tempfile
    >>> from ropefric.trials.campaign import write_templates
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path, _ = write_templates(folder)
    ...     recording = Path(folder) / "recordings" / "pull_01.csv"
    ...     recording.parent.mkdir()
    ...     _ = recording.write_text("time_s,force_N")
    ...     campaign = load_campaign(path)
    >>> campaign.rope.radius_m, campaign.trials[0].trial, campaign.trials[0].end_tension_N
    (0.0049, 'pull_01', 80.0)
    """
    PATH.check(path=path)
    if missing_recordings not in MISSING_WAYS:
        fix = did_you_mean(missing_recordings, MISSING_WAYS)
        raise UnknownNameError(f"unknown word {missing_recordings!r}", key="missing_recordings", fix=fix)
    campaign, problems = examine_campaign(path, flag_missing=missing_recordings == "flag")
    raise_problems(problems)
    assert campaign is not None  # noqa: S101  (where there is none, there is an error)
    return campaign


def load_about(path: str | os.PathLike[str]) -> AboutTable:
    """Return what a TOML file says beside a trial table: its [design] and [report], as in a campaign."""
    model, problems = validate_document(AboutTable, read_toml(path, "file"))
    raise_problems(problems)
    return model or AboutTable()


def check_campaign(path: str | os.PathLike[str]) -> tuple[Problem, ...]:
    """Return everything that is wrong or doubtful: the campaign file's by line, then the trial list's."""
    return examine_campaign(path)[1]


def examine_campaign(
    path: str | os.PathLike[str], *, flag_missing: bool = False, content: bytes | None = None
) -> tuple[Campaign | None, tuple[Problem, ...]]:
    """Return a campaign as far as it can be read, and everything that is wrong or doubtful.

    `content` takes the place of what the campaign file contains, to check a change before it is written.
    With an error in its list, it has the trials of wrong rows too, but only those whose recordings are there, to check
    these; unknown values are NaN.
    """
    document, unread = _document(path, content)
    if document is None:
        return None, unread
    model, wrong = validate_document(CampaignFile, document)
    doubtful = (*_check_document(document), *(_check_model(document, model) if model else ()))
    settings = tuple(sorted((*wrong, *doubtful), key=lambda p: (p.line or 0, p.key, p.message)))
    trials_path, data = document.data.get("trials"), document.data.get("data", ".")
    if not isinstance(trials_path, str):
        return None, settings
    folder = Path(path).parent / (data if isinstance(data, str) else ".")
    trial_list = Path(path).parent / trials_path
    trials, found = read_trials(trial_list, folder, model or _made_out(document), _needed(document))
    problems = settings + tuple(_flagged(found) if flag_missing else found)
    if model is None or _has_error(settings):
        return None, problems
    if _has_error(problems):
        gone = {one.line for one in problems if one.code == MISSING_RECORDING}
        trials = tuple(trial for trial in trials if trial.line not in gone)
    else:
        alone = model.protocol.name in {"breakaway", "two-way"}
        problems += advise(trials, trial_list.as_posix(), rule=model.rejection, one_trial_each=alone)
    rate_Hz = model.profile.sampling_rate_Hz or model.sampling_rate_Hz
    more: dict[str, Any] = {"path": Path(path), "folder": folder, "trial_list": trial_list, "trials": trials}
    more |= {"sampling_rate_Hz": rate_Hz, "profile": replace(model.profile, sampling_rate_Hz=rate_Hz)}
    warnings = tuple(problem for problem in problems if problem.severity == "warning")
    return Campaign.model_construct(**dict(model) | more, warnings=warnings), problems


def _has_error(problems: Iterable[Problem]) -> bool:
    return any(problem.severity == "error" for problem in problems)


def _flagged(problems: Iterable[Problem]) -> Iterator[Problem]:
    """Return the problems of a list with recordings that are not there as warnings."""
    return (replace(p, severity="warning") if p.code == MISSING_RECORDING else p for p in problems)


def _document(
    path: str | os.PathLike[str], content: bytes | None
) -> tuple[TomlDocument | None, tuple[Problem, ...]]:
    """Return a campaign file as TOML with the plugins that it names loaded, or why it is none."""
    what, name = "campaign file", Path(path).as_posix()
    try:
        document = read_toml(path, what) if content is None else parse_toml(content, name, what)
    except DataError as error:
        return None, error.problems
    if is_scene(document.data):
        fix = f"use `ropefric solve {document.path}`"
        return None, (document.problem(("system",), "RF121", "this is a scene, not a campaign", fix=fix),)
    broken = load_named(document)  # what it declares is not known, so its names would be called wrong
    return (None, broken) if broken else (document, ())


def _made_out(document: TomlDocument) -> CampaignFile:
    """Return what rows depend on of a file with errors: what its wheels and cells are called, all else as by default."""
    return CampaignFile.model_construct(
        wheels=dict.fromkeys(document.table("wheels"), Round.model_construct()),
        cells=dict.fromkeys(document.table("cells")),
        rope=Rope.model_construct(),
        protocol=Protocol(),
    )


def _needed(document: TomlDocument) -> tuple[str, ...]:
    """Return the columns of the list with the tension that is known of each trial, and with its force cells."""
    needing = _cells_needed(document).items()
    named = (column for column, name in needing if name in COUNTS or document.table("cells"))
    return (*_tension_needed(document), *named)


def _tension_needed(document: TomlDocument) -> tuple[str, ...]:
    """Return the column of the list with the tension that is known of each trial, as far as the protocol is known."""
    protocol = document.table("protocol")
    name, side = protocol.get("name", "breakaway"), protocol.get("side", "slack")
    if not (isinstance(name, str) and name in protocol_names() and side in SIDES):
        return ()
    if Protocol(name=name, side=side).needs_lift_force:
        return ("lift_force_N",)
    measured = (*document.table("import", "channels"), *document.table("import", "derived"))
    is_measured = any("end_tension" in channel for channel in measured)
    return () if name == "two-way" or is_measured else ("end_tension_N",)


def _cells_needed(document: TomlDocument) -> dict[str, str]:
    """Return the columns of the list that must name a cell, with the channel that needs it."""
    channels, found = document.table("import", "channels"), dict[str, str]()
    for column, counts, force in (("cell", *COUNTS[:1], "force"), ("end_cell", *COUNTS[1:], "end_tension")):
        given = channels.get(force)
        volts = isinstance(given, dict) and not given.get("sensitivity") and str(given.get("unit", ""))
        if counts in channels:
            found[column] = counts
        elif volts and signal_unit(force, volts):
            found[column] = force
    return found


def _check_document(document: TomlDocument) -> Iterator[Problem]:
    """Yield contradictions between the tables of a campaign file."""
    needed = [*_cells_needed(document).values()]
    for name in needed[:1]:
        key, what = ("import", "channels", name), "counts" if name in COUNTS else "volts"
        if what == "counts" and "adc" not in document.data:
            fix = 'add [adc] with bits = 10, low = "0 V", high = "5 V"'
            yield document.problem(key, "RF121", "recordings in counts need the table [adc]", fix=fix)
        if not document.data.get("cells"):
            fix, missing = 'add [cells.K1] with full_scale = "1 kN"', "a force cell"
            if what == "volts":
                missing = "its sensitivity, or a force cell"
                fix = (
                    f'write sensitivity = "25 N/mV" beside the unit, or {fix}, and name the cell in the list'
                )
            yield document.problem(key, "RF121", f"a force in {what} needs {missing}", fix=fix)
    yield from dict.fromkeys(_check_formulas(document))
    name = document.data.get("data", ".")
    folder = Path(document.path).parent / (name if isinstance(name, str) else "")
    if kind_of_file(folder) != "folder":
        fix = "write the folder relative to the campaign file"
        yield document.problem(("data",), "RF106", f"there is no folder {folder.as_posix()}", fix=fix)


def _check_formulas(document: TomlDocument) -> Iterator[Problem]:
    """Try every formula on recordings without a single value, so that only the formula itself can fail."""
    nothing = np.full(3, math.nan)
    known = dict.fromkeys(document.table("import", "channels"), nothing)
    constants = dict.fromkeys(document.table("import", "constants"), math.nan)
    for name, formula in document.table("import", "derived").items() if known else ():
        try:
            evaluate_derived({name: formula} if isinstance(formula, str) else {}, known, constants)
        except DataError as error:
            key = ("import", "constants") if "constants" in error.problem.key else ("import", "derived", name)
            yield document.problem(key, error.code, error.problem.message, fix=error.fix)
        known[name] = nothing


def _check_model(document: TomlDocument, model: CampaignFile) -> Iterator[Problem]:
    """Yield errors and warnings of a campaign file whose tables are right by themselves."""
    warn = partial(document.problem, warning=True)
    profile_Hz, rate_Hz = model.profile.sampling_rate_Hz, model.sampling_rate_Hz
    if profile_Hz is not None and rate_Hz is not None and profile_Hz != rate_Hz:
        message = f"{profile_Hz:g} Hz, but [sampling] rate is {rate_Hz:g} Hz"
        yield document.problem(("import", "sampling_rate"), "RF111", message, fix="remove one of the two")
    protocol = model.protocol.name
    idle = {"side"} if protocol != "held" else {"min_step", "ending"}
    if protocol == "two-way":
        idle |= {"min_step", "ending"}
    for key in sorted(idle & document.table("protocol").keys()):
        yield warn(("protocol", key), "RF141", f"has no effect for protocol '{protocol}'", fix="remove it")
    for name, wheel in model.wheels.items():
        if doubt := radius_doubt(wheel.radius_m):
            yield warn(("wheels", name), "RF140", doubt, fix="check the unit")
    for name, cell in model.cells.items():  # one warning a cell, with every key that is missing
        said = [f'{key} = "{100.0 * getattr(cell, key):g} %FS"' for key in cell.assumed]
        if said:
            fix = f"write what the data sheet states, such as {said[0]}"
            yield warn(("cells", name), "RF142", f"not stated, so assumed: {', '.join(said)}", fix=fix)
