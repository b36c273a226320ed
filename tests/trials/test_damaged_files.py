"""What spoils the samples of a recording ends in an honest status; unreadable files: `readers/test_damaged.py`."""

import gzip

import numpy as np
import pytest

HEAD = "time_s,force_N\n"


def rows(text):
    return [line.split(",") for line in text.splitlines()[1:]]


def table(cells):
    return HEAD + "".join(f"{t},{f}\n" for t, f in cells)


def with_force(text, change):
    return table((t, change(i, f)) for i, (t, f) in enumerate(rows(text)))


def with_time(text, change):
    return table((change(i, t), f) for i, (t, f) in enumerate(rows(text)))


def shuffled(text):
    cells = rows(text)
    return table(cells[i] for i in np.random.default_rng(1).permutation(len(cells)))


def back_in_the_middle(text):
    cells = rows(text)
    half = len(cells) // 2
    return table([*cells[:half], *((f"{float(t) - 1.0:.4f}", f) for t, f in cells[half:])])


# How the text of a good recording with a peak of 100 N at 1.3 s is spoilt, and the statuses that are honest answers.
UNREADABLE = {"unreadable"}
NO_FORCE = {"unreadable", "too-short", "no-breakaway", "no-peak", "saturated"}
CORPUS = {
    "ten rows": (lambda text: "\n".join(text.splitlines()[:11]) + "\n", {"unreadable", "too-short"}),
    "cut inside idle": (lambda text: "\n".join(text.splitlines()[:200]) + "\n", NO_FORCE),
    "cut while loading": (lambda text: "\n".join(text.splitlines()[:900]) + "\n", {"no-breakaway", "too-short"}),
    "cut in a number": (lambda text: text[: text.rindex(",") + 2], {"ok"}),
    "all forces NaN": (lambda text: with_force(text, lambda i, f: "nan"), NO_FORCE - {"saturated"}),
    "all times missing": (lambda text: with_time(text, lambda i, t: ""), UNREADABLE),
    "every second force missing": (lambda text: with_force(text, lambda i, f: f if i % 2 else ""), {"ok"}),
    "a NaN at the peak": (lambda text: with_force(text, lambda i, f: "nan" if i == 1300 else f), {"ok"}),
    "constant": (lambda text: with_force(text, lambda i, f: "5"), {"no-breakaway", "no-peak"}),
    "noise alone": (
        lambda text: with_force(text, lambda i, f: str(np.random.default_rng(i).standard_normal())),
        {"no-breakaway", "no-peak"},
    ),
    "upside down": (lambda text: with_force(text, lambda i, f: str(-float(f))), {"ok"}),  # and told, RF241
    "rows in no order": (shuffled, UNREADABLE),
    "backwards clock": (lambda text: table(reversed(rows(text))), UNREADABLE),
    "a clock set back": (back_in_the_middle, UNREADABLE),
    "a clock that stands": (lambda text: with_time(text, lambda i, t: "0.5"), UNREADABLE),
    "a huge time": (lambda text: with_time(text, lambda i, t: f"{t}e300" if i == 2499 else t), NO_FORCE | {"ok"}),
    "one huge spike": (lambda text: with_force(text, lambda i, f: "1e300" if i == 700 else f), UNREADABLE),
    "thousands": (lambda text: with_force(text, lambda i, f: '"1,234"'), NO_FORCE),
}  # fmt: skip


@pytest.fixture(scope="module")
def good(pull_csv):
    return pull_csv(100.0, seed=5)


def test_damage_ends_in_an_honest_status_and_leaves_the_next_recording_alone(lab, good, allowed):
    """Every second file is packed."""
    names = {case: f"bad{i}.csv{'.gz' * (i % 2)}" for i, case in enumerate(CORPUS)}
    for case, name in names.items():
        content = CORPUS[case][0](good)
        content = content.encode() if isinstance(content, str) else content
        packed = name.endswith(".gz")
        (lab.folder / name).write_bytes(gzip.compress(content, mtime=0) if packed else content)
    (lab.folder / "good.csv").write_text(good)
    (alone,) = lab.write([lab.row("good.csv")]).extract().trials
    listed = [*(lab.row(name) for name in names.values()), lab.row("good.csv")]
    *found, sound = lab.write(listed).extract().trials
    assert sound.to_dict() == alone.to_dict()
    for case, bad in zip(CORPUS, found, strict=True):
        status, detail = bad.breakaway.status, bad.breakaway.detail
        assert status in CORPUS[case][1], f"{case}: {status}, {detail}"
        allowed(bad)
        if status == "ok":
            assert bad.peak_N == pytest.approx(100.0, rel=0.01), case
        assert status != "unreadable" or names[case] in detail, case


def test_a_gap_over_the_peak_is_no_certain_force(lab, good, allowed):
    """The last sample before the gap reads 90 N; the rope broke away at 100 N inside it."""
    text = with_force(good, lambda i, f: "" if 1200 < i < 1400 else f)
    (lab.folder / "bad.csv").write_text(text)
    (trial,) = lab.write([lab.row("bad.csv")]).extract().trials
    allowed(trial)
    assert trial.breakaway.status != "ok" or abs(trial.peak_N - 100) < 3 * trial.peak_std_N
