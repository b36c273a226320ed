"""Files that kill, hang or fill the memory of whoever reads them: they are lost alone."""

import gzip
import os
import shutil
import struct
import sys
import time
import zipfile
import zlib

import numpy as np
import pytest

from ropefric.cli.app import main
from ropefric.files import text
from ropefric.traces.breakaway import Status
from ropefric.trials import extract as recording
from ropefric.trials import workers

PROCESSES = True
LINUX = pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")


def mat_of_nested_cells(depth):
    """A cell in a cell in a cell …; every level is read by a deeper call."""

    def element(kind, content):
        return struct.pack("<II", kind, len(content)) + content + b"\0" * (-len(content) % 8)

    inner = element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", 1, 1)) + element(1, b"")
    inner += element(9, struct.pack("<d", 1.0))
    levels = [struct.pack("<II", 14, len(inner)) + inner]
    size = len(levels[0])
    for level in range(depth):
        name = b"c" if level == depth - 1 else b""
        head = element(6, struct.pack("<II", 1, 0)) + element(5, struct.pack("<ii", 1, 1)) + element(1, name)
        levels.append(struct.pack("<II", 14, len(head) + size) + head)
        size += len(levels[-1])
    return mat_file(b"".join(reversed(levels)))


def mat_of_zeros(n):
    """A hundredth of its size on disk: `n` doubles, stored as bytes and packed."""
    tags = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, n, 1) + struct.pack("<II", 1, 1)
    tags += b"F" + b"\0" * 7 + struct.pack("<II", 2, n)
    body = struct.pack("<II", 14, len(tags) + n) + tags
    packer = zlib.compressobj(1)
    parts = [packer.compress(body)]
    parts += [packer.compress(b"\0" * min(10**6, n - done)) for done in range(0, n, 10**6)]
    packed = b"".join([*parts, packer.flush()])
    return mat_file(struct.pack("<II", 15, len(packed)) + packed)


def mat_file(elements):
    return b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM" + elements


def xlsx(sheet, strings=""):
    """The least that is a sheet."""
    main_ns = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"
    return {"[Content_Types].xml": f'<Types xmlns="{package}/content-types"/>',
        "_rels/.rels": f'<Relationships xmlns="{package}/relationships"><Relationship Id="r1" '
        f'Type="{office}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'<workbook {main_ns} xmlns:r="{office}"><sheets>'
        '<sheet name="a" sheetId="1" r:id="r1"/></sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{package}/relationships">'
        f'<Relationship Id="r1" Type="{office}/worksheet" Target="worksheets/sheet1.xml"/>'
        f'<Relationship Id="r2" Type="{office}/sharedStrings" Target="sharedStrings.xml"/></Relationships>',
        "xl/worksheets/sheet1.xml": f"<worksheet {main_ns}><sheetData>{sheet}</sheetData></worksheet>",
        "xl/sharedStrings.xml": f"<sst {main_ns}>{strings}</sst>"}  # fmt: skip


def write_zip(path, parts):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)


