"""What the pages take from the library while the site is built: figures, commands, notebooks, names, what is registered.

Nothing of this is kept in the repository, so that no figure and no option on the site can be older than the code.
"""

import asyncio
import base64
import inspect
import logging
import os
import re
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path

from pydantic import BaseModel

import ropefric as rf
from ropefric.accuracy.studies import STUDIES
from ropefric.cli.app import build_app, find_commands
from ropefric.errors import RopefricError
from ropefric.friction.laws import LAWS
from ropefric.plotting import style
from ropefric.plotting.campaign import conditions_of, draw_condition
from ropefric.plotting.figure import FigureWithData, drawing, svg_text
from ropefric.plotting.fits import draw_capstan, draw_fit_band, draw_mu_facets
from ropefric.plotting.machines import draw_sweep, scene_figures
from ropefric.rig.recording import FAULTS
from ropefric.rig.strangers import FAMILIES
from ropefric.scenes.declared import declared_keys
from ropefric.scenes.kind import Kind
from ropefric.scenes.kinds import KINDS
from ropefric.traces.breakaway import ADVICE
from ropefric.traces.protocols import PROTOCOLS
from ropefric.traces.readers import READERS
from ropefric.trials.outliers import RULES

ROOT = Path(__file__).parents[1]
BENCH = ROOT / "data" / "prth-bench" / "campaign.toml"
SCENES = ROOT / "data" / "scenes"
FITS = ROOT / "fits"
NOTEBOOKS = ROOT / "notebooks"
PAPERS = {"prth": "01_from_traces_to_lift_force", "press": "02_belt_press", "saw": "03_band_saw"}
"""The notebook that goes through each paper, by the name of its page."""


def everything(folder: Path) -> None:
    """Write all generated pages and figures; a file that would not change is left alone, so that builds stay short."""
    pages = {
        "commands.md": commands_page(),
        "python.rst": python_page(),
        "registered.md": registered_page(),
        "scene-keys.md": scene_keys_page(),
    }
    # A piece of a page becomes a file of its own.
    namespace = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    for stem, figure in figures():
        pages[f"{stem}.svg"] = svg_text(figure, stem=stem).replace("<svg", namespace, 1)
    made = {name: text.encode() for name, text in pages.items()} | paper_pages()
    folder.mkdir(exist_ok=True)
    for old in {path.name for path in folder.iterdir()} - made.keys():
        (folder / old).unlink()
    for name, content in made.items():
        path = folder / name
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)


# Figures.


def figures() -> Iterator[tuple[str, FigureWithData]]:
    """Yield every figure of the site by the name of its file."""
    yield "break-away", _break_away()
    yield "condition", _condition()
    fits = {name: rf.load_fit(FITS / f"prth-{name}.json") for name in ("constant", "wrap-power", "coupled")}
    yield "laws", draw_mu_facets([*fits.values()])
    yield "capstan", draw_capstan([fits["constant"], fits["coupled"]])
    yield "band", draw_fit_band(fits["coupled"])
    for scene, axis, quantity in (
        ("climbing-hoist", "rope.hanging_length=0.1m:25m:50", "lift_margin"),
        ("belt-press", "press.preload=1000N:4000N:61", "largest_utilisation"),
    ):
        yield scene, draw_sweep(rf.sweep(SCENES / f"{scene}.toml", axis), quantity=quantity)
    for scene in (
        "press-start-up",
        "band-saw",
        "traction",
        "belt-drive",
        "band-brake",
        "cable-pull",
        "tendon",
    ):
        for stem, figure in scene_figures(rf.solve(SCENES / f"{scene}.toml")):
            yield f"{scene}-{stem.replace('_', '-')}", figure


def _break_away() -> FigureWithData:
    """Draw one pull of the bench: what is looked at, F_A, and what a slip takes off the force."""
    trial = "c04-r02"
    trace = rf.read_trial(BENCH, trial)
    found = rf.find_breakaway(trace)
    time_s, force_N = trace.time_s, rf.smooth(trace, 0.004).force_N
    with drawing(9.0, 4.6) as (figure, axes):
        axes.plot(time_s, force_N, color=style.INK, linewidth=0.9, label="force, 4 ms means")
        for place, phase in enumerate(found.phases):
            axes.axvspan(
                phase.start_s, phase.end_s, color=style.GREY, alpha=0.07 if place % 2 else 0.16, linewidth=0
            )
            middle = 0.5 * (phase.start_s + phase.end_s)
            if phase.end_s - phase.start_s > 0.06 * time_s[-1]:
                axes.text(
                    middle, 1.02, phase.name, transform=axes.get_xaxis_transform(), ha="center", fontsize=9
                )
        axes.plot(
            found.peak_time_s, found.peak_N, "o", color=style.ORANGE, label=f"F_A = {found.peak_N:.1f} N"
        )
        axes.axhline(
            found.kinetic_N, color=style.BLUE, linestyle="--", linewidth=1.0, label="mean while sliding"
        )
        axes.axhline(
            found.trough_N,
            color=style.GREY,
            linestyle=":",
            linewidth=1.0,
            label="lowest of the first slip: F_A - k Δx",
        )
        axes.set(xlabel="Time t [s]", ylabel="Force F [N]")
        style.legend_below(axes, columns=4)
    alt = (
        f"One pull of the simulated bench: rest, loading to F_A = {found.peak_N:.1f} N, a first slip that takes "
        f"{found.drop_N:.1f} N off, then sliding about {found.kinetic_N:.1f} N."
    )
    return FigureWithData(figure=figure, tables=(), alt=alt)


