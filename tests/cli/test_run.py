"""`run`: a campaign's whole way on small simulated campaigns."""

import csv

from ropefric.cli.app import main

NOT_TRUSTED = 4
FILES = {*("trials.csv", "conditions.csv", "problems.csv", "comparison.csv", "prediction.json",
    "fits/constant.json"), *("summary.txt", "report.html", "manifest.json", "uncertainty.json",
    "next_tests.csv")}  # fmt: skip


def files(folder):
    """Every file by name."""
    found = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


def test_everything_is_written_and_told(call, tmp_path, few_laws):
    """Six conditions that obey the capstan equation; their figures are looked at where names are hostile."""
    out = tmp_path / "out"
    words = ["--law", "constant", "-p", "mu=0.15", "--conditions", "6", "--repeats", "2", "--no-faults", "-q",
        "--seed", "5"]  # fmt: skip
    assert main(["simulate", str(tmp_path / "campaign"), *words]) == 0
    done = call("run", tmp_path / "campaign", "--out", out, "--no-figures")
    assert done.code == 0, done.err
    assert files(out).keys() >= FILES
    assert not (out / "figures").exists()
    for said in (*("The law: constant", "95 % interval", "ΔAICc", "Doubts", "F_A = ",
            "95 % confidence interval"), *("95 % prediction interval", f"written to {out}")):  # fmt: skip
        assert said in done.out
    assert "extract 12/12" in done.err
    # Of alike warnings, what they have in common is said once.
    (line,) = (line for line in done.err.splitlines() if "(6 such: this; R_w = " in line)
    assert line.count("the ±2s rule cannot reject anything") == 1
    assert done.out.startswith((out / "summary.txt").read_text(encoding="utf-8"))


def test_json_alone_on_stdout_and_the_same_bytes_however_it_is_worked_through(
    call, bench, tmp_path, few_laws
):
    done = call("run", bench / "campaign.toml", "--out", tmp_path / "a", "--json", "-q", "--no-figures",
        "--jobs", "2")  # fmt: skip
    tree = done.json()
    # Two conditions of one wrap and one load tell no law from another.
    assert ((done.code, done.err), tree["extraction"]["n_trials"]) == ((NOT_TRUSTED, ""), 12)
    assert tree.keys() >= {"extraction", "ranking", "fit", "prediction"}
    assert tree["fit"]["law"] in {entry["law"] for entry in tree["ranking"]}
    assert tree["fit"]["schema"] == "ropefric.fit/1"
    assert tree["verdict"]["word"] == tree["prediction"]["verdict"]["word"] == "not judged"
    assert "on 2 conditions" in tree["verdict"]["reason"]
    keys = {"lift_force_N", "std_N", "interval_N", "level", "extrapolated", "method"}
    assert tree["prediction"].keys() >= keys
    before = files(tmp_path / "a")
    call("extract", bench / "campaign.toml", "--out", tmp_path / "a", "--no-figures", "--jobs", "1")
    assert files(tmp_path / "a") == before


def test_an_unknown_law_is_refused_before_the_work(call, bench, tmp_path):
    refused = call("run", bench, "--out", tmp_path / "other", "--law", "constnat")
    assert refused.code == 3
    assert "did you mean 'constant'?" in refused.err
    assert not (tmp_path / "other").exists()


def test_what_is_no_campaign_is_3_and_told(call, tmp_path):
    assert call("run", tmp_path / "nowhere.toml", "--out", tmp_path / "none").code == 3
    (tmp_path / "trials.csv").write_text("trial,file\n", encoding="utf-8")
    for command in ("run", "extract"):
        done = call(command, tmp_path / "trials.csv", "--out", tmp_path / "none")
        assert done.code == 3
        assert "this is a table, not a campaign" in done.err
        assert "`ropefric report` answers a table of forces" in done.err


def test_one_count_is_said_everywhere_and_adds_up(call, campaign, tmp_path, few_laws):
    """Kept, rejected, excluded and without a force: each trial is one of these; and the page escapes what it shows."""
    rows = list(csv.DictReader((campaign / "trials.csv").read_text(encoding="utf-8").splitlines()))
    for row in rows[3:5]:
        (campaign / row["file"]).write_bytes(b"")
    with (campaign / "trials.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(dict.fromkeys([*rows[0], "exclude"])))
        writer.writeheader()
        # The second empty file belongs to a trial that was excluded: it is counted once.
        writer.writerows(row | {"exclude": "slipped off" if n in {4, 7} else ""}
            for n, row in enumerate(rows))  # fmt: skip
    text = (campaign / "campaign.toml").read_text(encoding="utf-8").replace("two-sigma", "grubbs")
    (campaign / "campaign.toml").write_text(text.replace('name = "', 'name = "<b>&', 1), encoding="utf-8")
    done = call("run", campaign, "--out", tmp_path / "out", "--no-figures", "--law", "howell")
    assert done.code == NOT_TRUSTED
    assert "The law: howell, as asked for; not judged" in done.out
    tree = call("extract", campaign, "--out", tmp_path / "out", "--no-figures", "--json").json()
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
    assert all(one in page for one in (f"12 trials of 2 conditions: {words}", "<title>&lt;b&gt;&amp;"))
    assert f"Trials not kept (of 12 trials: {words})" in page
    assert "1 trial without a force: unreadable" in page
    assert "flagged" not in page
    assert page.startswith("<!DOCTYPE html>")
    for foreign in ("<b>&", "http:", "https:", "src=", "<script", "@import"):
        assert foreign not in page
