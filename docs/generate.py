"""What the pages take from the library while the site is built: figures, commands, notebooks, names, what is registered.

Nothing of this is kept in the repository, so that no figure and no option on the site can be older than the code.
"""

import asyncio
import base64
import inspect
import logging
import os
import re
import tomllib
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path

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
from ropefric.scenes.keys import scene_keys
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
PAPERS = {
    "prth": ("01_from_traces_to_lift_force", "## 6 ", "## 7 "),
    "press": ("02_belt_press", "## 4 ", "## 6 "),
    "saw": ("03_band_saw", "## 4 "),
}
"""The notebook that goes through each paper, by the name of its page, and where its further pages begin."""


def everything(folder: Path) -> None:
    """Write all generated pages and figures; a file that would not change is left alone, so that builds stay short."""
    pages = command_pages() | python_pages() | registered_pages() | scene_keys_pages()
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


def command_pages() -> dict[str, str]:
    """Return the page that lists all commands, and one of each, from what the program itself knows of them."""
    group, pages, rows = build_app(), {}, []
    for declared in find_commands().values():
        command = group.commands[declared.name]
        context = command.make_context(declared.name, [], resilient_parsing=True)
        context.info_name = f"ropefric {declared.name}"
        records = [one.get_help_record(context) for one in command.params]
        options = [(f"`{record[0].strip('{}')}`", _escaped(record[1])) for record in records if record]
        pages[f"command-{declared.name}"] = (
            f"# `ropefric {declared.name}`\n\n{_escaped(command.help)}\n\n"
            f"```text\n{' '.join(command.get_usage(context).split())}\n```\n\n"
            f"{_rows(('option', 'meaning'), options)}\nExample:\n\n```sh\n{declared.example}\n```\n"
        )
        rows.append((f"[`{declared.name}`](command-{declared.name}.md)", _escaped(command.short_help)))
    return _with_list("commands", f"# Commands\n\n{group.epilog}\n", ("command", "purpose"), rows, pages)


def _with_list(
    name: str, begins: str, head: tuple[str, str], rows: Iterable[tuple[str, str]], pages: Mapping[str, str]
) -> dict[str, str]:
    """Return the files of pages and of the page that lists them."""
    listed = "\n".join(pages)
    contents = f"```{{toctree}}\n:hidden:\n\n{listed}\n```"
    whole = {f"{name}.md": f"{begins}\n{_rows(head, rows)}\n{contents}\n"}
    return whole | {f"{stem}.md": text for stem, text in pages.items()}


def _escaped(text: str) -> str:
    """Return a text in which Markdown finds nothing to set."""
    for mark in "\\*_<[$`":
        text = text.replace(mark, f"\\{mark}")
    return text


# Python.


def python_pages() -> dict[str, str]:
    """Return the page that lists the Python interface, and one of each function, of each result and of the errors."""
    names = [name for name in rf.__all__ if not name.startswith("_") and callable(getattr(rf, name))]
    errors = [RopefricError, *RopefricError.__subclasses__(), rf.RopefricWarning]
    functions = [getattr(rf, name) for name in names if not isinstance(getattr(rf, name), type)]
    results = _results(functions)
    directives = {one.__name__: f".. autofunction:: ropefric.{one.__name__}\n" for one in functions}
    for one in results:
        name = f"{one.__module__}.{one.__qualname__}"
        directives[one.__qualname__] = (
            f".. autoclass:: {name}()\n   :members:\n   :exclude-members: from_dict\n"
        )
    rows = [
        (f"[`{one.__name__}`](python-{one.__name__}.md)", _escaped(inspect.getdoc(one).partition("\n")[0]))
        for one in (*functions, *results)
    ]
    directives["errors"] = "\n".join(
        f".. autoexception:: {one.__module__}.{one.__qualname__}()\n" for one in errors
    )
    rows.append(("[errors](python-errors.md)", "Errors and warnings, all from one class."))
    pages = {
        f"python-{name}": f"# {'Errors' if name == 'errors' else f'`{name}`'}\n\n```{{eval-rst}}\n{text}```\n"
        for name, text in directives.items()
    }
    begins = "# Python names\n\n`import ropefric as rf` has these functions, which return the classes below them.\n"
    return _with_list("python", begins, ("name", "purpose"), rows, pages)


def _results(functions: Iterable[typing.Any]) -> list[type]:
    """Return the dataclasses that the functions return, each once, by name."""
    returned = [inspect.signature(one).return_annotation for one in functions]
    found = {
        one.__qualname__: one
        for each in returned
        for one in (each, *typing.get_args(each))
        if is_dataclass(one)
    }
    return [found[name] for name in sorted(found)]


# Notebooks.