def _condition() -> FigureWithData:
    campaign = rf.load_campaign(BENCH)
    few = tuple(one for one in campaign.trials if one.trial.startswith("c04"))
    ((summary, trials),) = conditions_of(rf.extract(campaign.model_copy(update={"trials": few}))).values()
    return draw_condition(summary, trials)


# Commands.


def commands_page() -> str:
    """Return the page of all commands, from what the program itself knows of them."""
    group = build_app()
    parts = ["# Commands\n", f"{group.epilog}\n"]
    for declared in find_commands().values():
        command = group.commands[declared.name]
        parts.append(f"\n## `ropefric {declared.name}`\n\n{_escaped(command.help)}\n")
        context = command.make_context(declared.name, [], resilient_parsing=True)
        context.info_name = f"ropefric {declared.name}"
        parts.append(f"```text\n{' '.join(command.get_usage(context).split())}\n```\n")
        records = [one.get_help_record(context) for one in command.params]
        rows = [(f"`{record[0].strip('{}')}`", _escaped(record[1])) for record in records if record]
        parts.append(_rows(("option", "meaning"), rows))
        parts.append(f"\nExample:\n\n```sh\n{declared.example}\n```\n")
    return "\n".join(parts)


def _escaped(text: str) -> str:
    """Return a text in which Markdown finds nothing to set."""
    for mark in "\\*_<[$`":
        text = text.replace(mark, f"\\{mark}")
    return text


# Python.


def python_page() -> str:
    """Return the page of the Python interface: the functions, and the classes that they take and return."""
    names = [name for name in rf.__all__ if not name.startswith("_")]
    parts = [
        "Python names\n============\n",
        "``import ropefric as rf`` has these functions.\n",
        _directives(names, "ropefric"),
    ]
    parts.append("\nWhat they return\n----------------\n")
    parts += [
        f".. autoclass:: {one.__module__}.{one.__qualname__}()\n   :members:\n   :exclude-members: from_dict\n"
        for one in _results(names)
    ]
    parts.append("\nErrors\n------\n")
    errors = [RopefricError, *RopefricError.__subclasses__()]
    parts += [f".. autoexception:: {one.__module__}.{one.__qualname__}()\n" for one in errors]
    return "\n".join(parts)


def _directives(names: Iterable[str], module: str) -> str:
    return "\n".join(
        f".. auto{'class' if inspect.isclass(getattr(rf, name)) else 'function'}:: {module}.{name}\n"
        for name in names
    )


def _results(names: Iterable[str]) -> list[type]:
    """Return the dataclasses that the functions return, each once, by name."""
    found = {}
    for name in names:
        function = getattr(rf, name)
        if not callable(function):
            continue
        try:
            returned = typing.get_type_hints(function).get("return")
        except NameError:  # a type that is imported for type checkers only
            continue
        for one in (returned, *typing.get_args(returned)):
            if is_dataclass(one):
                found[one.__qualname__] = one
    return [found[name] for name in sorted(found)]


# Notebooks.


def paper_pages() -> dict[str, bytes]:
    """Return the pages of the papers and their pictures by file name, from their notebooks, which are run for it."""
    # Loaded here, because the tests read this module and run no notebook.
    import nbformat  # noqa: PLC0415
    from nbclient import NotebookClient  # noqa: PLC0415

    os.environ.setdefault("JUPYTER_PLATFORM_DIRS", "1")
    logging.getLogger("traitlets").setLevel(logging.WARNING)
    notebooks = {name: nbformat.read(NOTEBOOKS / f"{stem}.ipynb", 4) for name, stem in PAPERS.items()}

    async def run() -> None:
        how = {"timeout": 600, "resources": {"metadata": {"path": str(NOTEBOOKS)}}}
        how["extra_arguments"] = ["--log-level=ERROR"]
        await asyncio.gather(*(NotebookClient(one, **how).async_execute() for one in notebooks.values()))

    asyncio.run(run())
    files: dict[str, bytes] = {}
    for name, notebook in notebooks.items():
        text = "\n\n".join(_set(notebook.cells, f"paper-{name}", files))
        files[f"paper-{name}.md"] = f"{text}\n".encode()
    return files


