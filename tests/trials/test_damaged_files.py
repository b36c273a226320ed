"""What spoils the samples of a recording ends in an honest status, a sign that is reversed is turned and told.

Unreadable files: `readers/test_damaged.py`; clocks: `readers/test_clock.py`; any damage: `tests/fuzz`.
"""

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


# How the text of a good recording with a peak of 100 N at 1.3 s is spoilt, and the statuses that are honest answers.
UNREADABLE = {"unreadable"}
NO_FORCE = {"unreadable", "too-short", "no-breakaway", "no-peak", "saturated"}
CORPUS = {
    "cut inside idle": (lambda text: "\n".join(text.splitlines()[:200]) + "\n", NO_FORCE),
    "all forces NaN": (lambda text: with_force(text, lambda i, f: "nan"), NO_FORCE - {"saturated"}),
    "every second force missing": (lambda text: with_force(text, lambda i, f: f if i % 2 else ""), {"ok"}),
    "a NaN at the peak": (lambda text: with_force(text, lambda i, f: "nan" if i == 1300 else f), {"ok"}),
    "constant": (lambda text: with_force(text, lambda i, f: "5"), {"no-breakaway", "no-peak"}),
    "noise alone": (
        lambda text: with_force(text, lambda i, f: str(np.random.default_rng(i).standard_normal())),
        {"no-breakaway", "no-peak"},
    ),
    "backwards clock": (lambda text: table(reversed(rows(text))), UNREADABLE),
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


@pytest.mark.parametrize("settings", ["", '[tare]\ninterval = ["0 s", "0.25 s"]'])
def test_a_reversed_force_is_read_and_told(lab, good, settings):
    (lab.folder / "a.csv").write_text(good)
    (lab.folder / "b.csv").write_text(with_force(good, lambda i, f: str(-float(f))))
    extraction = lab.write([lab.row("a.csv"), lab.row("b.csv", trial="b")], settings).extract()
    right, turned = extraction.trials
    assert (turned.peak_N, turned.breakaway.status) == (right.peak_N, "ok")
    (problem,) = [one for one in extraction.problems if one.code == "RF241"]
    assert problem.path == "b.csv"
    assert 'force = "-force"' in problem.fix
