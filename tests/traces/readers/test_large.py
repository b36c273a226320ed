"""Large files: taken apart in pieces to the same result, held once beside their columns."""

import gzip
import subprocess
import sys

import numpy as np
import pytest
from thinned import thinned

from ropefric.errors import DataError
from ropefric.files import text
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

BY_NUMBER = ImportProfile(
    channels={"time": Channel(column=1, unit="s"), "force": Channel(column=2, unit="N")}
)
ROWS = [(i / 1000, 0.25 * i - 3) for i in range(90)]
PLAIN = "time_s,force_N\n" + "".join(f"{t},{f}\n" for t, f in ROWS)


FILES = {"plain": PLAIN, "no end of line": PLAIN[:-1], "Windows": PLAIN.replace("\n", "\r\n"),
    "Macintosh": PLAIN.replace("\n", "\r"), "blank lines within": PLAIN.replace("0.05,", "\n\n0.05,", 1),
    "blank lines at the end": PLAIN + "\n \n\n", "decimal comma": PLAIN.replace(",", ";").replace(".", ","),
    "tabs": PLAIN.replace(",", "\t"), "blanks": PLAIN.replace(",", "   "), "quotes": PLAIN + '"0.3","7"\n',
    "missing": PLAIN + "0.3,\n0.31,nan\n", "a comment of words": "Zug in µm, 20 °C\n\n" + PLAIN,
    "utf-16": PLAIN.encode("utf-16"), "utf-8 with mark": PLAIN.encode("utf-8-sig"),
    "cp1252": ("Prüfung\n" + PLAIN).encode("cp1252"), "letters of two bytes": "é" * 999 + "\n" + PLAIN,
    "one column": "force_N\n" + "".join(f"{f}\n" for _, f in ROWS),
    "one column with gaps": "force_N\n" + "".join(f"{f}\n\n" for _, f in ROWS),
    "a letter": PLAIN + "0.3,x\n0.4,1\n", "a letter early": PLAIN.replace("0.05,", "0.05x,", 1),
    "too long a row": PLAIN.replace("0.05,", "0.05,7,", 1), "too short a last row": PLAIN + "0.3\n",
    "too short a row": PLAIN + "0.3\n0.4,1\n", "an open quote": PLAIN + '0.3,"7\n',
    "zero bytes": PLAIN + "0.3,\0\n", "not the encoding it starts in": PLAIN.encode() + b"0.3,\x81\n",
    "infinite": PLAIN + "0.3,inf\n", "words below": PLAIN + "end of test\n"}  # fmt: skip
PROFILES = {"one column": ImportProfile(sampling_rate_Hz=100.0),
    "one column with gaps": ImportProfile(sampling_rate_Hz=1.0)}  # fmt: skip


def outcome(path, profile):
    try:
        (found,) = read_recordings(path, profile, shown_as="run.csv")
    except DataError as error:
        return error.problem
    return {name: column.tobytes() for name, column in found.columns.items()}, found.units, found.first_line


@pytest.mark.parametrize("size", thinned([64, 1, 7, 1000]))
def test_a_text_in_pieces_gives_what_it_gives_whole(write, monkeypatch, size):
    whole = {}
    for name, content in FILES.items():
        path, profile = write(content, f"{name}.csv"), PROFILES.get(name, ImportProfile())
        whole[name] = path, profile, outcome(path, profile)
    monkeypatch.setattr(text, "PIECE_BYTES", size)
    for name, (path, profile, found) in whole.items():
        assert outcome(path, profile) == found, name


def test_a_header_longer_than_the_head_is_seen(write):
    n = 150
    names = ",".join(["time_s", "force_N", *(f"unused_{'x' * 900}_{i}_mm" for i in range(n))])
    assert len(names) > 2 * text.HEAD_BYTES
    lines = "".join(f"{t},{f}" + ",1" * n + "\n" for t, f in ROWS[:5])
    path = write(f"{names}\n{lines}")
    profile = ImportProfile(channels={"time": Channel(column="time_s"), "force": Channel(column="force_N")})
    (found,) = read_recordings(path, profile)
    assert found.columns["force"].tolist() == [f for _, f in ROWS[:5]]
    seen = inspect_file(path)
    assert (seen.n_rows, len(seen.columns), seen.header_row) == (5, n + 2, 1)


PEAK_MB = """
import sys
def peak_MB():
    status = open("/proc/self/status").read()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024
"""
READ = """
import pandas
from ropefric.traces.readers import read_recordings as work
from ropefric.traces.readers.profile import ImportProfile
how = {"profile": ImportProfile()}
"""
PICK = """
from ropefric import find_breakaway as work
how = {"rest": "pretension"}
"""
TIMES = """
work(sys.argv[1], **how)
before_MB = peak_MB()
work(sys.argv[2], **how)
print((peak_MB() - before_MB) / (int(sys.argv[3]) * 2 * 8 / 2**20))
"""


@pytest.fixture(scope="module")
def pulls(tmp_path_factory):
    """A short pull and one of a million samples, of 16-bit counts and of numbers that hardly come again."""
    folder, n, rng = tmp_path_factory.mktemp("long"), 1_000_000, np.random.default_rng(1)
    for name, decimals in (("coarse", "%.2f"), ("fine", "%.6f")):
        for length, size in (("short", 4_000), ("long", n)):
            time_s = np.linspace(0.0, 20.0, size)
            force_N = np.interp(time_s, [2, 12, 12.1, 20], [0, 80, 60, 60]) + 0.1 * rng.standard_normal(size)
            np.savetxt(folder / f"{name}-{length}.csv", np.column_stack([time_s, force_N]),
                       f"%.7f,{decimals}", header="time_s,force_N", comments="")  # fmt: skip
    return folder, n


@pytest.mark.slow
@pytest.mark.parametrize(
    ("work", "kind", "most"),
    [(READ, "fine", 4.5), (PICK, "fine", 5.5), (PICK, "coarse", 7.5)],
    ids=["reading", "picking", "picking of counts"],
)
def test_no_more_is_held_of_a_long_recording_than_a_few_times_its_samples(pulls, work, kind, most):
    """The largest memory beyond that of a short recording, by the size of its two columns of floats, 16 MB.

    The text, of 17 to 20 MB, is held beside them; one more copy of the columns would add 1.
    """
    if sys.platform != "linux":
        pytest.skip("looks into /proc")
    folder, n = pulls
    words = [sys.executable, "-c", PEAK_MB + work + TIMES]
    words += [str(folder / f"{kind}-{length}.csv") for length in ("short", "long")]
    done = subprocess.run([*words, str(n)], capture_output=True, text=True, timeout=300, check=True)
    assert float(done.stdout) < most


def test_a_file_that_unpacks_without_end_is_refused(write, monkeypatch):
    assert text.MOST_UNPACKED_BYTES >= 2**30
    monkeypatch.setattr(text, "MOST_UNPACKED_BYTES", 20 * 2**20)
    member = gzip.compress(b"0.001,2.5\n" * 10**5)
    path = write(gzip.compress(b"time_s,force_N\n") + member * 30, "run.csv.gz")
    with pytest.raises(DataError, match="unpacks to more than"):
        read_recordings(path, BY_NUMBER)
