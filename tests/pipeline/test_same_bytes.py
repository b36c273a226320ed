"""The same campaign gives the same bytes: under every SIMD path, BLAS kernel, number of threads, processes, hash seed.

What does not hold versions of libraries is compared with hashes in the repository too, so that every machine and
every version that runs this test is compared with all others. After a change that moves numbers on purpose:
`python tests/pipeline/test_same_bytes.py` writes the hashes anew.
"""

import csv
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from ropefric.cli.app import main

BENCH = Path(__file__).parents[2] / "data" / "prth-bench"
STORED = Path(__file__).with_name("same_bytes.json")
EVERY = 3
"""Of the bench's conditions one in so many is taken, with two pulls each."""


def every_simd_path_off():
    """What numpy may choose at run time on this processor, in the words its version has for it."""
    umath = np._core._multiarray_umath
    return " ".join(name for name in umath.__cpu_dispatch__ if umath.__cpu_features__.get(name))


SETTINGS = {"no SIMD": {"NPY_DISABLE_CPU_FEATURES": every_simd_path_off()},
    "AVX2": {"NPY_DISABLE_CPU_FEATURES": " ".join(re.findall(r"\S*(?:512|V4)\S*", every_simd_path_off()))},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"}, "Prescott": {"OPENBLAS_CORETYPE": "Prescott"},
    "two threads, one process": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "PYTHONHASHSEED": "12"}
}  # fmt: skip


def small_campaign(folder):
    """Copy a part of the bench."""
    with (BENCH / "trials.csv").open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    chosen = [row for row in rows if int(row[0][1:3]) % EVERY == 1 and row[0].endswith(("r01", "r02"))]
    (folder / "traces").mkdir(parents=True)
    for row in chosen:
        shutil.copy(BENCH / row[1], folder / row[1])
    shutil.copy(BENCH / "campaign.toml", folder)
    with (folder / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *chosen])
    return folder


WORDS = ("run", "campaign.toml", "--quiet", "--out")


def run(folder, out, *flags, **environment):
    """Run the campaign in a process of its own; return the bytes of every file written."""
    done = subprocess.run(
        [sys.executable, "-m", "ropefric", *WORDS, out, *flags],
        cwd=folder, env=os.environ | environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode in {0, 4}, done.stderr  # so small a campaign may leave its laws undecided
    return written(folder / out)


def written(folder):
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def hashes(files):
    """Of every table, fit and prediction, without the versions of the libraries that made it."""
    found = {}
    for name, data in files.items():
        if name.endswith((".csv", ".json", ".txt")) and not name.startswith(
            (".ropefric/", "figures/", "manifest")
        ):
            plain = data
            if name.startswith("fits/"):
                tree = json.loads(data)
                del tree["provenance"]["versions"]
                plain = json.dumps(tree, sort_keys=True).encode()
            found[name] = hashlib.sha256(plain).hexdigest()
    return found


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return small_campaign(tmp_path_factory.mktemp("same") / "campaign")


@pytest.fixture(scope="module")
def native(campaign):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(campaign)
        assert main([*WORDS, "native", "--no-figures"]) in {0, 4}
    return written(campaign / "native")


def test_the_bytes_are_those_of_every_other_machine(native):
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    found = hashes(native)
    assert {name for name in stored.keys() | found.keys() if stored.get(name) != found.get(name)} == set()


@pytest.fixture(scope="module")
def drawn(campaign):
    return run(campaign, "drawn", "--jobs", "2")


QUICK = ("AVX2", "two threads, one process")
"""Settings that are tried every time; the others are tried before a release."""


@pytest.mark.parametrize(
    "setting",
    [pytest.param(one, marks=pytest.mark.slow if one in QUICK else pytest.mark.release) for one in SETTINGS],
)
def test_no_setting_shows_in_figures_and_report(campaign, drawn, setting):
    assert any(name.endswith(".png") for name in drawn)
    jobs = "1" if setting.endswith("one process") else "2"
    other = run(campaign, setting.replace(" ", "-"), "--jobs", jobs, **SETTINGS[setting])
    assert {name for name in drawn.keys() | other.keys() if drawn.get(name) != other.get(name)} == set()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        made = hashes(run(small_campaign(Path(place) / "campaign"), "out", "--no-figures"))
    STORED.write_text(json.dumps(made, indent=1, sort_keys=True) + "\n", encoding="utf-8")
