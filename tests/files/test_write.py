"""A file is the old one or the new one, whatever happens while it is written."""

import errno
import os

import pytest

from ropefric.errors import DataError, InputError
from ropefric.files import disk
from ropefric.files.disk import replacing, write_file, write_files


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def target(tmp_path):
    path = tmp_path / "trials.csv"
    path.write_text("old", encoding="utf-8")
    return path


def refuse_from(monkeypatch, where, number):
    """Let the system refuse an operation of the part file."""

    def fail(*_, **__):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(disk.os, where, fail)


def test_a_disk_that_is_full_or_refuses_is_the_users_to_mend(target, monkeypatch):
    for number, hint in {errno.ENOSPC: "make room", errno.EDQUOT: "make room",
            errno.EROFS: "you may write to", errno.EIO: "another place"}.items():  # fmt: skip
        refuse_from(monkeypatch, "fsync", number)
        with pytest.raises(DataError, match="cannot be written") as caught:
            write_file(target, "new")
        assert (caught.value.code, caught.value.where) == ("RF105", target.as_posix())
        assert hint in caught.value.fix
        assert (target.read_text(encoding="utf-8"), names(target.parent)) == ("old", ["trials.csv"])


def test_whatever_ends_the_writing_leaves_the_old_file_and_no_rest(target):
    for failure in (KeyboardInterrupt, KeyboardInterrupt(15), ZeroDivisionError, SystemExit):
        with pytest.raises(BaseException), replacing(target) as stream:  # noqa: B017, PT012
            stream.write(b"half of the n")
            raise failure
        assert (target.read_text(encoding="utf-8"), names(target.parent)) == ("old", ["trials.csv"])


def test_nobody_reads_half_a_file(target):
    with replacing(target) as stream:
        stream.write(b"ne")
        stream.flush()
        assert target.read_text(encoding="utf-8") == "old"
        stream.write(b"w")
    assert target.read_text(encoding="utf-8") == "new"


def test_nothing_is_written_through_a_link(tmp_path):
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    (tmp_path / "folder").mkdir()
    for kind in ("file", "dangling", "folder"):
        link = tmp_path / f"link to {kind}"
        link.symlink_to(tmp_path / kind)
        with pytest.raises(DataError, match=rf"this is a link, to .*{kind}"):
            write_file(link, "new")
        assert link.is_symlink()
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "dangling").exists()


def test_what_is_or_can_be_no_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").write_text("", encoding="utf-8")
    pipe = "device or pipe"
    for path, what in {"/dev/null": pipe, tmp_path / "pipe": pipe, tmp_path: "folder"}.items():
        with pytest.raises(DataError, match=what):
            write_file(path, "new")
    assert not os.path.isfile("/dev/null")  # noqa: PTH113
    for name in ("x" * 300, "fi\0le", "file/below"):
        with pytest.raises(DataError) as caught:
            write_file(tmp_path / name, "new")
        assert caught.value.code == "RF105"
    assert names(tmp_path) == ["file", "pipe"]


def test_the_longest_name_the_system_takes_is_taken(tmp_path):
    assert write_file(tmp_path / ("x" * 255), "new").read_text(encoding="utf-8") == "new"


def test_a_file_keeps_its_permissions_and_a_new_one_gets_the_usual(target):
    target.chmod(0o600)
    write_file(target, "new")
    assert target.stat().st_mode & 0o777 == 0o600
    usual = target.parent / "usual"
    usual.touch()
    assert write_file(target.parent / "made", "").stat().st_mode == usual.stat().st_mode


def test_new_files_come_all_or_none_and_over_nobodys_work(tmp_path, monkeypatch):
    contents = {"a.txt": b"1", "b.txt": b"2"}
    write_files(tmp_path, contents)
    with pytest.raises(InputError, match="there already"):
        write_files(tmp_path, {"c.txt": b"3", "b.txt": b"4"})
    assert names(tmp_path) == ["a.txt", "b.txt"]
    calls = []

    def full(number):
        calls.append(number)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(disk.os, "fsync", full)
    with pytest.raises(DataError, match="no space left"):
        write_files(tmp_path / "new", contents)
    assert names(tmp_path / "new") == []
