"""Settings and provenance as parts of a report."""

from collections.abc import Iterator, Mapping
from typing import Any

from ropefric.pipeline.provenance import InputFile, Provenance
from ropefric.report.chapter import Block, Fold
from ropefric.report.section import Section, Table


def provenance_blocks(provenance: Provenance) -> tuple[Block, ...]:
    """Return command, versions, seeds and inputs with their hashes; settings and recordings folded away."""
    seeds = ", ".join(f"{name} {seed}" for name, seed in provenance.seeds.items())
    made = ", ".join(f"{name} {number}" for name, number in sorted(provenance.versions.items()))
    again = Section(
        title="How to make it again",
        lines=("in the campaign's folder:",),
        notes=(provenance.command, f"versions: {made}", f"seeds: {seeds}"),
    )
    main = (provenance.campaign, provenance.trial_list)
    n = len(provenance.recordings)
    settings = tuple(_flat(provenance.settings))
    return (
        again,
        Section(title="Inputs", table=_files(main)),
        Fold(
            title=f"SHA-256 of the {n} recordings",
            sections=(Section(title="", table=_files(provenance.recordings)),),
        ),
        Fold(
            title="All settings, defaults filled in, in SI",
            sections=(Section(title="", table=Table(headings=("setting", "value "), rows=settings)),),
        ),
    )


def _files(files: tuple[InputFile, ...]) -> Table:
    rows = tuple((item.path, item.sha256 or "could not be read") for item in files)
    return Table(headings=("file", "SHA-256 "), rows=rows)


def _flat(tree: Mapping[str, Any], stem: str = "") -> Iterator[tuple[str, str]]:
    """Return a tree as rows; what is empty or not given is left out."""
    for key, value in tree.items():
        name = f"{stem}.{key}" if stem else str(key)
        if isinstance(value, Mapping):
            yield from _flat(value, name)
        elif isinstance(value, list):
            if value:
                yield name, ", ".join(map(str, value))
        elif value is not None and value != "":
            yield name, str(value)
