"""Files as force gauges and their programs write them are read by what `inspect` proposes."""

import numpy as np
import pytest

from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file

TIME_S = np.arange(0.0, 6.0, 0.01)
FORCE_N = np.interp(TIME_S, [0, 1, 3, 3.05, 5.8], [0, 0, 80, 62, 61]) + 0.1 * np.sin(40 * TIME_S)
LBF_N, KGF_N = 4.4482216152605, 9.80665


def clock(t):
    return f"14:02:{t:06.3f}"


FILES = {
    "unit-in-a-column.csv": ("Sample Number,Tracking Value,Units,Elapsed Time\n",
                             lambda i, t, f: f"{i},{f / LBF_N:.4f},lb,{clock(t)}", "lbf"),
    "unit-behind-each-number.txt": ("ready\n", lambda i, t, f: f"{clock(t)} -> Force: {f:.3f} N", ""),
    "peak-and-low-beside.csv": ("Date,Time,Elapsed (s),Reading (lb),Peak (lb),Low (lb)\n",
                                lambda i, t, f: f"03/07/2024,14:02:0{t:.0f},{t:.2f},{f / LBF_N:.4f},18.10,-0.10", "lbf"),
    "path-beside-a-rate.csv": ("Unit,N\nRecording Rate,100Hz\n\nNo,Force,Displacement\n",
                               lambda i, t, f: f"{i},{f:.3f},{0.3 * t:.3f}", "N"),
    "blanks-in-names.dat": ("%   t [s]      F [kN]\n", lambda i, t, f: f"{t:9.3e}  {f / 1000:12.5e}", ""),
    "axes.csv": ("x/ms;y/kN\n", lambda i, t, f: f"{1e3 * t:.0f};{f / 1000:.7f}", ""),
    "in-words.csv": ("Prüfzeit in s;Standardkraft in N\n", lambda i, t, f: f"{t:.2f};{f:.4f}", ""),
    "only-units.csv": ("Seconds;Newton\n", lambda i, t, f: f"{t:.2f};{f:.4f}", ""),
    "mass.csv": ("Time (s),Load (kg)\n", lambda i, t, f: f"{t:.2f},{f / KGF_N:.5f}", "kgf"),
    "other-ending.tra": ('"Time";"Standard force"\n"s";"N"\n', lambda i, t, f: f"{t:.2f};{f:.4f}".replace(".", ","), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_what_is_proposed_reads_the_force(tmp_path, name):
    head, line, unit = FILES[name]
    path = tmp_path / name
    rows = (line(i, t, f) for i, (t, f) in enumerate(zip(TIME_S, FORCE_N, strict=True)))
    path.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")
    found = inspect_file(path)
    assert not found.stopped
    assert f"{TIME_S.size} samples, 100 Hz, {FORCE_N.min():.2g}"[:18] in found.read
    assert found.profile.channels["force"].unit == unit
    low_N, high_N = (float(part) for part in found.read.split(", ")[-1].split(" N")[0].split(" to "))
    assert high_N == pytest.approx(FORCE_N.max(), rel=1e-3)
    assert low_N == pytest.approx(FORCE_N.min(), abs=2e-3)
    assert read_recordings(path, found.profile)


def test_a_column_of_flags_is_no_unit(tmp_path):
    """N may be the answer of a limit switch: only a column that is called a unit, or has no name, holds one."""
    path = tmp_path / "a.csv"
    path.write_text(
        "time_s,load,over\n" + "".join(f"{t:.2f},{f:.3f},N\n" for t, f in zip(TIME_S, FORCE_N, strict=True))
    )
    assert inspect_file(path).profile.channels["force"].unit == ""