def _set(cells: Iterable[typing.Any], stem: str, files: dict[str, bytes]) -> Iterator[str]:
    """Yield the cells of a notebook as Markdown, each code with what it shows; pictures are added to the files."""
    for cell in cells:
        if cell.cell_type == "markdown":
            yield cell.source
            continue
        code = cell.source.removeprefix("%matplotlib inline\n")
        yield f"```python\n{code}\n```"
        # A cell that draws says in its first line what is to be seen.
        alt = (
            code.partition("\n")[0].removeprefix("# ")
            if code.startswith("# ")
            else "What the code above draws"
        )
        for place, shown in enumerate(cell.outputs):
            data = shown.get("data", {})
            if "image/png" in data:
                name = f"{stem}-{cell.id}-{place}.png"
                files[name] = base64.b64decode(data["image/png"])
                yield f"![{_escaped(alt)}]({name})"
            elif "text/html" in data:
                table = re.sub(r"<style.*?</style>", "", data["text/html"], flags=re.DOTALL)
                yield f"```{{raw}} html\n{table}\n```"
            else:
                yield f"```text\n{(shown.get('text') or data.get('text/plain', '')).rstrip()}\n```"


# What is registered.


def registered_page() -> str:
    """Return the page of everything that goes by a name: laws, formats, protocols, rules, effects, faults, studies."""
    law_rows = [
        (
            f"`{law.name}`",
            f"`{law.equation}`",
            ", ".join(f"`{one.name}`" for one in law.parameters),
            law.source,
        )
        for law in LAWS.values()
    ]
    parts = [
        "# What goes by a name\n",
        "Every name that a file or a command can hold, as this version has them.\n",
        _table("Friction laws", ("name", "equation", "parameters", "source"), law_rows),
        _table(
            "File formats",
            ("name", "what", "endings"),
            [(f"`{one.name}`", one.description, ", ".join(one.suffixes)) for one in READERS.values()],
        ),
        _described("Protocols", PROTOCOLS),
        _described("Rejection rules", RULES),
        _table(
            "Statuses of a trial",
            ("status", "meaning"),
            [(f"`{status}`", words) for status, words in ADVICE.items()],
        ),
    ]
    parts += [_effects(kind) for kind in KINDS.values()]
    faults = [(f"`{one.name}`", f"`{one.expected_status or 'ok'}`") for one in FAULTS.values()]
    parts.append(_table("Faults of the simulated bench", ("name", "what an honest reading says"), faults))
    families = [(f"`{one.name}`", one.tier, f"`{one.expects}`") for one in FAMILIES.values()]
    parts.append(
        _table("Families of the second rig's recordings", ("name", "tier", "what there is to find"), families)
    )
    parts.append(
        _table(
            "Studies of `ropefric cost`",
            ("name", "title"),
            [(f"`{one.name}`", one.title) for one in STUDIES.values()],
        )
    )
    return "\n".join(parts)


def _effects(kind: Kind) -> str:
    rows = [(f"`{one.name}`", one.adds, one.instead) for one in kind.system.effects.values()]
    return _table(f"Effects of a scene of kind `{kind.name}`", ("name", "what it adds", "in its place"), rows)


# Scenes.


_KEYS_SAID = """\
A key in a table `[wheel]` is written there; here it is named `wheel.radius`, as in a sweep and in messages. A `…` stands
for a name of yours. Quantities are text with their unit. What is not needed in its table may be left out, and an effect
that needs it is then not simulated."""


def scene_keys_page() -> str:
    """Return the page of every key that a scene can hold, by kind: unit, default, range and meaning, from the schema."""
    parts = ["# What a scene can say\n", f"{_KEYS_SAID}\n"]
    head = ("key", "unit", "such as", "if left out", "range", "meaning")
    parts += [_table(f'`system = "{kind.name}"`', head, scene_keys(kind.schema)) for kind in KINDS.values()]
    return "\n".join(parts)


def scene_keys(schema: type[BaseModel]) -> Iterator[tuple[str, ...]]:
    """Yield name, unit, example, default, range and meaning of each key of a schema, those of its tables included."""
    for one in declared_keys(schema):
        default = "needed" if one.is_needed else one.default
        # A bare value is code, a quantity words.
        default = f"`{default}`" if one.default and not one.like else default
        allowed = ", ".join(f"`{word}`" for word in one.choices) or one.allowed
        allowed = "`true` or `false`" if allowed == "true or false" else allowed
        shown = f"`{one.like}`" if one.like else ""
        yield f"`{one.name}`", one.unit, shown, default, allowed, _escaped(one.meaning)


def _described(title: str, registry: Mapping[str, typing.Any]) -> str:
    return _table(
        title, ("name", "meaning"), [(f"`{one.name}`", one.description) for one in registry.values()]
    )


def _table(title: str, head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    return f"\n## {title}\n\n{_rows(head, rows)}"


def _rows(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len([*head])}"]
    lines += [f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |" for row in rows]
    return "\n".join(lines) + "\n"
