"""The sample recordings beside this file: pulls of the simulated bench as three data acquisitions would store them.

`python docs/samples/make.py` writes them; the same bytes every time. The truth behind them is that of `data/prth-bench`.
"""

from pathlib import Path

import numpy as np

import ropefric as rf

HERE = Path(__file__).parent
BENCH = HERE.parents[1] / "data" / "prth-bench" / "campaign.toml"
EVERY = 15
"""Of the bench's 3000 samples a second so many make one: means of 5 ms."""
CONDITIONS = {"c04": "W40_540Grad_60N", "c27": "W40_720Grad_15N"}
"""Conditions of the bench without faults in their first pulls, and what the German files are called."""
PULLS = (1, 2, 3, 4)


def pull(trial):
    """Return time [s] and force [N] of a recording of the bench, at 200 samples a second."""
    trace = rf.read_trial(BENCH, trial)
    n = trace.force_N.size // EVERY
    force_N = np.nanmean(trace.force_N[: n * EVERY].reshape(n, EVERY), axis=1)
    return EVERY / 3000.0 * np.arange(n), force_N


def german(force_N, time_s):
    """Return a text as a German Windows program writes it: semicolons, decimal commas, umlauts, units in the header."""
    words = "Prüfstand;Seilreibung\nKraftaufnehmer;1 kN\nBemerkung;Seil neu, trocken, 21 °C\n\n"
    head = words + "Zeit [s];Kraft [kN];Temperatur [°C]\n"
    rows = "".join(
        f"{t:.3f};{f / 1e3:.5f};21,4\n".replace(".", ",") for t, f in zip(time_s, force_N, strict=True)
    )
    return (head + rows).replace("\n", "\r\n").encode("cp1252")


def labview(force_N, time_s):
    """Return a LabVIEW measurement file."""
    head = (
        "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\n"
        "Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\nDate\t2026/03/12\nTime\t10:15:00\n"
        "***End_of_Header***\t\n\t\nChannels\t1\t\n"
        f"Samples\t{force_N.size}\t\nDate\t2026/03/12\t\nTime\t10:15:00\t\nY_Unit_Label\tNewtons\t\nX_Dimension\tTime\t\n"
        f"X0\t0.0E+0\t\nDelta_X\t{EVERY / 3000.0:.6f}\t\n***End_of_Header***\t\t\nX_Value\tForce\tComment\n"
    )
    rows = "".join(f"{t:.6f}\t{f:.4f}\t\n" for t, f in zip(time_s, force_N, strict=True))
    return (head + rows).replace("\n", "\r\n").encode("ascii")


def counts(force_N):
    """Return the counts of a 12-bit converter from -10 to 10 V behind a cell of 500 N at 10 V, zero at 0.2 V."""
    volts = 0.2 + force_N / 500.0 * 9.8
    return ("counts\n" + "".join(f"{n:.0f}\n" for n in np.round((volts + 10.0) / 20.0 * 4095.0))).encode(
        "ascii"
    )


def files():
    """Return the bytes of every sample by its path."""
    found = {}
    for condition, name in CONDITIONS.items():
        for n in PULLS:
            time_s, force_N = pull(f"{condition}-r{n:02}")
            found[f"german/daq/{name}_{n}.csv"] = german(force_N, time_s)
            found[f"labview/{condition}_{n}.lvm"] = labview(force_N, time_s)
            found[f"counts/{condition}_{n}.txt"] = counts(force_N)
    return {HERE / name: content for name, content in found.items()}


if __name__ == "__main__":
    for path, content in files().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
