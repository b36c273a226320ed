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
    general = (
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n"
        f"X_Columns\t{columns}\nDate\t2026/03/05\nTime\t10:00:00\n***End_of_Header***\t\n\t\n"
    )
    parts = []
    for k in range(0, len(samples), 500):  # written every half second, each time with a header
        time = f"10:00:{k / 1000:09.6f}".replace(".", ",")
        head = f"Channels\t1\nDate\t2026/03/05\nTime\t{time}\nY_Unit_Label\tNewtons\nX_Dimension\tTime\n"
        head += "X0\t0,0\nDelta_X\t0,001\n***End_of_Header***\nX_Value\tForce\tComment\n"
        rows = "".join(f"\t{force.replace('.', ',')}\n" for _, force in samples[k : k + 500])
        parts.append(f"{head}{rows}\n")
    return general + "".join(parts)


def ni(samples):
    head = 'Timestamp,2026-03-05 10:00:00\nInterval,0.001\nChannel name,"Force"\nUnit,"N"\n'
    return head + "".join(f"{time:.4f},{force}\n" for time, force in samples)


def german(samples):
    def row(time, force):
        stamp = (START + dt.timedelta(seconds=time)).strftime("%d.%m.%Y %H:%M:%S,%f")
        return f"{stamp};{force.replace('.', ',')}\n"

    return f"Wann;Kraft\n;N\n{''.join(row(*sample) for sample in samples)}Ende der Messung\n"


def vernier(samples):
    columns = (("Time", "s", [f"{t:.4f}" for t, _ in samples]), ("Force", "N", [f for _, f in samples]))
    cells = "".join(
        f"<DataColumn><DataObjectName>{name}</DataObjectName><ColumnUnits>{unit}</ColumnUnits>"
        f"<ColumnCells>\n{chr(10).join(values)}\n</ColumnCells></DataColumn>"
        for name, unit, values in columns
    )
    return f"<Document><DataSet><DataSetName>Run 1</DataSetName>{cells}</DataSet></Document>"


@pytest.mark.parametrize(
    "case",
    [
        ("a.lvm", labview, "LabVIEW measurement of 5 header blocks"),
        pytest.param(("a.csv", ni, "NI export"), marks=pytest.mark.slow),
        ("b.csv", german, "text time stamps (day, month, year)"),
        pytest.param(("a.cmbl", vernier, "Vernier Logger Pro"), marks=pytest.mark.slow),
    ],
)
def test_texts_of_loggers(lab, samples, pull_csv, case):
    name, write, note = case
    (lab.folder / "plain.csv").write_text(pull_csv(PEAK_N, seed=5))
    (plain,) = lab.write([lab.row("plain.csv")]).extract().trials
    (lab.folder / name).write_text(write(samples), encoding="utf-8")
    settings = '[import.channels]\nforce = "Kraft"\ntime = "Wann"' if "Wann" in write(samples) else ""
    (trial,) = lab.write([lab.row(name)], settings).extract().trials
    assert trial.breakaway.status == "ok"
    assert trial.peak_N == pytest.approx(plain.peak_N, rel=1e-9)
    assert trial.breakaway.peak_time_s == pytest.approx(plain.breakaway.peak_time_s, abs=1e-6)
    assert any(note in one for one in trial.breakaway.notes)


def test_hdf5_and_sheets(lab, samples, pull_csv):
    h5py, openpyxl = pytest.importorskip("h5py"), pytest.importorskip("openpyxl")
    (lab.folder / "plain.csv").write_text(pull_csv(PEAK_N, seed=5))
    with h5py.File(lab.folder / "a.h5", "w") as file:
        file["force"] = np.array([float(force) for _, force in samples])
        file["force"].attrs.update({"unit": "N", "fs": 1000.0})
    book = openpyxl.Workbook()
    for row in [["time_s", "force_N"], *([time, float(force)] for time, force in samples)]:
        book.active.append(row)
    book.save(lab.folder / "a.xlsx")
    trials = lab.write([lab.row(name) for name in ("plain.csv", "a.h5", "a.xlsx")]).extract().trials
    peaks_N = [trial.peak_N for trial in trials]
    assert peaks_N == pytest.approx([peaks_N[0]] * 3, rel=1e-9)