@pytest.fixture(scope="module")
def hostile_files(tmp_path_factory):
    """Return their paths."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "nested.mat").write_bytes(mat_of_nested_cells(5000))
    (folder / "zeros.mat").write_bytes(mat_of_zeros(16 * 10**7))
    corner = '<row r="1"><c r="A1"><v>1</v></c></row><row r="1048576"><c r="XFD1048576"><v>1</v></c></row>'
    write_zip(folder / "corner.xlsx", xlsx(corner))
    beyond = corner.replace("1048576", "4294967295").replace("XFD", "B")
    write_zip(folder / "beyond.xlsx", xlsx(beyond))
    cells = "".join(f'<row r="{i}"><c r="A{i}" t="s"><v>0</v></c></row>' for i in range(1, 40_001))
    write_zip(folder / "strings.xlsx", xlsx(cells, f"<si><t>{'x' * 30_000}</t></si>"))
    head, member = gzip.compress(b"time_s,force_N\n", mtime=0), gzip.compress(b"0.001,2.5\n" * 10**6, mtime=0)
    (folder / "bomb.csv.gz").write_bytes(head + member * 1000)  # 10 GB
    line = gzip.compress(b"1" * 10**7, mtime=0)
    (folder / "line.csv.gz").write_bytes(gzip.compress(b"time_s,force_N\n0,", mtime=0) + line * 1000)
    return sorted(folder.iterdir())


SETTINGS = '[limits]\nmemory = "150 MB"\ntime = "60 s"\n'
WHY = {"bomb.csv.gz": ("unpacks to more than", "memory"),
    "nested.mat": ("the reader crashed (signal 11", "not a readable MATLAB"),
    "zeros.mat": ("150 MB of memory",), "strings.xlsx": ("150 MB of memory",),
    "corner.xlsx": ("150 MB", "not a readable sheet")}  # fmt: skip


@LINUX
@pytest.mark.parametrize("jobs", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_every_hostile_file_is_lost_alone(lab, hostile_files, jobs, monkeypatch):
    pytest.importorskip("python_calamine")
    if jobs == 2:  # four of them take five seconds to unpack
        forked(monkeypatch)
        monkeypatch.setattr(text, "MOST_UNPACKED_BYTES", 2**28)
    (alone_a, alone_b) = lab.pulls(a=100.0, b=103.0).extract().trials
    # A line of 4 GB takes nine seconds to unpack.
    chosen = [path for path in hostile_files if jobs == 1 or path.name != "line.csv.gz"]
    names = [shutil.copy(path, lab.folder / path.name).name for path in chosen]
    lab.write([lab.row("a.csv"), *(lab.row(name) for name in names), lab.row("b.csv")], SETTINGS)
    a, *lost, b = lab.extract(jobs=jobs).trials
    assert (a.to_dict(), b.to_dict()) == (alone_a.to_dict(), alone_b.to_dict())
    assert {trial.breakaway.status for trial in lost} == {Status.UNREADABLE}
    why = {trial.file: trial.breakaway.detail for trial in lost}
    for name, words in WHY.items():
        assert any(word in why[name] for word in words), why[name]
    assert all(trial.problems and trial.sha256 for trial in lost)


@LINUX
def test_a_hostile_file_alone_ends_the_command_with_a_message(lab, capfd):
    (lab.folder / "nested.mat").write_bytes(mat_of_nested_cells(5000))
    lab.write([lab.row("nested.mat")])
    assert main(["extract", str(lab.path), "--out", str(lab.folder / "out"), "--no-figures"]) == 3
    assert "none of the 1 recordings gave a usable force" in capfd.readouterr().err
    assert main(["inspect", str(lab.folder / "nested.mat")]) == 3
    said = capfd.readouterr()
    assert "nested.mat" in said.err
    assert "Traceback" not in said.err


def forked(monkeypatch):
    """Have processes forked, so that what is patched here is patched there, though other tests left threads behind."""
    monkeypatch.setattr(workers.threading, "active_count", lambda: 1)


@LINUX
@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_reader_that_hangs_dies_or_fails_costs_one_recording(lab, monkeypatch, jobs):
    real = recording.read_recordings

    def spoilt(path, *args, **options):
        match path.stem:
            case "hang":
                time.sleep(600)
            case "die":
                os._exit(7)
            case "full":
                np.ones(10**9)
            case "bug":
                raise ZeroDivisionError("something new")
        return real(path, *args, **options)

    forked(monkeypatch)
    monkeypatch.setattr(recording, "read_recordings", spoilt)
    lab.pulls(a=100.0, hang=100.0, b=100.0, die=100.0, full=100.0, bug=100.0, c=100.0)
    names = ["a", "hang", "b", "die", "full", "bug", "c"]
    settings = '[limits]\nmemory = "1 GB"\ntime = "8 s"\n'
    extraction = lab.write([lab.row(f"{name}.csv") for name in names], settings).extract(jobs=jobs)
    why = {trial.trial: trial.breakaway.detail for trial in extraction.trials}
    assert [trial.breakaway.status for trial in extraction.trials] == [
        *("ok", "unreadable", "ok", "unreadable", "unreadable", "unreadable", "ok")
    ]
    assert "took longer than 8 s" in why["hang"]
    assert "the reader crashed (exit code 7)" in why["die"]
    assert "took more than 1 GB of memory" in why["full"]
    assert "internal fault, ZeroDivisionError: something new" in why["bug"]


def test_limits_are_checked(lab):
    lab.pulls(a=100.0)
    for key, value in (("memory", "0 GB"), ("memory", "2 s"), ("time", "soon"), ("tiem", "1 s")):
        with pytest.raises(ValueError, match=key):
            lab.write([lab.row("a.csv")], f'[limits]\n{key} = "{value}"\n').load()
    campaign = lab.write([lab.row("a.csv")], '[limits]\nmemory = "2 GB"\ntime = "3 min"\n').load()
    assert (campaign.limits.memory_bytes, campaign.limits.time_s) == (2e9, 180.0)


def test_two_trials_of_one_name_keep_their_own_recordings(lab):
    """A row may be called as the block of another: "w#2"."""
    time_s = np.arange(2500) / 1000
    force_N = np.interp(time_s, [0.3, 1.3, 1.32], [0, 100, 80])
    for name, heads, factors in (("wide", "w,,2,", (1.0, 1.5)), ("other", "1,,2,", (0.5, 0.6))):
        columns = np.column_stack([time_s, factors[0] * force_N, time_s, factors[1] * force_N])
        header = f"{heads}\ntime_s,force_N,time_s,force_N"
        np.savetxt(lab.folder / f"{name}.csv", columns, fmt="%.3f", delimiter=",", header=header, comments="")
    profile = "[import]\nblock_columns = 2\nblock_names_row = 1\nheader_row = 2\n"
    profile += '[import.channels]\ntime = { column = 1, unit = "s" }\nforce = { column = 2, unit = "N" }\n'
    first, second = lab.row("wide.csv", trial="w", sample="*"), lab.row("other.csv", trial="w#2", sample="2")
    for listed in ([first, second], [second, first]):
        trials = lab.write(listed, profile).extract().trials
        peaks_N = {trial.trial: trial.peak_N for trial in trials}
        # The name somebody gave stays his.
        assert peaks_N == pytest.approx({"w#2": 60, "w#w": 100, "w#2-2": 150}, rel=0.01)
