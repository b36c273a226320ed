"""`run`: a campaign's whole way on small simulated campaigns."""

import csv
import shutil

import pytest

NOT_TRUSTED = 4
FILES = {
    *("trials.csv", "conditions.csv", "problems.csv", "comparison.csv", "prediction.json"),
    *("summary.txt", "report.html", "manifest.json", "uncertainty.json", "next_tests.csv"),
}


@pytest.fixture(scope="module")
def capstan(tmp_path_factory):
    """Nine conditions of three pulls that obey the capstan equation."""
    from ropefric.cli.app import main

    folder = tmp_path_factory.mktemp("capstan") / "campaign"
    words = ["--law", "constant", "-p", "mu=0.15", "--conditions", "9", "--repeats", "3", "--no-faults", "-q"]
    assert main(["simulate", str(folder), *words]) == 0
    return folder


def files(folder):
    return {
        p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()
    }


def test_everything_is_written_and_told(call, capstan, tmp_path):
    done = call("run", capstan, "--out", tmp_path)
    assert done.code == 0, done.err
    names = set(files(tmp_path))
    assert names >= FILES
    assert "fits/constant.json" in names
    assert sum(name.endswith(".png") for name in names) == 9
    for words in (
        *("The law: constant", "95 % interval", "ΔAICc", "Doubts", "F_A = ", "95 % confidence interval"),
        *("95 % prediction interval", f"written to {tmp_path}"),
    ):
        assert words in done.out
    assert "extract 27/27" in done.err
    assert "figures 9/9" in done.err
    summary = (tmp_path / "summary.txt").read_text(encoding="utf-8")
    assert done.out.startswith(summary)


def test_json_alone_on_stdout_with_the_agreed_shape(call, bench, tmp_path):
    done = call("run", bench / "campaign.toml", "--out", tmp_path, "--json", "--quiet", "--no-figures")
    tree = done.json()
    assert done.err == ""
    assert tree.keys() >= {"extraction", "ranking", "fit", "prediction"}
    assert tree["extraction"]["n_trials"] == 12
    assert tree["fit"]["law"] in {entry["law"] for entry in tree["ranking"]}
    assert tree["fit"]["schema"] == "ropefric.fit/1"
    assert done.code == NOT_TRUSTED
    assert tree["verdict"]["word"] == tree["prediction"]["verdict"]["word"] == "not judged"
    assert "on 2 conditions" in tree["verdict"]["reason"]
    assert tree["prediction"].keys() >= {
        "lift_force_N",
        "std_N",
        "interval_N",
        "level",
        "extrapolated",
        "method",
    }
    assert not (tmp_path / "figures").exists()


def test_the_same_bytes_however_it_is_worked_through(call, bench, tmp_path):
    runs = []
    for name, *options in (("a", "--jobs", "1"), ("b", "--jobs", "2"), ("a",)):
        call("run", bench, "--out", tmp_path / name, "--no-figures", *options)
        runs.append(files(tmp_path / name))
    assert runs[1:] == runs[:1] * 2


def test_the_page_is_whole_and_escapes_what_it_shows(call, bench, tmp_path):
    shutil.copytree(bench, tmp_path / "campaign")
    path = tmp_path / "campaign" / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('name = "', 'name = "<b>&', 1), encoding="utf-8")
    call("run", tmp_path / "campaign", "--out", tmp_path / "out", "--no-figures")
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert "<title>&lt;b&gt;&amp;" in page
    assert "<b>&" not in page
    for foreign in ("http:", "https:", "src=", "<script", "@import"):
        assert foreign not in page


def test_a_law_can_be_asked_for(call, bench, tmp_path):
    done = call("run", bench, "--out", tmp_path, "--no-figures", "--law", "constant-offset")
    assert "The law: constant-offset, as asked for" in done.out
    refused = call("run", bench, "--out", tmp_path / "other", "--law", "constnat")
    assert refused.code == 3
    assert "did you mean 'constant'?" in refused.err
    assert not (tmp_path / "other" / "trials.csv").exists()


def test_a_law_not_to_be_trusted_is_4(call, bench, tmp_path):
    """Two conditions of one wrap and one load tell no law from another."""
    done = call("run", bench, "--out", tmp_path, "--no-figures", "--law", "coupled")
    assert done.code == NOT_TRUSTED
    assert "coupled, as asked for; not judged" in done.out
    assert (tmp_path / "summary.txt").exists()


def test_nothing_to_extract_is_3_with_the_tables(call, bench, tmp_path):
    shutil.copytree(bench, tmp_path / "campaign")
    for path in (tmp_path / "campaign" / "traces").iterdir():
        path.write_bytes(b"")
    done = call("run", tmp_path / "campaign", "--out", tmp_path / "out", "--no-figures")
    assert (done.code, done.out) == (3, "")
    assert "none of the 12 recordings gave a usable force" in done.err
    assert (tmp_path / "out" / "problems.csv").exists()
    error = call("run", tmp_path / "campaign", "--out", tmp_path / "out", "--json").json()["error"]
    assert error["code"] == "RF301"


def test_a_campaign_that_is_not_there_is_3(call, tmp_path):
    assert call("run", tmp_path / "nowhere.toml", "--out", tmp_path / "out").code == 3


@pytest.mark.parametrize("command", ["run", "extract"])
def test_a_table_in_place_of_a_campaign_is_3_and_told_what_takes_it(call, tmp_path, command):
    (tmp_path / "trials.csv").write_text("trial,file\n", encoding="utf-8")
    done = call(command, tmp_path / "trials.csv", "--out", tmp_path / "out")
    assert done.code == 3
    assert "this is a table, not a campaign" in done.err
    assert "`ropefric report` answers a table of forces" in done.err


def test_one_count_is_said_everywhere_and_adds_up(call, bench, tmp_path):
    """Kept, rejected, excluded and without a force: each trial is one of these, wherever it is counted."""
    folder = tmp_path / "campaign"
    shutil.copytree(bench, folder)
    listed = (folder / "trials.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(listed))
    (folder / rows[3]["file"]).write_bytes(b"")
    (folder / rows[4]["file"]).write_bytes(b"")
    names = list(dict.fromkeys([*rows[0], "exclude"]))
    with (folder / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        # The second empty file belongs to a trial that was excluded: it is counted once.
        writer.writerows(
            row | {"exclude": "slipped off" if n in {4, 7} else ""} for n, row in enumerate(rows)
        )
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    (folder / "campaign.toml").write_text(text.replace("two-sigma", "mad"), encoding="utf-8")
    done = call("run", folder, "--out", tmp_path / "out", "--no-figures")
    tree = call("extract", folder, "--out", tmp_path / "out", "--no-figures", "--json").json()
    counts = tree["counts"]
    parts = [counts[f"n_{name}"] for name in ("kept", "rejected", "excluded", "without_force")]
    assert sum(parts) == counts["n_trials"] == sum(counts["status"].values()) == 12
    assert (parts[2], parts[3]) == (2, 1)
    assert counts["n_kept"] == sum(trial["kept"] for trial in tree["trials"])
    words = f"{parts[0]} kept, {f'{parts[1]} rejected, ' if parts[1] else ''}2 excluded, 1 without a force"
    assert f"12 trials: {words}" in done.err
    assert f"12 trials of 2 conditions: {words}" in done.out
    assert words in (tmp_path / "out" / "summary.txt").read_text(encoding="utf-8")
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert f"12 trials of 2 conditions: {words}" in page
    assert f"Trials not kept (of 12 trials: {words})" in page
    assert "1 trial without a force: unreadable" in page
    assert "flagged" not in page
