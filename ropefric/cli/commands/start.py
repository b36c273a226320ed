"""The commands before a campaign: templates, a look at a recording, a check, a virtual rig, a plugin tried."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from typer import Argument, Option

from ropefric.cli import on_first_use, options
from ropefric.cli.options import Answer, Number, Words, command, exit_code_of, flag, listed, option, quantity
from ropefric.cli.output import PIPE_WIDTH, Output, Progress
from ropefric.errors import DataError, InputError, Problem, raise_problems
from ropefric.files.disk import write_file
from ropefric.glossary import counted

with on_first_use():
    from ropefric import section, testing
    from ropefric.files import toml
    from ropefric.fitting import resolution
    from ropefric.friction import condition as conditions
    from ropefric.rig import campaign as rigs
    from ropefric.scenes import keys as scene_keys
    from ropefric.scenes import scene as scenes
    from ropefric.scenes import scene_templates
    from ropefric.trials import campaign as campaigns
    from ropefric.trials import campaign_model, outliers, proposal, workers
    from ropefric.trials import extract as extracting
    from ropefric.trials import table as tables

if TYPE_CHECKING:
    from ropefric.traces.readers.inspection import ColumnSummary, Inspection
    from ropefric.traces.readers.profile import ImportProfile


@command("ropefric init my-scenes --scene hoist", order=10)
def init(
    out: Output,
    *,
    folder: Path = Argument(Path(), help="Where to write them; made where it is missing."),
    scenes: bool = flag("--scenes", "Write all scenes instead of a campaign."),
    scene: Words = listed(
        "NAME",
        "Write this scene and print all keys of its system: hoist, belt-press, band-saw, traction, belt-drive, …",
        "--scene",
    ),
    recordings: str = option(
        "GLOB", "Begin with these recordings: a folder, or 'daq/*.csv' (in quotes).", "--from", default=""
    ),
    pattern: str = option(
        "PATTERN",
        "Settings in the file names, as headers of the list: '{wheel}_{wrap_angle_deg}deg_{end_tension_N}N_{repeat}'.",
        default="",
    ),
    force: bool = flag("--force", "Write over files that are already there."),
) -> Answer:
    """Write commented templates to fill in: a campaign, or with --scenes machines to solve: hoists, presses, ….

    With --from the command reads recordings. It writes a list of trials with a row for each, finds the section that
    reads them, and lists its assumptions. With --pattern it takes wheel, wrap and load from the file names.
    """
    if scenes or scene:
        return _write_scenes(out, folder, () if scenes else scene or (), overwrite=force)
    found: dict[str, Any] = {}
    if recordings:
        proposed = proposal.propose_campaign(recordings, pattern, folder)
        found = {"trials": proposed.trials, "section": proposed.section}
        for line in proposed.said:
            out.note(line)
    elif pattern:
        fix = "add --from 'daq/*.csv'"
        raise InputError("a pattern of names needs recordings", key="--pattern", fix=fix)
    written = campaigns.write_templates(folder, overwrite=force, **found)
    names = "" if pattern or not recordings else " (--pattern takes them from the file names)"
    check = f"ropefric check {quote(str(folder / 'campaign.toml'))}"
    out.note(f"next: enter the rope, the wheels and the settings of each trial{names}, then  {check}")
    return Answer({"written": written}, "\n".join(f"wrote {path}" for path in written))


def _write_scenes(out: Output, folder: Path, names: Sequence[str], *, overwrite: bool) -> Answer:
    """Write scenes, all where none is named, and print the keys of those that are named."""
    written = scene_templates.write_scenes(folder, names, overwrite=overwrite)
    keys = scene_keys.keys_of(names) if names else {}
    for system, rows in keys.items():
        cells = [(row.name, row.unit, row.default, row.meaning) for row in rows]
        title = f"all keys of a scene with system = {system!r}:"
        headings = ("key", "unit", "default", "meaning")
        out.note(section.as_text([section.Section(title, (), headings, cells, left=4)]).rstrip("\n"))
    first = folder / "hoist.toml"
    out.note(f"next: ropefric solve {quote(str(first if first in written else written[0]))}")
    trees = {system: [row._asdict() for row in rows] for system, rows in keys.items()}
    data = {"written": written, **({"keys": trees} if trees else {})}
    return Answer(data, "\n".join(f"wrote {path}" for path in written))


_MARKS = {"\t": "tab", " ": "space", ",": "comma", ";": "semicolon", ".": "point", "|": "bar"}


@command("ropefric inspect run07.csv --write-profile import.toml", order=20)
def inspect(
    out: Output,
    file: Path = Argument(..., metavar="FILE", help="A recording."),
    *,
    file_format: str = option(
        "NAME", "Format of the file, if its name does not show it: delimited, …", "--format", default="auto"
    ),
    write_profile: Path | None = option("PATH", "Write the suggested [import] section there."),
    force: bool = flag("--force", "Write over a file that is already there."),
    profile_file: Path | None = option("PATH", "Try the [import] section of this TOML file.", "--profile"),
    memory: Number = quantity("--memory", "byte", "Most memory that reading it may take [2 GB]."),
    time: Number = quantity("--time", "s", "Most time that reading it may take [120 s]."),
) -> Answer:
    """Look at a recording: columns, units, ranges, first rows, doubts, and the profile to read it with.

    Paste the section into campaign.toml, after checking the doubts.
    """
    from ropefric.traces.readers.profile import ImportProfile, profile_to_toml  # noqa: PLC0415  (quick start-up)

    if file.is_dir():
        raise DataError(
            "this is a folder, not a recording",
            path=file,
            fix=f"name one file of it, or `ropefric check {file}`",
        )
    options.refuse_file(write_profile, file, force=force)
    given = {"memory_bytes": memory, "time_s": time}
    limits = workers.Limits(**{name: value for name, value in given.items() if value is not None})
    # By a process that may die of it.
    known = campaigns.load_about(profile_file).profile if profile_file else ImportProfile()
    if file_format != "auto":
        known = replace(known, format=file_format)
    look = partial(_inspect, file, known)
    ((_, found),) = workers.guarded(look, 1, limits=limits)
    if isinstance(found, workers.Lost):
        raise DataError(found.reason, code="RF101", path=file, fix=found.fix)
    profile = profile_to_toml(found.profile)
    if write_profile is not None:
        write_file(write_profile, profile)
        out.note(f"wrote {write_profile}")
    return Answer(found.to_dict(), _sections(found, profile))


def _inspect(file: Path, profile: "ImportProfile", _: int) -> "Inspection":
    from ropefric.traces.readers.inspection import inspect_file  # noqa: PLC0415

    return inspect_file(file, profile)


def _sections(found: "Inspection", profile: str) -> list["section.Section"]:
    """Return what was found out about a file: how it is written, its columns, its first rows, what to check."""
    first, hidden = _first_rows(found)
    notes = [f"({hidden} more columns)"] if hidden > 0 else []
    notes += [f"recognised: {note}" for note in found.notes]
    tried = [f"read {found.read}"] if found.read else [f"not read: {found.stopped}"] if found.stopped else []
    suggested = ["suggested for campaign.toml:", "", *profile.rstrip().split("\n")]
    told = [
        section.Section(lines=(_headline(found),), verbatim=True),
        _columns(found),
        first,
        section.Section(lines=notes, verbatim=True),
        section.Section("please check", notes=found.doubts),
        section.Section(lines=tried, verbatim=True),
        section.Section(lines=suggested, verbatim=True),
    ]
    return [one for one in told if one.rows or one.notes or (one.lines and not one.headings)]


def _columns(found: "Inspection") -> "section.Section":
    """Return a row for each column of the file, without fields that are empty for all."""
    table = [
        ("no.", "column ", "unit ", "from", "to", "missing", "holds "),
        *map(_column_row, found.columns),
    ]
    filled = [place for place, (_, *cells) in enumerate(zip(*table, strict=True)) if any(cells)]
    headings, *rows = ([row[place] for place in filled] for row in table)
    return section.Section(headings=headings, rows=rows, left=0)


def _first_rows(found: "Inspection") -> tuple["section.Section", int]:
    """Return the first rows, of as many columns as there is room for, and how many columns are left out."""
    names = [column.name or f"({column.number})" for column in found.columns]
    first = [[*row[: len(names)], *[""] * (len(names) - len(row))] for row in found.first_rows]
    widths = [max(map(len, column)) + 2 for column in zip(names, *first, strict=True)]
    room = PIPE_WIDTH + 2
    fitting = sum(total <= room for total in accumulate(widths))
    rows = [row[:fitting] for row in first]
    hidden = max(map(len, found.first_rows), default=0) - fitting
    return section.Section("", ("first rows:", ""), names[:fitting], rows, left=0), hidden


def _headline(found: "Inspection") -> str:
    facts = [found.format, f"{found.n_rows} rows"]
    if found.samples:
        names = ", ".join(found.samples[:12]) + (" …" if len(found.samples) > 12 else "")
        where = " side by side" if found.format == "wide" else ""
        facts.append(f"{len(found.samples)} recordings{where} ({names})")
    marks = {"separator": found.separator, "decimal": found.decimal}
    facts += [f"{what} {_MARKS.get(mark, mark)}" for what, mark in marks.items() if mark]
    if found.encoding:
        facts.append(found.encoding)
    if found.header_row:
        facts.append(f"header in line {found.header_row}")
    if found.sampling_rate_Hz is not None:
        steps = "uniform" if found.is_uniform else "not uniform"
        facts.append(f"{found.sampling_rate_Hz:.5g} Hz, {steps}")
    return f"{found.file}: {', '.join(facts)}"


def _column_row(column: "ColumnSummary") -> tuple[str, ...]:
    holds = "whole numbers" if column.is_integer else "numbers" if column.is_numeric else "text"
    limits = (
        "" if limit is None else section.plain(limit, ".6g") for limit in (column.minimum, column.maximum)
    )
    return str(column.number), column.name, column.unit, *limits, str(column.n_missing or ""), holds


@command("ropefric check data/prth-bench/campaign.toml", order=30)
def check(
    out: Output,
    campaign: Path = Argument(
        ...,
        metavar="CAMPAIGN.toml|SCENE.toml|TABLE.csv",
        help="A campaign: its file or its folder. Or a scene; or a trial table, or a list of conditions.",
    ),
) -> Answer:
    """List all errors and warnings of a campaign at once, and summarise its contents.

    One recording of every kind is opened and read. A scene is checked too, and a trial table (CSV, Excel or Parquet).
    For a campaign or a table, with or without forces, it lists the laws and parameters that can be determined.
    Nothing is extracted, fitted, solved or written. Exit code 3 if there are errors; warnings alone leave it at 0.
    """
    file = options.campaign_file(campaign, or_table=True)
    kind = "table" if file.suffix not in {"", ".toml"} else "scene" if _is_scene(file) else "campaign"
    problems, content = {"scene": _check_scene, "table": _check_table, "campaign": _check_campaign}[kind](
        file
    )
    n_errors = sum(problem.severity == "error" for problem in problems)
    if not out.json:
        out.problems(problems)
    summary = f"{file}: {counted(n_errors, 'error')}, {counted(len(problems) - n_errors, 'warning')}"
    told = [problem.to_dict() | {"severity": problem.severity} for problem in problems]
    data: dict[str, Any] = {"ok": n_errors == 0, "problems": told}
    try:
        raise_problems(problems)
    except DataError as failure:
        return Answer(data | failure.to_dict(), summary, DataError.exit_code)
    if kind == "scene":
        return Answer(data, summary)
    return Answer(data | {kind: content}, "\n".join([summary, *_content_lines(content)]))


_Checked = tuple[tuple[Problem, ...], dict[str, Any]]


def _check_scene(file: Path) -> _Checked:
    return scenes.check_scene(file), {}


def _check_table(file: Path) -> _Checked:
    try:
        listed = resolution.read_list(file)
    except DataError as error:
        return error.problems, {}
    return listed.warnings, _content_of_table(listed)


def _check_campaign(file: Path) -> _Checked:
    found, problems = campaigns.examine_campaign(file)
    looked, unread = extracting.check_recordings(found) if found else ((), ())
    if found is None or any(problem.severity != "warning" for problem in problems):
        return (*problems, *unread), {}
    tells = [item.to_dict() for item in resolution.outlook_of_campaign(found)]
    return (*problems, *unread), _content(found) | {"recordings": list(looked), "tells": tells}


def _is_scene(path: Path) -> bool:
    """Return whether a file is a scene; a file that cannot be read is left to the check of campaigns."""
    try:
        return toml.is_scene(toml.read_toml(path).data)
    except DataError:
        return False


def _content(campaign: "campaign_model.Campaign") -> dict[str, Any]:
    """Return what a campaign holds, in SI: trials, conditions, radii, wraps, end tensions, repeats."""
    trials = campaign.trials
    keys = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N", "lift_force_N")
    settings = [[getattr(trial, key) or 0.0 for trial in trials] for key in keys]
    repeats = Counter(conditions.condition_groups(*settings).tolist() if trials else ())
    return {
        "name": campaign.name,
        "n_trials": len(trials),
        "n_files": len({t.path for t in trials}),
        "n_excluded": sum(bool(t.exclude) for t in trials),
        "n_conditions": len(repeats),
        "repeats": {"fewest": min(repeats.values(), default=0), "most": max(repeats.values(), default=0)},
        **{key: sorted({value for t in trials if (value := getattr(t, key)) is not None}) for key in keys},
        "rejection": campaign.rejection,
    }


def _content_lines(content: dict[str, Any]) -> list[str]:
    """Return the contents of a campaign or table in practical units, and what they can determine."""
    fewest, most = content["repeats"]["fewest"], content["repeats"]["most"]
    rows = [
        ("conditions", f"{content['n_conditions']}"),
        ("repeats", f"{fewest}" if fewest == most else f"{fewest} to {most} per condition"),
        ("wheel radius R_w", _listed(content["wheel_radius_m"], 1e3, "mm")),
        ("rope radius R_r", _listed(content["rope_radius_m"], 1e3, "mm")),
        ("wrap φ", _listed(content["wrap_angle_rad"], math.degrees(1.0), "deg")),
        ("end tension F_B", _listed(content["end_tension_N"], 1.0, "N")),
    ]
    if "rejection" in content:
        rows = _rows_of_campaign(content, rows, most)
    else:
        forces = "" if content["n_forces"] else ", without forces"
        rows.insert(0, ("trials", f"{content['n_trials']}{forces}"))
    told = [f"{name:<18} {text}" for name, text in rows if text]
    if content["tells"]:
        usual = f"{100.0 * resolution.TYPICAL_BETWEEN:g} % between conditions"
        scatter = f"{100.0 * resolution.TYPICAL_WITHIN:g} % between repeats, {usual}"
        if (within := content.get("scatter_within")) is not None:
            scatter = f"{usual}; between repeats, as here, {100.0 * within:.2g} %"
        told.append(f"what this plan can distinguish at typical scatter ({scatter}):")
        told += [*(f"  {item['text']}" for item in content["tells"]), f"  ({resolution.SCALE})"]
    return told + [f"read {line}" for line in content.get("recordings", ())]


def _rows_of_campaign(
    content: dict[str, Any], rows: list[tuple[str, str]], most: int
) -> list[tuple[str, str]]:
    """Return the rows of a campaign: name and trials, conditions, wanted lift force, outlier rule."""
    good_lost = outliers.RULES[content["rejection"]].good_lost(most)
    lost = f", rejects {good_lost:.2g} of {most} good trials on average" if good_lost > 0.0 else ""
    excluded = f", {content['n_excluded']} of them excluded" if content["n_excluded"] else ""
    trials = f"{content['n_trials']} in {content['n_files']} files{excluded}"
    asked = _listed(content["lift_force_N"], 1.0, "N")
    before = [("campaign", content["name"] or "(no name)"), ("trials", trials)]
    return [*before, *rows, ("lift force F_A", asked), ("rejection", f"{content['rejection']}{lost}")]


def _content_of_table(table: "tables.TrialTable") -> dict[str, Any]:
    """Return the used contents of a table, or of a list without forces, and what they can determine."""
    (settings, group), within = resolution.listed(table), resolution.scatter_of_repeats(table)
    repeats = Counter(group.tolist())
    return {
        "n_trials": group.size,
        "n_conditions": len(repeats),
        "repeats": {"fewest": min(repeats.values()), "most": max(repeats.values())},
        **{name: conditions.distinct(values).tolist() for name, values in settings.items()},
        "n_forces": int(table.used.sum()),
        "scatter_within": None if math.isnan(within) else within,
        "tells": [item.to_dict() for item in resolution.outlook_of_table(table)],
    }


def _listed(values: Iterable[float], factor: float, unit: str) -> str:
    """Return values as a list with their unit; of very many only how many and their limits."""
    texts = list(dict.fromkeys(f"{value * factor:.6g}" for value in values))
    if len(texts) > 12:
        return f"{len(texts)} values from {texts[0]} to {texts[-1]} {unit}"
    return f"{', '.join(texts)} {unit}" if texts else ""


@command("ropefric simulate my-bench --seed 7 --repeats 6", order=40)
def simulate(
    out: Output,
    folder: Path = Argument(Path("simulated"), help="A new or empty folder."),
    *,
    seed: int | None = Option(
        None, min=0, help="The same seed writes the same bytes; default: the bench's own."
    ),
    law: str = Option("", help="The friction law that is true, instead of the bench's own."),
    parameter: Words = listed("NAME=VALUE", "A true parameter of the law", "--parameter", "-p"),
    repeats: int | None = Option(None, min=1, help="Recordings per condition."),
    conditions: int | None = Option(None, min=1, help="Only this many conditions, the first ones."),
    fault: Words = listed("NAME=RATE", "Only this fault, at this rate (0 to 1)"),
    no_faults: bool = flag("--no-faults", "Nothing goes wrong."),
) -> Answer:
    """Simulate a campaign with known truth: campaign.toml, trials.csv, recordings and truth.toml.

    Rope and cell stiffness, motor ramp, scatter, stick-slip, noise, converter and the usual faults are simulated.
    Without options it writes data/prth-bench again, byte for byte.
    """
    plan = rigs.prth_bench_plan()
    changes = _of_law(plan, law, parameter or ())
    if repeats is not None:
        changes["repeats"] = repeats
    if conditions is not None:
        changes["conditions"] = plan.conditions[:conditions]
    if fault is not None or no_faults:
        changes["faults"] = options.parse_assignments(fault or (), option="--fault")
    plan = replace(plan, **changes)
    seed = rigs.PRTH_SEED if seed is None else seed
    with Progress(out, "simulate") as progress:
        written = rigs.simulate_campaign(folder, plan, seed=seed, progress=progress.update)
    campaign = next(path for path in written if path.name == "campaign.toml")
    out.note(f"next: ropefric extract {quote(str(campaign))} --out out")
    planned = ("law", "parameters", "faults", "n_trials")
    data = {"campaign": campaign, "bench": "prth-bench", "seed": seed, "n_conditions": len(plan.conditions)}
    data |= {name: getattr(plan, name) for name in planned}
    made = f"{counted(plan.n_trials, 'recording')} of {counted(len(plan.conditions), 'condition')}"
    return Answer(data, f"{made}, law {plan.law}, seed {seed} → {campaign}")


def _of_law(plan: "rigs.CampaignPlan", law: str, parameter: Iterable[str]) -> dict[str, Any]:
    """Return what a law that is true instead, or other parameters of the bench's own, change of a plan."""
    given = options.parse_assignments(parameter, option="--parameter")
    if law and law != plan.law:
        return {"law": law, "parameters": given}
    return {"parameters": {**plan.parameters, **given}} if given else {}