def paper_pages() -> dict[str, bytes]:
    """Return the pages of the papers and their pictures by file name, from their notebooks, which are run for it."""
    # Loaded here, because the tests read this module and run no notebook.
    import nbformat  # noqa: PLC0415
    from nbclient import NotebookClient  # noqa: PLC0415

    os.environ.setdefault("JUPYTER_PLATFORM_DIRS", "1")
    logging.getLogger("traitlets").setLevel(logging.WARNING)
    notebooks = {name: nbformat.read(NOTEBOOKS / f"{stem}.ipynb", 4) for name, (stem, *_) in PAPERS.items()}

    async def run() -> None:
        how = {"timeout": 600, "resources": {"metadata": {"path": str(NOTEBOOKS)}}}
        how["extra_arguments"] = ["--log-level=ERROR"]
        await asyncio.gather(*(NotebookClient(one, **how).async_execute() for one in notebooks.values()))

    asyncio.run(run())
    files: dict[str, bytes] = {}
    for name, notebook in notebooks.items():
        text = "\n\n".join(_set(notebook.cells, f"paper-{name}", files))
        pages, title = [text], text.partition("\n")[0]
        for begin in PAPERS[name][1:]:
            before, after = pages.pop().split(f"\n{begin}")
            pages += [before, f"{title} (part {len(pages) + 2})\n\n{begin}{after}"]
        for number, page in enumerate(pages, start=1):
            more = f"\n\nContinued: [](paper-{name}-{number + 1}.md)" if number < len(pages) else ""
            files[f"paper-{name}{f'-{number}' if number > 1 else ''}.md"] = f"{page}{more}\n".encode()
    return files


def _set(cells: Iterable[typing.Any], stem: str, files: dict[str, bytes]) -> Iterator[str]:
    """Yield the cells of a notebook as Markdown, each code with what it shows; pictures are added to the files."""
    for cell in cells:
        if cell.cell_type == "markdown":
            yield cell.source
            continue
        code = cell.source.removeprefix("%matplotlib inline\n")
        yield f"<details><summary>Code</summary>\n\n```python\n{code}\n```\n\n</details>"
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


def registered_pages() -> dict[str, str]:
    """Return the pages of all that goes by a name: laws, formats, rules, studies; effects; simulated recordings."""
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
        "# Names in files and commands\n",
        "Other names: [effects of machines](effects.md), [simulated recordings](simulated.md).\n",
        _table("Friction laws", ("name", "equation", "parameters", "source"), law_rows),
        _table(
            "File formats",
            ("name", "content", "endings"),
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
    studies = [(f"`{one.name}`", one.title) for one in STUDIES.values()]
    parts.append(_table("Studies of `ropefric cost`", ("name", "title"), studies))
    faults = [(f"`{one.name}`", f"`{one.expected_status or 'ok'}`") for one in FAULTS.values()]
    families = [(f"`{one.name}`", one.tier, f"`{one.expects}`") for one in FAMILIES.values()]
    simulated = [
        "# Simulated recordings\n",
        _table("Faults of the simulated bench", ("name", "correct status"), faults),
        _table("Recordings of the second rig", ("name", "tier", "correct status"), families),
    ]
    effects = ["# Effects of machines\n", *(_effects(kind) for kind in KINDS.values())]
    pages = {"registered.md": parts, "simulated.md": simulated, "effects.md": effects}
    return {name: "\n".join(texts) for name, texts in pages.items()}


def _effects(kind: Kind) -> str:
    rows = [(f"`{one.name}`", one.adds, one.instead) for one in kind.system.effects.values()]
    return _table(f"Effects of a scene of kind `{kind.name}`", ("name", "what it adds", "in its place"), rows)


# Scenes.


_KEYS_SAID = """\
Write a key such as `wheel.radius` in the table `[wheel]`; sweeps and messages use the full name. A `…` is a name of
your choice. Write quantities as text with their unit. A key without the word *needed* is optional; effects that use it
are then not simulated. `ropefric init --scene NAME` prints the same table."""


def scene_keys_pages() -> dict[str, str]:
    """Return the pages of every key that a scene can hold, one a machine, from the schema."""
    keys = {kind.name: [*scene_keys(kind.schema)] for kind in KINDS.values()}
    first, *others = keys.values()
    common = [key for key in first if all(key in other for other in others) or key.name == "system"]
    shared = {key.name for key in common}
    own = {name: [key for key in found if key.name not in shared] for name, found in keys.items()}
    pages = {"keys-common": f"# Keys of every scene\n\n{_KEYS_SAID}\n\n{_key_rows(common)}"}
    for name, found in own.items():
        title = f'# Keys of `system = "{name}"`'
        pages[f"keys-{name}"] = f"{title}\n\nKeys of every scene: [](keys-common.md).\n\n{_key_rows(found)}"
    rows = [("[every system](keys-common.md)", "")]
    rows += [
        (f"[`{name}`](keys-{name}.md)", ", ".join(f"`{one}`" for one in _templates(name))) for name in keys
    ]
    return _with_list("scene-keys", "# Keys of a scene\n", ("system", "example scenes"), rows, pages)


def _key_rows(keys: Iterable[typing.Any]) -> str:
    return _rows(
        ("key", "unit", "example", "default", "range", "meaning"),
        [
            (
                f"`{key.name}`",
                key.unit,
                f"`{key.example}`" if key.example else "",
                key.default if key.default in {"", "needed"} else f"`{key.default}`",
                _escaped(key.allowed),
                _escaped(key.meaning),
            )
            for key in keys
        ],
    )


def _templates(system: str) -> list[str]:
    """Return the names of the example scenes of a system."""
    found = {path.stem: tomllib.loads(path.read_text("utf-8")) for path in sorted(SCENES.glob("*.toml"))}
    return [name for name, scene in found.items() if scene["system"] == system]


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
