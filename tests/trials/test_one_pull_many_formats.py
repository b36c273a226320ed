"""The same pull, written as each logger writes it, gives the same force; what was recognised is in its notes."""

import datetime as dt

import numpy as np
import pytest

PEAK_N = 100.0
START = dt.datetime(2026, 10, 24, 23, 59, 59)  # noqa: DTZ001  (loggers write local time)


@pytest.fixture(scope="module")
def samples(pull_csv):
    rows = [line.split(",") for line in pull_csv(PEAK_N, seed=5).splitlines()[1:]]
    return [(float(time), force) for time, force in rows]


def labview(samples, columns="No"):
    general = ("LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n"
        f"X_Columns\t{columns}\nDate\t2026/03/05\nTime\t10:00:00\n***End_of_Header***\t\n\t\n")  # fmt: skip
    parts = []
    for k in range(0, len(samples), 500):  # written every half second, each time with a header
        time = f"10:00:{k / 1000:09.6f}".replace(".", ",")
        head = f"Channels\t1\nDate\t2026/03/05\nTime\t{time}\nY_Unit_Label\tNewtons\nX_Dimension\tTime\n"
        head += "X0\t0,0\nDelta_X\t0,001\n***End_of_Header***\nX_Value\tForce\tComment\n"
        rows = "".join(f"\t{force.replace('.', ',')}\n" for _, force in samples[k : k + 500])
        parts.append(f"{head}{rows}\n")
    return general + "".join(parts)


def german(samples):
    def row(time, force):
        stamp = (START + dt.timedelta(seconds=time)).strftime("%d.%m.%Y %H:%M:%S,%f")
        return f"{stamp};{force.replace('.', ',')}\n"

    return f"Wann;Kraft\n;N\n{''.join(row(*sample) for sample in samples)}Ende der Messung\n"


def test_every_format_gives_the_same_force(lab, samples, pull_csv):
    h5py, openpyxl = pytest.importorskip("h5py"), pytest.importorskip("openpyxl")
    (lab.folder / "plain.csv").write_text(pull_csv(PEAK_N, seed=5))
    (lab.folder / "a.lvm").write_text(labview(samples), encoding="utf-8")
    with h5py.File(lab.folder / "a.h5", "w") as file:
        file["force"] = np.array([float(force) for _, force in samples])
        file["force"].attrs.update({"unit": "N", "fs": 1000.0})
    book = openpyxl.Workbook()
    for row in [["time_s", "force_N"], *([time, float(force)] for time, force in samples)]:
        book.active.append(row)
    book.save(lab.folder / "a.xlsx")
    trials = lab.write([lab.row(name) for name in ("plain.csv", "a.h5", "a.xlsx", "a.lvm")]).extract().trials
    (lab.folder / "b.csv").write_text(german(samples), encoding="utf-8")
    settings = '[import.channels]\nforce = "Kraft"\ntime = "Wann"'
    trials += lab.write([lab.row("b.csv")], settings).extract().trials
    assert [trial.breakaway.status for trial in trials] == ["ok"] * 5
    assert [trial.peak_N for trial in trials] == pytest.approx([trials[0].peak_N] * 5, rel=1e-9)
    peaks_s = [trial.breakaway.peak_time_s for trial in trials]
    assert peaks_s == pytest.approx([peaks_s[0]] * 5, abs=1e-6)
    for trial, note in ((trials[3], "of 5 header blocks"), (trials[4], "time stamps (day, month, year)")):
        assert any(note in one for one in trial.breakaway.notes)
