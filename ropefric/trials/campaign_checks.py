"""Whether the tables of a campaign file fit together and point at what exists."""

import math
import re
from pathlib import Path

import numpy as np

from ropefric.errors import DataError, Problem
from ropefric.traces.derived import evaluate_derived
from ropefric.trials.campaign_schema import CampaignFile
from ropefric.trials.toml_document import TomlDocument
from ropefric.trials.trial_advice import radius_doubt

_NAME = re.compile(r"\w+")
_SET_BY_TRIAL = {
    "end_tension": "end_tension_N",
    "lift_force": "lift_force_N",
    "wrap_angle": "wrap_angle_deg",
    "wrap": "wrap_angle_deg",
}


def check_settings(document: TomlDocument, model: CampaignFile | None) -> tuple[Problem, ...]:
    """Return problems between the tables of a campaign file."""
    problems = _converter(document) + _formulas(document) + _folder(document)
    if model is not None:
        problems += _sampling(document, model) + _idle_keys(document, model) + _wheels(document, model)
        problems += _cells(document, model)
        problems += _idle_channels(document, model)
    return tuple(problems)


def _converter(document: TomlDocument) -> list[Problem]:
    if "counts" not in document.table("import", "channels"):
        return []
    key = ("import", "channels", "counts")
    problems = []
    if "adc" not in document.data:
        fix = 'add [adc] with bits = 10, low = "0 V", high = "5 V"'
        problems.append(document.problem(key, "RF121", "recordings in counts need the table [adc]", fix=fix))
    if not document.data.get("cells"):
        fix = 'add [cells.K1] with full_scale = "1 kN"'
        problems.append(document.problem(key, "RF121", "recordings in counts need a force cell", fix=fix))
    return problems


def _formulas(document: TomlDocument) -> list[Problem]:
    """Try every formula on recordings without a single value: what is left to fail is the formula itself."""
    channels = document.table("import", "channels")
    if not channels:
        return []  # the reader goes by the file's headers, which are not known here
    constants = dict.fromkeys(document.table("import", "constants"), math.nan)
    known = {name: np.full(3, np.nan) for name in channels}
    problems = []
    for name, formula in document.table("import", "derived").items():
        if not isinstance(formula, str):
            continue
        try:
            evaluate_derived({name: formula}, known, constants)
        except DataError as error:
            key = ("import", "constants") if "constants" in error.problem.key else ("import", "derived", name)
            problems.append(document.problem(key, error.code, error.problem.message, fix=error.fix))
        known[name] = np.full(3, np.nan)
    return list(dict.fromkeys(problems))


def _folder(document: TomlDocument) -> list[Problem]:
    name = document.data.get("data", ".")
    if not isinstance(name, str):
        return []
    folder = Path(document.path).parent / name
    try:
        if folder.is_dir():
            return []
    except (OSError, ValueError):
        pass
    fix = "write the folder relative to the campaign file"
    return [document.problem(("data",), "RF106", f"there is no folder {folder.as_posix()}", fix=fix)]


def _sampling(document: TomlDocument, model: CampaignFile) -> list[Problem]:
    profile_Hz = model.import_.sampling_rate
    if model.sampling is None or profile_Hz is None or profile_Hz == model.sampling.rate:
        return []
    message = f"{profile_Hz:g} Hz, but [sampling] rate is {model.sampling.rate:g} Hz"
    return [document.problem(("import", "sampling_rate"), "RF111", message, fix="remove one of the two")]


def _idle_keys(document: TomlDocument, model: CampaignFile) -> list[Problem]:
    """Warn of keys that the chosen protocol does not look at."""
    given = document.data.get("protocol", {})
    name = model.protocol.name
    idle = {"side"} if name != "held" else {"min_step", "ending"}
    return [
        document.problem(
            ("protocol", key), "RF141", f"has no effect for protocol '{name}'", fix="remove it", warning=True
        )
        for key in sorted(idle & given.keys())
    ]


def _cells(document: TomlDocument, model: CampaignFile) -> list[Problem]:
    """Warn of what a data sheet states and a cell does not: one warning a cell, with every key that is missing."""
    problems = []
    for name, table in model.cells.items():
        cell = table.cell(name)
        if not cell.assumed:
            continue
        said = [f'{key} = "{100.0 * getattr(cell, key):g} %FS"' for key in cell.assumed]
        problems.append(
            document.problem(
                ("cells", name),
                "RF142",
                f"not stated, so assumed: {', '.join(said)}",
                fix=f"write what the data sheet states, such as {said[0]}",
                warning=True,
            )
        )
    return problems


def _idle_channels(document: TomlDocument, model: CampaignFile) -> list[Problem]:
    """Warn of measured channels that the trial list sets once for each trial instead."""
    used = {name for formula in model.import_.derived.values() for name in _NAME.findall(str(formula))}
    problems = []
    for place in ("channels", "derived"):
        for name in getattr(model.import_, place):
            if name not in _SET_BY_TRIAL or name in used:
                continue
            message = (
                f"the measured {name.replace('_', ' ')} is read, but not used: that of the trial list is"
            )
            fix = f"write its value at break-away into the column {_SET_BY_TRIAL[name]} of the trial list"
            problems.append(
                document.problem(("import", place, name), "RF141", message, fix=fix, warning=True)
            )
    return problems


def _wheels(document: TomlDocument, model: CampaignFile) -> list[Problem]:
    return [
        document.problem(("wheels", name), "RF140", said, fix="check the unit", warning=True)
        for name, wheel in model.wheels.items()
        if (said := radius_doubt(wheel.radius_m()))
    ]
