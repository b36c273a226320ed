"""Whatever is named as an input is a regular file, or that is said at once."""

import hashlib
import os
import shutil
import sys
from pathlib import Path

import pytest

from ropefric.cli.app import main
from ropefric.errors import DataError
from ropefric.files import disk
from ropefric.files.disk import FileChangedError, hash_file, kind_of_file, open_file, read_file
from ropefric.fitting.store import load_fit
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="no pipes among files")
PIPE = "this is a device or pipe, not a file"


@pytest.fixture
def fifo(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    return tmp_path / "fifo"


def refused(path, **options):
    with pytest.raises(DataError) as caught:
        read_file(path, **options)
    assert caught.value.code == "RF101"
    return str(caught.value)


def test_a_file_comes_back_whole_with_its_hash(tmp_path):
    content = bytes(range(256)) * 9000
    (tmp_path / "a").write_bytes(content)
    with open_file(tmp_path / "a") as file:
        assert (file.size, file.read(), b"".join(file.blocks(1000))) == (len(content), content, content)
        assert (file.part(300, 5), file.part(len(content) - 2, 9)) == (content[300:305], content[-2:])
        assert file.sha256 == hashlib.sha256(content).hexdigest() == hash_file(tmp_path / "a")


def test_what_is_no_readable_file_is_named(tmp_path):
    assert "there is no such file" in refused(tmp_path / "none")
    assert "there is no such scene file" in refused(tmp_path / "none", what="scene file")
    assert "this is a folder" in refused(tmp_path)
    assert "not a usable file name" in refused("a\0b")
    (tmp_path / "long").write_bytes(b"12345")
    assert "more than 4 are not read" in refused(tmp_path / "long", limit=4)
    assert read_file(tmp_path / "long", limit=5) == b"12345"


@POSIX
def test_pipes_and_devices_are_told_at_once(fifo):
    assert (kind_of_file(fifo), kind_of_file(fifo.parent)) == ("device or pipe", "folder")
    for path in (fifo, Path("/dev/zero"), Path(os.devnull)):
        assert PIPE in refused(path)


@POSIX
def test_every_command_tells_a_pipe_or_device(fifo, monkeypatch, capfd):
    monkeypatch.chdir(fifo.parent)
    commands = ["inspect PATH --format delimited", "solve PATH", "show PATH", "check PATH",
        "fit PATH --law coupled"]  # fmt: skip
    for command in (*commands, "extract PATH"):
        for path in ("fifo", "/dev/null") if command == "check PATH" else ("fifo",):
            assert main(command.replace("PATH", path).split()) == 3
            assert PIPE in capfd.readouterr().err, command


@POSIX
def test_a_pipe_among_stored_fits_or_in_a_scene(fifo, monkeypatch, capfd):
    monkeypatch.chdir(fifo.parent)
    fits = fifo.parent / "fits"
    fits.mkdir()
    os.mkfifo(fits / "a.json")
    assert main(["verify", "fits"]) == 4
    assert PIPE in " ".join(capfd.readouterr().out.split())  # a table folds its cells
    scene = Path(__file__).parents[2] / "data" / "scenes" / "hoist.toml"
    text = scene.read_text(encoding="utf-8")
    head, tail = text.split("[friction]", 1)
    rest = tail.split("\n[", 1)
    text = f'{head}[friction]\nfit = "fifo"\n' + (f"[{rest[1]}" if len(rest) > 1 else "")
    (fifo.parent / "scene.toml").write_text(text, encoding="utf-8")
    assert main(["solve", "scene.toml"]) == 3
    assert PIPE in capfd.readouterr().err
    with pytest.raises(DataError, match="device or pipe"):
        load_fit(fifo)


@POSIX
def test_a_pipe_in_the_place_of_a_recording(tmp_path, capfd):
    bench = Path(__file__).parents[2] / "data" / "prth-bench"
    text = (bench / "campaign.toml").read_text(encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    (tmp_path / "traces").mkdir()
    header, *rows = (bench / "trials.csv").read_text(encoding="utf-8").splitlines()[:4]
    (tmp_path / "trials.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    files = [row.split(",")[header.split(",").index("file")] for row in rows]
    for file in files[1:]:
        shutil.copy(bench / file, tmp_path / file)
    os.mkfifo(tmp_path / files[0])
    words = [str(tmp_path), "--out", str(tmp_path / "out"), "--no-figures"]
    assert main(["extract", *words]) == 0
    assert "1 without a force" in capfd.readouterr().err
    assert PIPE in (tmp_path / "out" / "problems.csv").read_text(encoding="utf-8")
    assert main(["check", str(tmp_path)]) == 3
    assert "is a device or pipe, not a file" in capfd.readouterr().err


def test_a_file_that_is_written_to_is_read_again_or_refused(tmp_path, monkeypatch):
    path = tmp_path / "run.csv"
    path.write_bytes(b"time_s,force_N\n0,1\n")
    versions = [b"time_s,force_N\n0,1\n0.1,2\n", b"time_s,force_N\n0,1\n0.1,2\n0.2,3\n"]
    real = disk.InputFile._pass

    def write_meanwhile(file, size):
        if versions:
            path.write_bytes(versions.pop(0))
        return real(file, size)

    monkeypatch.setattr(disk, "KEPT_BYTES", 1000)
    monkeypatch.setattr(disk.InputFile, "_pass", write_meanwhile)
    (recording,) = read_recordings(path, ImportProfile())
    assert recording.columns["force"].tolist() == [1, 2, 3]
    versions = [b"a" * (100 + n) for n in range(100)]
    with pytest.raises(FileChangedError, match="changed while it was read"):
        read_file(path)


def test_a_large_file_gives_the_same_bytes_in_every_pass(tmp_path, monkeypatch):
    monkeypatch.setattr(disk, "KEPT_BYTES", 10)
    path = tmp_path / "a"
    path.write_bytes(b"0123456789" * 10)
    with open_file(path) as file:
        first = file.sha256
        assert b"".join(file.blocks(7)) == path.read_bytes()
        stamp = path.stat()
        path.write_bytes(b"9876543210" * 10)
        os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # equal size and time: the content tells
        with pytest.raises(FileChangedError):
            list(file.blocks(7))
        assert file.sha256 == first
