"""The recordings of a newcomer: 32 German files, two channels in mV with offsets, a clock across midnight, a footer."""

import datetime as dt
import math

import numpy as np

__all__ = ["PATTERN", "write_daq"]

PATTERN = "{wheel}_{wrap_angle_deg}Grad_{end_tension_N}N_{repeat}"
MU, RATE_HZ = 0.21, 200.0
GAINS_N_MV, OFFSETS_MV = (25.0, 40.0), (0.31, -0.12)
HEAD = "Prüfstand 2\nPrüfer: Müller\nAbtastrate: 200 Hz\n\nUhrzeit;Zugkraft [mV];Gegenkraft [mV]\n"
FOOTER = "Ende der Messung;;\nMaximum;{:.4f};{:.4f}\n"


def recording(radius_mm, wrap_deg, end_N, k):
    """Both sides hang free for 0.4 s; the slack weight is lowered onto the rope, then the winch pulls until it slips."""
    rng = np.random.default_rng(round(radius_mm * 1000 + wrap_deg * 10 + end_N + k))
    time_s = np.arange(900) / RATE_HZ
    lift_N = end_N * math.exp(MU * math.radians(wrap_deg)) * (1 + 0.004 * rng.standard_normal())
    end = np.interp(time_s, [0.4, 0.6, 9], [0, end_N, end_N])
    pull = np.interp(
        time_s, [0.4, 0.6, 1.0, 3.0, 3.02, 9], [0, end_N, end_N, lift_N, 0.85 * lift_N, 0.85 * lift_N]
    )
    signals = [
        values / gain + offset + 0.002 * rng.standard_normal(time_s.size)
        for values, gain, offset in zip((pull, end), GAINS_N_MV, OFFSETS_MV, strict=True)
    ]
    return time_s, *signals, lift_N


def write_daq(folder):
    """Write 32 files; two begin just before midnight."""
    folder.mkdir()
    truth = {}
    for n, (radius_mm, wrap_deg, end_N, k) in enumerate(
        (r, w, e, k) for r in (30, 50) for w in (180, 360) for e in (20, 40) for k in range(1, 5)
    ):
        time_s, pull_mV, end_mV, lift_N = recording(radius_mm, wrap_deg, end_N, k)
        began = dt.datetime(2026, 3, 2, 23, 59, 58) if n in (3, 20) else dt.datetime(2026, 3, 2, 10, n)  # noqa: DTZ001
        rows = [
            f"{(began + dt.timedelta(seconds=t)).strftime('%H:%M:%S.%f')[:-3]};{a:.4f};{b:.4f}"
            for t, a, b in zip(time_s.tolist(), pull_mV, end_mV, strict=True)
        ]
        text = HEAD + "\n".join(rows) + "\n" + FOOTER.format(pull_mV.max(), end_mV.max())
        name = f"R{radius_mm}_{wrap_deg}Grad_{end_N}N_{k}"
        (folder / f"{name}.txt").write_bytes(text.replace(".", ",").encode("cp1252"))
        truth[name] = lift_N
    return truth
