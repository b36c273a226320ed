"""A paper read for a machine: the published one, or a scene, a fit or trials of one's own."""

import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from ropefric import scenes
from ropefric.errors import InputError, UnknownNameError
from ropefric.files.toml import TomlDocument
from ropefric.papers.paper import Paper, Reading, Row
from ropefric.registry import did_you_mean
from ropefric.scenes.kind import FrictionTable
from ropefric.scenes.scene import Scene, load_scene, read_scene, source_of
from ropefric.scenes.scene_templates import scene_text
from ropefric.systems.checks import checked
from ropefric.trials.table import TrialTable

PAPERS = ("prth", "press", "saw")


class Given(NamedTuple):
    """What a paper is read for: a scene, and whether it is the published one; trials where given; F_0 [N]."""

    scene: Scene
    published: bool
    trials: TrialTable | None
    reference_N: float


def read_paper(
    name: str,
    *,
    scene: Path | None = None,
    trials: TrialTable | None = None,
    fit: Path | None = None,
    reference_N: float | None = None,
) -> Reading:
    """Return a paper with its numbers for a scene, a fit or trials; for the machine that it publishes by default."""
    if name not in PAPERS:
        raise UnknownNameError(f"unknown paper {name!r}", key="PAPER", fix=did_you_mean(name, PAPERS))
    paper: Paper = import_module(f"ropefric.papers.{name}").PAPER
    of_prth = (
        (trials, "--trials", "reduces trials"),
        (reference_N, "--reference-tension", "has a reference tension"),
    )
    for given, key, what in of_prth:
        if given is not None and name != "prth":
            raise InputError(f"only prth {what}", key=key, fix=f"leave {key} out")
    F_0 = 1.0 if reference_N is None else float(checked("reference_tension", reference_N))
    if scene is None:
        document = TomlDocument(path=paper.scene, data=tomllib.loads(scene_text(paper.scene)), lines={})
        loaded = read_scene(document, Path(str(scenes.__file__)).parent)
    else:
        loaded = load_scene(scene)
    if loaded.kind.name != paper.system:
        why = f"the scene is one of a {loaded.kind.name}, the paper of a {paper.system}"
        fix = f'give one with system = "{paper.system}"'
        raise InputError(why, key="--scene", path=str(scene), fix=fix)
    if fit is not None:
        table = loaded.table.model_copy(update={"friction": FrictionTable(fit=fit.name)})
        source = source_of(loaded.kind, table, fit.parent)
        problem = loaded.kind.problem(table, None if source is None else source.friction)
        loaded = replace(loaded, table=table, source=source, problem=problem)
    case = Given(loaded, scene is None and fit is None, trials, F_0)
    machine = paper.machine(case)
    rows = tuple((item, tuple(_of(case, item.rows(machine)))) for item in paper.items)
    whose = paper.of if scene is None else str(scene)
    with_fit, beside = (f"the fit {fit}" if fit else ""), (trials.source if trials is not None else "")
    own = paper.beside if scene is None and not with_fit and not beside else ""
    of = "; ".join(filter(None, (whose, with_fit, beside, own)))
    return Reading(name=name, paper=paper, of=of, machine=machine, rows=rows)


def _of(given: Given, rows: Iterable[Row]) -> Iterator[Row]:
    """Yield rows; what is printed belongs to the published machine alone, a word on it to where the two differ."""
    for row in rows:
        if row.printed and not given.published:
            yield row._replace(printed="", remark="")
        else:
            yield row._replace(remark="") if row.agrees else row