@command("ropefric check-plugin my_law.py", order=200)
def check_plugin(
    out: Output,
    plugin_file: str = Argument(metavar="PLUGIN.py", help="The plugin, a Python file."),
    *,
    files: list[Path] | None = option(
        "FILE", "A recording its reader, or a scene its machine, is tried on; repeatable.", "--file"
    ),
) -> Answer:
    """Try a plugin: whether its laws, readers, rules, protocols and machines keep the promises that ours keep.

    Exits with 4 when one is broken. A reader is tried on garbage alone, and a machine not at all, until --file names a
    recording or a scene.
    """
    plugin, findings = testing.check_plugin(plugin_file, tuple(files or ()))
    slots = {said.partition(" ")[0] for said in plugin.declares} & testing.FILE_CHECKS.keys()
    if slots and not files:
        out.note(
            f"{plugin.source}: give --file, a recording or a scene of its own, to see {', '.join(sorted(slots))} at work"
        )
    broken = [one for one in findings if one.broken]
    rows = [(one.member, "BROKEN" if one.broken else "kept", one.promise) for one in findings]
    table = section.Section(
        title=f"{plugin.source}: {len(findings) - len(broken)} of {len(findings)} promises are kept",
        headings=("declares", "", "promise"), rows=rows, left=3,
    )  # fmt: skip
    lines = tuple(f"{one.member}: {one.broken}" for one in broken)
    shown = [table, *([section.Section(title="Broken promises", lines=lines)] if lines else [])]
    data = {"plugin": plugin.to_dict(), "ok": not broken, "promises": [one._asdict() for one in findings]}
    return Answer(data, shown, exit_code_of(not broken))
