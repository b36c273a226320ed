"""A command's folder: whose files are whose, what goes with the next run, and one run at a time."""

import errno
import hashlib
import json
import os
import signal
import subprocess
import sys

import pytest

from ropefric.errors import DataError
from ropefric.files import folder as folders
from ropefric.files.folder import OWN, Folder, OutputFolder, as_folder


def tree(folder):
    """Every file people see, with its text."""
    return {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*")) if path.is_file() and OWN not in path.parts}  # fmt: skip


def own(out):
    return sorted(path.name for path in (out / OWN).iterdir())


def put(out, contents, part="answer", **options):
    """One run that writes these files."""
    with OutputFolder(out, **{"family": "campaign"} | options) as folder:
        paths = folder.write(contents)
        folder.publish(part)
    return paths


@pytest.fixture
def out(tmp_path):
    return tmp_path / "deep" / "out"


# --- whose files these are ---


def test_a_folder_of_ours_is_written_again_and_again(out, tmp_path):
    for text in ("one", "two", "two"):
        assert put(out, {"a.txt": text, "sub/b.txt": text}) == (out / "a.txt", out / "sub" / "b.txt")
        assert tree(out) == {"a.txt": text, "sub/b.txt": text}
    assert {path.name: path.stat().st_size > 0 for path in (out / OWN).iterdir()} == {
        "files.json": True,
        "lock": False,
    }
    put(tmp_path / "again", {"a.txt": "two", "sub/b.txt": "two"})
    one, two = ((folder / OWN / "files.json").read_bytes() for folder in (out, tmp_path / "again"))
    assert one == two


@pytest.mark.parametrize("name", ["a.txt", "sub/b.txt"])
def test_a_file_of_others_is_refused_before_the_work(out, name):
    (out / name).parent.mkdir(parents=True)
    (out / name).write_text("mine", encoding="utf-8")
    (out / "other.txt").write_text("mine too", encoding="utf-8")
    with pytest.raises(DataError, match="did not write this file") as caught:
        OutputFolder(out, family="campaign", names=["a.txt", "sub/*.txt"]).__enter__()
    assert (caught.value.code, caught.value.where) == ("RF150", (out / name).as_posix())
    assert "--force" in caught.value.fix
    assert not (out / OWN).exists()
    put(out, {name: "new"}, names=[name], force=True)
    assert tree(out) == {name: "new", "other.txt": "mine too"}
    put(out, {name: "newer"}, names=[name])


def test_a_file_of_others_that_appears_meanwhile_is_not_replaced_either(out):
    with OutputFolder(out, family="campaign") as folder:
        folder.write({"a.txt": "new", "b.txt": "new"})
        (out / "b.txt").write_text("mine", encoding="utf-8")
        with pytest.raises(DataError, match="did not write"):
            folder.publish("answer")
    assert tree(out) == {"b.txt": "mine"}


def test_a_file_of_ours_that_was_changed_is_somebody_elses(out):
    put(out, {"a.txt": "old"})
    (out / "a.txt").write_text("old, and my remarks", encoding="utf-8")
    with pytest.raises(DataError, match="changed since ropefric wrote it"):
        put(out, {"a.txt": "new"}, names=["a.txt"])
    assert tree(out) == {"a.txt": "old, and my remarks"}


def test_without_a_sound_list_nothing_is_ours(out):
    for damage in ("", "{", "[]", '{"schema": "ropefric.files/9", "files": {}}', '{"files": 3}'):
        put(out, {"a.txt": "old"}, force=True)
        (out / OWN / "files.json").write_text(damage, encoding="utf-8")
        with pytest.raises(DataError, match="did not write"):
            put(out, {"a.txt": "new"}, names=["a.txt"])
        put(out, {"a.txt": "new"}, force=True)
        assert tree(out) == {"a.txt": "new"}


def test_an_input_is_never_replaced_by_whatever_name_it_goes(out, tmp_path):
    put(out, {"a.txt": "old"})
    os.link(out / "a.txt", tmp_path / "hard.txt")
    for source in (out / "a.txt", tmp_path / "hard.txt", out / ".." / "out" / "a.txt"):
        for force in (False, True):
            with pytest.raises(DataError, match="input of the same command") as caught:
                put(out, {"a.txt": "new"}, names=["a.txt"], inputs=[source], force=force)
            assert caught.value.code == "RF151"
    put(out, {"b.txt": "new"}, names=["b.txt"], inputs=[out / "a.txt", tmp_path / "nowhere"])
    assert tree(out)["a.txt"] == "old"


# --- links and places that cannot be used ---


def test_a_folder_within_that_leads_elsewhere_is_refused(out, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    out.mkdir(parents=True)
    for which in ("sub", OWN, ".cache"):
        (out / which).symlink_to(elsewhere)
        with pytest.raises(DataError, match="link"):
            put(out, {"sub/b.txt": "new"}, names=["sub/b.txt"], force=True)
        assert list(elsewhere.iterdir()) == []
        (out / which).unlink()


def test_a_link_in_the_place_of_a_file_is_not_written_through(out, tmp_path):
    put(out, {"a.txt": "old", "sub/b.txt": "old"})
    (tmp_path / "mine").write_text("old", encoding="utf-8")
    (out / "a.txt").unlink()
    (out / "a.txt").symlink_to(tmp_path / "mine")
    with pytest.raises(DataError, match="nothing is written through links"):
        put(out, {"a.txt": "new"}, names=["a.txt"], force=True)
    assert (tmp_path / "mine").read_text(encoding="utf-8") == "old"


def test_a_link_to_a_folder_is_that_folder(out, tmp_path):
    put(out, {"a.txt": "old"})
    (tmp_path / "link").symlink_to(out)
    put(tmp_path / "link", {"a.txt": "new"}, names=["a.txt"])
    assert tree(out) == {"a.txt": "new"}


def test_a_list_that_names_files_outside_reaches_none(out, tmp_path):
    """A folder of results may come from anywhere, and its list is not believed where it leads out."""
    put(out, {"a.txt": "old"})
    victim = tmp_path / "victim.txt"
    victim.write_text("mine", encoding="utf-8")
    sha256 = hashlib.sha256(b"mine").hexdigest()
    path = out / OWN / "files.json"
    listed = json.loads(path.read_text(encoding="utf-8"))
    for name in ("../../victim.txt", victim.as_posix()):
        listed["files"][name] = {"sha256": [sha256], "parts": ["campaign/answer"], "basis": ""}
    path.write_text(json.dumps(listed), encoding="utf-8")
    put(out, {"a.txt": "new"})
    assert victim.read_text(encoding="utf-8") == "mine"


def test_what_cannot_be_a_folder_is_said_at_once(tmp_path):
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    for name in ("file", "file/below", "x" * 300, "fi\0le"):
        with pytest.raises(DataError) as caught:
            OutputFolder(tmp_path / name, family="campaign").__enter__()
        assert (caught.value.code, tree(tmp_path)) == ("RF105", {"file": "mine"})


def test_a_folder_that_takes_no_files_is_found_before_the_work(out, monkeypatch):
    out.mkdir(parents=True)

    def read_only(*_, **__):
        raise OSError(errno.EROFS, "Read-only file system")

    monkeypatch.setattr(folders.os, "open", read_only)
    with pytest.raises(DataError, match="read-only file system"):
        OutputFolder(out, family="campaign").__enter__()


# --- what fits together ---


def test_what_an_earlier_run_wrote_and_this_one_does_not_goes(out):
    names = ("a.txt", "b.txt", "figures/x.png", "figures/y.png", "figures/z.png", "fits/z.json")
    put(out, dict.fromkeys(names, "1"))
    (out / "figures" / "mine.png").write_text("mine", encoding="utf-8")
    (out / "figures" / "y.png").write_text("1, and my remarks", encoding="utf-8")
    put(out, {"a.txt": "2", "figures/x.png": "2"})
    left = {
        "figures/mine.png": "mine",
        "figures/y.png": "1, and my remarks",
    }  # what was changed by hand stays
    assert tree(out) == {"a.txt": "2", "figures/x.png": "2"} | left
    assert not (out / "fits").exists()


def test_other_parts_stay_as_long_as_what_they_rest_on(out):
    basis = {"basis": "trials.csv"}
    put(out, {"trials.csv": "forces"}, "tables", **basis)
    put(out, {"figures/x.png": "picture", "figures/x.csv": "numbers"}, "figures", **basis)
    put(out, {"report.html": "page", "figures/x.csv": "numbers"}, "answer", **basis)
    before = tree(out)
    put(out, {"trials.csv": "forces"}, "tables", **basis)
    assert tree(out) == before
    put(out, {"report.html": "page without figures"}, "answer", **basis)
    assert tree(out).keys() == before.keys()
    put(out, {"trials.csv": "other forces"}, "tables", **basis)
    assert tree(out) == {"trials.csv": "other forces"}


def test_families_let_each_other_be(out):
    put(out, {"answer.json": "1", "start_up.csv": "1"}, family="scene")
    put(out, {"trials.csv": "1"}, basis="trials.csv")
    put(out, {"answer.json": "2"}, family="scene")
    put(out, {"trials.csv": "2"}, basis="trials.csv")
    assert tree(out) == {"answer.json": "2", "trials.csv": "2"}


def test_a_plain_folder_is_written_into_at_once(tmp_path):
    plain = as_folder(tmp_path)
    assert plain.write({"a.txt": "1"})[0].read_text(encoding="utf-8") == "1"
    plain.publish("anything")
    assert as_folder(plain) is plain
    assert isinstance(plain, Folder)


# --- stopped in between ---

STOPPED = """
import os, signal, sys
from ropefric.files import disk
from ropefric.files.folder import OutputFolder
calls = []
real = disk.put_in_place
def stop(*what):
    calls.extend([what] if what[1].suffix == ".txt" else [])
    if calls and calls[-1] is what and len(calls) == int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)
    real(*what)
disk.put_in_place = stop
with OutputFolder(sys.argv[1], family="campaign", names=["*.txt"], basis="a.txt") as folder:
    folder.write({"a.txt": "new", "b.txt": "new", "c.txt": "new"})
    folder.publish("answer")
"""


@pytest.mark.parametrize(
    "at", [pytest.param(1, marks=pytest.mark.slow), 2, pytest.param(3, marks=pytest.mark.slow)]
)
def test_after_a_kill_every_file_is_whole_and_the_next_run_goes_on(out, at):
    put(out, {"a.txt": "old", "b.txt": "old", "gone.txt": "old"}, basis="a.txt")
    done = subprocess.run([sys.executable, "-c", STOPPED, str(out), str(at)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert set(tree(out).values()) <= {"old", "new"}
    assert "gone.txt" not in tree(out)
    put(out, {"a.txt": "newer"}, names=["*.txt"], basis="a.txt")
    assert (tree(out), own(out)) == ({"a.txt": "newer"}, ["files.json", "lock"])


def test_a_run_that_is_stopped_before_the_end_leaves_the_old_result(out):
    put(out, {"a.txt": "old", "b.txt": "old"})
    for failure in (KeyboardInterrupt, KeyboardInterrupt(15), OSError(errno.ENOSPC, "full")):
        with pytest.raises(BaseException), OutputFolder(out, family="campaign") as folder:  # noqa: B017, PT012
            folder.write({"a.txt": "new"})
            with folder.stream("b.txt") as stream:
                stream.write(b"half of the n")
                raise failure
        assert tree(out) == {"a.txt": "old", "b.txt": "old"}
        assert own(out) == ["files.json", "lock"]


def test_a_full_disk_at_any_moment_leaves_whole_files_and_is_the_users_to_mend(out, monkeypatch):
    """The system refuses the first, second, … operation that needs room, until one run needs no more than it gets."""
    real = os.fsync
    left = 0

    def fsync(handle):
        nonlocal left
        left -= 1
        if left < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        real(handle)

    monkeypatch.setattr(folders.os, "fsync", fsync)
    refused = 0
    for room in range(50):
        left = 50
        put(out, {"a.txt": "old", "b.txt": "old"})
        left = room
        try:
            put(out, {"a.txt": "new", "b.txt": "new"}, names=["*.txt"])
        except DataError as error:
            refused, fix = refused + 1, error.fix
        else:
            break
        assert "make room" in fix
        assert set(tree(out)) == {"a.txt", "b.txt"}
        assert set(tree(out).values()) <= {"old", "new"}
    assert refused == 4  # two files, and the list before and after them
    assert set(tree(out).values()) == {"new"}


# --- one run at a time ---

HOLD = """
import sys
from ropefric.files.folder import OutputFolder
out = sys.argv[1]
sys.argv = ["bin/ropefric", "run", "that"]
with OutputFolder(out, family="campaign"):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def holder(out):
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(out)], stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, text=True)  # fmt: skip
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def test_a_second_run_is_told_of_the_first_whose_lock_ends_with_its_process(out, holder):
    with pytest.raises(
        DataError, match=rf"process {holder.pid} on .+, since 20.*: `ropefric run that`"
    ) as caught:
        put(out, {"a.txt": "new"}, force=True)
    assert caught.value.code == "RF152"
    holder.kill()
    holder.wait()
    put(out, {"a.txt": "new"})


def test_a_worker_that_outlives_its_parent_holds_no_lock(out):
    code = ("import os, signal, sys, time\nfrom ropefric.files.folder import OutputFolder\n"
        "with OutputFolder(sys.argv[1], family='campaign'):\n    if os.fork() == 0:\n"
        "        os.close(1)\n        sys.stdin.read()\n        os._exit(0)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n")  # fmt: skip
    process = subprocess.Popen([sys.executable, "-c", code, str(out)], stdin=subprocess.PIPE)
    try:
        assert process.wait() == -signal.SIGKILL
        put(out, {"a.txt": "new"})
    finally:
        process.communicate()


def test_two_runs_in_one_process_are_two(out):
    with OutputFolder(out, family="campaign"), pytest.raises(DataError, match=f"process {os.getpid()}"):
        put(out, {"a.txt": "new"})
    put(out, {"a.txt": "new"})


def test_a_lock_that_nobody_holds_or_that_the_system_does_not_know_is_no_obstacle(out, monkeypatch):
    (out / OWN).mkdir(parents=True)
    (out / OWN / "lock").write_text("process 1 on elsewhere", encoding="utf-8")
    put(out, {"a.txt": "new"})

    def unknown(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(folders.fcntl, "lockf", unknown)
    put(out, {"a.txt": "newer"})
    assert own(out) == ["files.json", "lock"]


def test_a_folder_of_others_is_refused_whatever_the_names_are(out):
    out.mkdir(parents=True)
    (out / "photo.jpg").write_bytes(b"1")
    with pytest.raises(DataError, match=r"neither new nor one of ropefric's: it holds photo\.jpg") as caught:
        put(out, {"a.txt": "new"})
    assert caught.value.code == "RF150"
    assert [path.name for path in out.iterdir() if path.name != OWN] == ["photo.jpg"]
    put(out, {"a.txt": "new"}, force=True)
    put(out, {"a.txt": "newer"})  # now it is one of ropefric's, too
    assert tree(out) == {"a.txt": "newer", "photo.jpg": "1"}


def test_hidden_files_and_what_others_add_later_are_no_obstacle(out):
    out.mkdir(parents=True)
    (out / ".gitignore").write_text("*")
    put(out, {"a.txt": "new"})
    (out / "notes.md").write_text("mine")
    put(out, {"a.txt": "newer"})
    assert {"a.txt": "newer", "notes.md": "mine"}.items() <= tree(out).items()
