"""From campaign.toml and its trial list to a `Campaign`, or to everything that is wrong with them."""

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from ropefric.errors import DataError, Problem, UnknownNameError, raise_problems
from ropefric.registry import did_you_mean
from ropefric.traces.breakaway import SIDES
from ropefric.trials.campaign_checks import check_settings
from ropefric.trials.campaign_model import (
    Campaign,
    DesignSpec,
    ProtocolSpec,
    RopeSpec,
    SmoothingSpec,
    WheelSpec,
)
from ropefric.trials.campaign_schema import CampaignFile, protocol_names
from ropefric.trials.file_kind import is_scene
from ropefric.trials.toml_document import TomlDocument, read_toml
from ropefric.trials.toml_validation import validate_document
from ropefric.trials.trial_advice import advise
from ropefric.trials.trial_files import MISSING_RECORDING
from ropefric.trials.trial_list import TrialContext, read_trials
from ropefric.trials.trial_spec import TrialSpec

MISSING_WAYS = ("error", "flag")


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
    >>> from ropefric.trials.campaign_templates import write_templates
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path, _ = write_templates(folder)
    ...     recording = Path(folder) / "recordings" / "pull_01.csv"
    ...     recording.parent.mkdir()
    ...     _ = recording.write_text("time_s,force_N")
    ...     campaign = load_campaign(path)
    >>> campaign.rope.radius_m, campaign.trials[0].trial, campaign.trials[0].end_tension_N
    (0.0049, 'pull_01', 80.0)
    """
    if missing_recordings not in MISSING_WAYS:
        fix = did_you_mean(missing_recordings, MISSING_WAYS)
        raise UnknownNameError(f"unknown word {missing_recordings!r}", key="missing_recordings", fix=fix)
    campaign, problems = _read(path, flag_missing=missing_recordings == "flag")
    raise_problems(problems)
    if campaign is None:  # pragma: no cover - no campaign without an error would be our own mistake
        raise DataError("the campaign cannot be read", path=str(path))
    return campaign


def check_campaign(path: str | os.PathLike[str]) -> tuple[Problem, ...]:
    """Return everything that is wrong or doubtful: the campaign file's by line, then the trial list's."""
    return _read(path)[1]


def _read(
    path: str | os.PathLike[str], *, flag_missing: bool = False
) -> tuple[Campaign | None, tuple[Problem, ...]]:
    try:
        document = read_toml(path, "campaign file")
    except DataError as error:
        return None, error.problems
    if is_scene(document.data):
        fix = f"use `ropefric solve {document.path}`"
        return None, (document.problem(("system",), "RF121", "this is a scene, not a campaign", fix=fix),)
    model, wrong = validate_document(CampaignFile, document)
    doubtful = check_settings(document, model)
    settings = tuple(sorted((*wrong, *doubtful), key=lambda p: (p.line or 0, p.key, p.message)))
    trials_path = document.data.get("trials")
    if not isinstance(trials_path, str):
        return None, settings
    parent = Path(path).parent
    trials, rows = read_trials(parent / trials_path, _context(document, model, parent))
    if flag_missing:
        rows = tuple(replace(p, severity="warning") if p.code == MISSING_RECORDING else p for p in rows)
    problems = settings + rows
    if model is None or any(problem.severity == "error" for problem in problems):
        return None, problems
    shown = (parent / trials_path).as_posix()
    one_each = model.protocol.name == "breakaway"
    problems += advise(trials, shown, rule=model.rejection.rule, one_trial_each=one_each)
    return _campaign(Path(path), model, trials, problems), problems


def _context(document: TomlDocument, model: CampaignFile | None, parent: Path) -> TrialContext:
    """Return what rows depend on, from the checked file or, where that has errors, from what can be made out."""
    data = document.data.get("data", ".")
    folder = parent / (data if isinstance(data, str) else ".")
    sizes = {name: wheel.radius_m() for name, wheel in model.wheels.items()} if model else {}
    return TrialContext(
        folder=folder,
        folder_exists=_is_dir(folder),
        wheels={name: sizes.get(name) for name in document.table("wheels")},
        cells=tuple(document.table("cells")),
        rope_radius_m=model.rope.radius_m() if model else None,
        needs_lift_force=_needs_lift_force(document.table("protocol")),
        needs_cell="counts" in document.table("import", "channels"),
        start_s=model.protocol.start if model else None,
        stop_s=model.protocol.until if model else None,
    )


def _needs_lift_force(protocol: Mapping[str, Any]) -> bool | None:
    name, side = protocol.get("name", "breakaway"), protocol.get("side", "slack")
    if not isinstance(name, str) or name not in protocol_names() or side not in SIDES:
        return None
    return ProtocolSpec(name=name, side=side).needs_lift_force


def _is_dir(path: Path) -> bool:
    try:
        return path.is_dir()
    except OSError:
        return False


def _campaign(
    path: Path, model: CampaignFile, trials: tuple[TrialSpec, ...], problems: tuple[Problem, ...]
) -> Campaign:
    rate_Hz = model.sampling.rate if model.sampling else None
    profile = model.import_.profile(rate_Hz)
    mode, window_s = model.smoothing.window
    return Campaign(
        path=path,
        folder=path.parent / model.data,
        name=model.name,
        schema=model.schema_name,
        rope=RopeSpec(
            radius_m=model.rope.radius_m(),
            linear_density_kg_m=model.rope.linear_density,
            material=model.rope.material,
        ),
        wheels={
            name: WheelSpec(radius_m=wheel.radius_m(), material=wheel.material)
            for name, wheel in model.wheels.items()
        },
        cells={name: cell.cell(name) for name, cell in model.cells.items()},
        adc=model.adc.adc() if model.adc else None,
        protocol=ProtocolSpec(
            name=model.protocol.name,
            start_s=model.protocol.start,
            stop_s=model.protocol.until,
            min_step_N=model.protocol.min_step,
            side=model.protocol.side,
            ending=model.protocol.ending,
        ),
        sampling_rate_Hz=profile.sampling_rate_Hz,
        tare_interval_s=model.tare.interval if model.tare else None,
        smoothing=SmoothingSpec(mode=mode, window_s=window_s, peak=model.smoothing.peak),
        rejection=model.rejection.rule,
        weights_tolerance=model.weights.tolerance if model.weights else 0.0,
        design=_design(model),
        profile=profile,
        limits=model.limits.limits(),
        trials=trials,
        warnings=tuple(problem for problem in problems if problem.severity == "warning"),
    )


def _design(model: CampaignFile) -> DesignSpec | None:
    design = model.design
    if design is None:
        return None
    return DesignSpec(
        wheel_radius_m=design.wheel_radius,
        wrap_angle_rad=design.wrap_angle,
        end_tension_N=design.end_tension,
    )
