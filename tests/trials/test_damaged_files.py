"""Whatever is in a file: a status or an error of one's own, never another exception, never a silent number."""

import gzip
import io

import numpy as np
import pytest

from ropefric.errors import RopefricError

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


def workbook(text):
    import openpyxl

    stream = io.BytesIO()
    openpyxl.Workbook().save(stream)
    return stream.getvalue()


# How the text of a good recording with a peak of 100 N at 1.3 s is spoilt, and the statuses that are honest answers.
UNREADABLE = {"unreadable"}
NO_FORCE = {"unreadable", "too-short", "no-breakaway", "no-peak", "saturated"}
CORPUS = {
    "empty": (lambda text: b"", UNREADABLE),
    "one row": (lambda text: HEAD + "0,1\n", {"unreadable", "too-short"}),
    "ten rows": (lambda text: "\n".join(text.splitlines()[:11]) + "\n", {"unreadable", "too-short"}),
    "cut inside idle": (lambda text: "\n".join(text.splitlines()[:200]) + "\n", NO_FORCE),
    "cut while loading": (lambda text: "\n".join(text.splitlines()[:900]) + "\n", {"no-breakaway", "too-short"}),
    "cut in a number": (lambda text: text[: text.rindex(",") + 2], {"ok"}),
    "cut in a row": (lambda text: text[: text.rindex(",")], UNREADABLE),
    "binary": (lambda text: np.random.default_rng(0).bytes(5000), UNREADABLE),
    "nothing but zero bytes": (lambda text: b"\0" * 5000, UNREADABLE),
    "zero bytes at the end": (lambda text: text.encode() + b"\0" * 512, UNREADABLE),
    "a picture": (lambda text: b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 10, UNREADABLE),
    "utf-16 without a mark": (lambda text: text.encode("utf-16-le"), UNREADABLE),
    "utf-32": (lambda text: text.encode("utf-32"), {"ok"}),  # it says so itself
    "ebcdic": (lambda text: text.encode("cp500"), UNREADABLE),
    "a web page": (lambda text: "<html><body>404, not found</body></html>\n" * 3, UNREADABLE),
    "a workbook": (workbook, UNREADABLE),
    "all forces NaN": (lambda text: with_force(text, lambda i, f: "nan"), NO_FORCE - {"saturated"}),
    "all forces missing": (lambda text: with_force(text, lambda i, f: ""), NO_FORCE - {"saturated"}),
    "all times missing": (lambda text: with_time(text, lambda i, t: ""), UNREADABLE),
    "nothing but separators": (lambda text: HEAD + ",\n" * 2000, UNREADABLE | {"too-short"}),
    "every second force missing": (lambda text: with_force(text, lambda i, f: f if i % 2 else ""), {"ok"}),
    "a NaN at the peak": (lambda text: with_force(text, lambda i, f: "nan" if i == 1300 else f), {"ok"}),
    "constant": (lambda text: with_force(text, lambda i, f: "5"), {"no-breakaway", "no-peak"}),
    "zero": (lambda text: with_force(text, lambda i, f: "0"), {"no-breakaway", "no-peak"}),
    "noise alone": (
        lambda text: with_force(text, lambda i, f: str(np.random.default_rng(i).standard_normal())),
        {"no-breakaway", "no-peak"},
    ),
    "upside down": (lambda text: with_force(text, lambda i, f: str(-float(f))), {"ok"}),  # and told, RF241
    "rows in no order": (shuffled, UNREADABLE),
    "backwards clock": (lambda text: table(reversed(rows(text))), UNREADABLE),
    "a clock set back": (back_in_the_middle, UNREADABLE),
    "a clock that stands": (lambda text: with_time(text, lambda i, t: "0.5"), UNREADABLE),
    "minus Infinity": (lambda text: with_force(text, lambda i, f: "-Infinity" if i == 9 else f), UNREADABLE),
    "an infinite time": (lambda text: with_time(text, lambda i, t: "inf" if i == 2000 else t), UNREADABLE),
    "a huge time": (lambda text: with_time(text, lambda i, t: f"{t}e300" if i == 2499 else t), NO_FORCE | {"ok"}),
    "one huge spike": (lambda text: with_force(text, lambda i, f: "1e300" if i == 700 else f), UNREADABLE),
    "one column": (lambda text: "force_N\n" + "".join(f"{f}\n" for _, f in rows(text)), UNREADABLE),
    "three headers": (lambda text: text.replace(HEAD, "time_s,force_N,pressure_bar\n"), UNREADABLE),
    "thousands": (lambda text: with_force(text, lambda i, f: '"1,234"'), NO_FORCE),
    "repeated header": (lambda text: text + text, UNREADABLE),
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


GZIP_DAMAGE = {"cut off": lambda data: data[: len(data) // 2],
    "cut in the checksum": lambda data: data[:-3], "header alone": lambda data: data[:10],
    "two bytes": lambda data: data[:2],
    "a bit in the middle": lambda data: data[:5000] + bytes([data[5000] ^ 16]) + data[5001:],
    "the checksum": lambda data: data[:-6] + bytes([data[-6] ^ 1]) + data[-5:],
    "rubbish after the end": lambda data: data + b"rubbish", "not packed at all": gzip.decompress
}  # fmt: skip


def test_damaged_gzip_is_never_half_read_nor_is_what_its_name_promises_wrongly(lab, good, allowed):
    data, names = gzip.compress(good.encode(), mtime=0), []
    for number, damage in enumerate(GZIP_DAMAGE.values()):
        names.append(f"bad{number}.csv.gz")
        (lab.folder / names[-1]).write_bytes(damage(data))
    for number, content in enumerate((b"", b"time_s,force_N\n0,1\n", bytes(range(256)) * 20)):
        for ending in (".xlsx", ".mat", ".tdms", ".xls", ".weird", ""):
            names.append(f"other{number}{ending}")
            (lab.folder / names[-1]).write_bytes(content)
    for trial in lab.write([lab.row(name) for name in names]).extract().trials:
        is_text = trial.file in {
            "other1.weird",
            "other1",
            "other1.xls",
            "other1.xlsx",
        }  # loggers call text so
        assert trial.breakaway.status == ("too-short" if is_text else "unreadable"), trial.file
        allowed(trial)


def test_a_folder_or_a_missing_file_in_the_place_of_a_recording(lab, good, allowed):
    (lab.folder / "good.csv").write_text(good)
    (lab.folder / "folder.csv").mkdir()
    lab.write([lab.row("folder.csv"), lab.row("good.csv"), lab.row("gone.csv")])
    with pytest.raises(RopefricError) as caught:
        lab.load()
    assert [problem.code for problem in caught.value.problems] == ["RF124"] * 2
    folder, sound, gone = lab.extract(missing_recordings="flag").trials
    assert [one.breakaway.status for one in (folder, sound, gone)] == ["unreadable", "ok", "unreadable"]
    assert "folder" in folder.breakaway.detail
    for trial in (folder, gone):
        allowed(trial)
        assert trial.sha256 == ""


def test_a_break_away_force_below_zero_is_told(lab, good, allowed):
    """A cell without a tare, 500 N off: a rope cannot push."""
    (lab.folder / "a.csv").write_text(with_force(good, lambda i, f: f"{float(f) - 500:.4f}"))
    (trial,) = lab.write([lab.row("a.csv")]).extract().trials
    allowed(trial)
    assert trial.breakaway.status != "ok"
    assert np.isnan(trial.peak_N)
    tare = '[tare]\ninterval = ["0 s", "0.25 s"]'
    (trial,) = lab.write([lab.row("a.csv")], tare).extract().trials
    assert trial.peak_N == pytest.approx(100, rel=2e-3)
