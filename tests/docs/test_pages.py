"""The pages keep their word: what they print is printed, links lead somewhere, commands and options exist."""

import importlib.util
import inspect
import re
import shlex
import subprocess
import sys
import typing

import pytest
import sessions

import ropefric
from ropefric.accuracy.studies import STUDIES
from ropefric.cli.app import build_app
from ropefric.files.toml_model import StrictTable
from ropefric.friction.laws import LAWS
from ropefric.scenes.keys import scene_keys
from ropefric.scenes.kinds import KINDS
from ropefric.traces import decision

ROOT = sessions.ROOT
PAGES = [*sessions.PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CODE_OF_CONDUCT.md"]
QUICK = ("README.md", "docs/machines/beltdrive.md")
"""Pages whose sessions are run by default; `-m slow` runs all."""
OF_OTHERS = ("docs/paper/",)


def name_of(page):
    return page.relative_to(ROOT).as_posix()


def with_sessions():
    """Every page with something to run."""
    for page in sessions.PAGES:
        if sessions.sessions(page):
            marks = () if name_of(page) in QUICK else pytest.mark.slow
            yield pytest.param(page, id=name_of(page), marks=marks)


@pytest.mark.parametrize("page", [*with_sessions()])
def test_what_a_page_prints_is_printed(page, tmp_path, monkeypatch):
    sessions.prepare(tmp_path)
    monkeypatch.chdir(tmp_path)
    with sessions.quiet_terminal():
        sessions.run_page(page)


def test_the_readme_is_short():
    assert (ROOT / "README.md").stat().st_size <= 8500


def test_links_lead_somewhere():
    """Pages and figures that are made while the site is built are looked for there."""
    for page in PAGES:
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
            path = (page.parent / target).resolve()
            made = path.parent == ROOT / "docs" / "generated"
            assert made or "://" in target or path.exists(), f"{name_of(page)}: {target}"


def test_files_and_names_of_the_code_exist():
    """A reader who wants to change something is led to a file, and to a name in it."""
    text = (ROOT / "docs" / "extend.md").read_text(encoding="utf-8")
    places = re.findall(r"`((?:ropefric|tests)/[^`\s]+)`(?: \(((?:`\w+`(?:, )?)+)\))?", text)
    assert len(places) > 20
    for place, names in places:
        path = ROOT / place.replace("SYSTEM", "hoist")
        assert path.exists(), place
        for name in re.findall(r"\w+", names):
            assert re.search(rf"\b(?:def|class) {name}\b|\b{name}\b.* = ", path.read_text("utf-8")), place


def test_the_number_of_laws_is_right():
    words = {12: "twelve", 13: "thirteen", 14: "fourteen"}
    for page in ("README.md", "docs/paper/paper.md"):
        assert f"fits {words[len(LAWS)]} friction laws" in (ROOT / page).read_text(encoding="utf-8"), page


def test_every_page_is_in_the_navigation():
    listed, waiting = set(), [ROOT / "docs" / "index.md"]
    while waiting:
        page = waiting.pop()
        if page in listed:
            continue
        listed.add(page)
        text = page.read_text(encoding="utf-8")
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            entries = [line for line in tree.splitlines() if line and not line.startswith(":")]
            mine = [entry for entry in entries if "generated/" not in entry]
            waiting += [one for entry in mine for one in page.parent.glob(f"{entry}.md")]
    assert listed == {page for page in PAGES if (ROOT / "docs") in page.parents
        and not name_of(page).startswith(OF_OTHERS)}  # fmt: skip


def commands_named():
    """Every command line in a page: in its shell and console blocks, and in its sentences."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"^```(?:sh|console)\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            yield from ((name_of(page), line.removeprefix("$ ")) for line in block.splitlines()
                if "ropefric " in line)  # fmt: skip
        for said in re.findall(r"`(ropefric [^`]+)`", text):
            yield name_of(page), said


def test_every_command_named_exists_with_its_options():
    group = build_app()
    known = {name: {word for one in command.params for word in (*one.opts, *one.secondary_opts)}
        for name, command in group.commands.items()}  # fmt: skip
    of_all = {word for one in group.params for word in one.opts} | {"-h", "--help"}
    seen = set()
    for page, line in commands_named():
        found = re.search(r"(?:^|\s|/)ropefric ((?:--?)?[a-z-]+)(.*)", line)
        if not found or line.startswith((">>>", "ropefric COMMAND")):
            continue
        verb, rest = found.groups()
        if verb.startswith("-"):
            assert verb in of_all, f"{page}: {line}"
            continue
        if verb not in known and not line.startswith(("ropefric", ".venv/bin/ropefric")):
            continue  # a sentence that is printed
        assert verb in known, f"{page}: {line}"
        seen.add(verb)
        used = {word.split("=")[0] for word in shlex.split(rest.split("…")[0]) if re.match(r"--?[a-z]", word)}
        assert used <= known[verb] | of_all, f"{page}: {line}: no {used - known[verb] - of_all}"
    assert len(seen) >= 15, f"only {sorted(seen)} are named at all"


def test_samples_are_what_their_script_writes():
    spec = importlib.util.spec_from_file_location("samples", ROOT / "docs" / "samples" / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made = module.files()
    assert len(made) == 24
    for path, content in made.items():
        assert path.read_bytes() == content, f"{path}: run python docs/samples/make.py"


def test_f_a_is_defined_once():
    """In the words of the picker, of the studies that judge it, and of the page that explains it."""
    words = "the onset of macroscopic slip"
    page = " ".join((ROOT / "docs" / "concepts.md").read_text(encoding="utf-8").split())
    assert page.count(f"F_A is the largest force between {words}") == 1
    assert f"between {words} and its first fall" in STUDIES["picks"].reference
    assert f"the largest force from {words} to its first fall" in " ".join(decision.__doc__.split())


def test_one_version():
    def version_in(name, pattern):
        return re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.MULTILINE)[1]

    cited = version_in("CITATION.cff", r"^version: (\S+)$")
    built = version_in("pyproject.toml", r'^version = "(\S+)"$')
    assert cited == built == ropefric.__version__


def test_citations_of_the_paper_are_in_its_list():
    folder = ROOT / "docs" / "paper"
    cited = set(re.findall(r"@(\w+)", (folder / "paper.md").read_text(encoding="utf-8")))
    assert cited == set(re.findall(r"^@\w+\{(\w+),", (folder / "paper.bib").read_text(encoding="utf-8"),
        re.MULTILINE))  # fmt: skip


@pytest.mark.release
def test_the_site_is_built_without_a_warning_and_loads_nothing_from_elsewhere(tmp_path):
    for name in ("sphinx", "myst_parser", "furo", "latex2mathml"):
        pytest.importorskip(name)
    site = tmp_path / "site"
    how = ("-q", "-W", "-b", "html", "-d", tmp_path / "trees", "docs", site)
    built = [sys.executable, "-m", "sphinx", *map(str, how)]
    done = subprocess.run(built, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    pages = list(site.rglob("*.html"))
    assert len(pages) >= 20
    for path in [*pages, *site.rglob("*.css")]:
        text = path.read_text(encoding="utf-8")
        loaded = re.findall(r'<(?:script|img|iframe|source)[^>]*?\ssrc="([^"]+)"', text)
        loaded += re.findall(r'<link[^>]*?rel="(?:stylesheet|preload|icon|preconnect)"[^>]*?href="([^"]+)"',
            text)  # fmt: skip
        loaded += re.findall(r'<link[^>]*?href="([^"]+)"[^>]*?rel="(?:stylesheet|preload|icon|preconnect)"',
            text)  # fmt: skip
        loaded += re.findall(r"(?:url\(|@import )[\"']?([^\"')]+)", text)
        assert not [one for one in loaded if re.match(r"(?:https?:)?//", one)], path
        assert str(ROOT) not in text, path
        for missing in re.findall(r'<img[^>]*?\ssrc="([^"]+)"', text):
            assert (path.parent / missing).exists(), f"{path}: {missing}"
    assert "hoist" in (site / "searchindex.js").read_text(encoding="utf-8")
    notebook = (site / "generated" / "paper-prth.html").read_text(encoding="utf-8")
    assert "<caption>" in notebook, "a result at the end of a cell is a table"
    assert "paper-prth-cell-03" in notebook, "and what plot() returns a figure"


@pytest.mark.portable
def test_every_key_of_a_scene_has_unit_default_range_and_meaning():
    for kind in KINDS.values():
        keys = {key.name: key for key in scene_keys(kind.schema)}
        for key in keys.values():
            assert key.meaning.endswith("."), (kind.name, key.name)
            assert key.allowed, (kind.name, key.name)
        described = {name for one in rows_of_tables(kind.schema)
            for name in re.findall(r"^(\w+) : ", inspect.getdoc(one), re.MULTILINE)}  # fmt: skip
        assert described == {name.rpartition(".")[2] for name in keys}, kind.name
    hoist = {key.name: key for key in scene_keys(KINDS["hoist"].schema)}
    assert (hoist["accuracy"].default, hoist["accuracy"].allowed) == ("0.01", "above 0 and at most 1")
    assert hoist["wheel.radius"][1:5] == ("m", '"40 mm"', "needed", "more than 0")
    assert hoist["wheel.speed"].allowed == "any"


def rows_of_tables(schema):
    """Give a schema and all tables in it, and what they inherit from."""
    yield from (one for one in schema.__mro__ if issubclass(one, StrictTable))
    for info in schema.model_fields.values():
        for one in (info.annotation, *typing.get_args(info.annotation)):
            if isinstance(one, type) and issubclass(one, StrictTable):
                yield from rows_of_tables(one)
