"""Channels with clocks of their own come onto one; a slow sensor that was written too often gives its own samples."""

import numpy as np
import pytest
from reading import read, refused

from ropefric.traces.readers.profile import Channel
from ropefric.traces.signals import held_readings

FORCE = {"force": Channel(column="F", unit="N"), "end_tension": Channel(column="S", unit="N")}


def slack_N(time_s):
    return 20.0 + 5.0 * time_s


def save(kind, path, *, late_s, slow):
    """Write a force of 1 kHz, and a slack side that began later and was read more slowly."""
    force_s = np.arange(3000) / 1000
    end_s = late_s + np.arange(2000 // slow) * slow / 1000
    if kind == "tdms":
        tdms = pytest.importorskip("nptdms")
        began = np.datetime64("2026-03-01T10:00:00.250000")
        late = np.timedelta64(round(1e6 * late_s), "us")
        first = {"wf_increment": 0.001, "wf_start_offset": 0.0, "wf_start_time": began}
        later = {"wf_increment": slow / 1000, "wf_start_offset": 0.0, "wf_start_time": began + late}
        with tdms.TdmsWriter(path) as writer:
            pair = (("F", 100 * force_s, first), ("S", slack_N(end_s), later))
            writer.write_segment([tdms.ChannelObject("g", *channel) for channel in pair])
        return
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values, step_s, start in (
            ("F", 100 * force_s, 0.001, 1000.0 if kind == "h5" else "2026-03-01T10:00:00"),
            (
                "S",
                slack_N(end_s),
                slow / 1000,
                1000.0 + late_s if kind == "h5" else f"2026-03-01T10:00:00.{round(1e3 * late_s):03}",
            ),
        ):
            file[name] = values
            file[name].attrs.update({"dt": step_s, "start_time": start})


@pytest.mark.parametrize("slow", [1, 10])
@pytest.mark.parametrize("kind", ["tdms", "h5", "h5-dates"])
def test_channels_that_began_at_other_times_are_aligned_by_time(tmp_path, kind, slow):
    path = tmp_path / f"run.{kind.partition('-')[0]}"
    save(kind, path, late_s=0.7004, slow=slow)
    (trace,) = read(path, channels=FORCE)
    there = np.isfinite(trace.end_tension_N)
    assert trace.force_N.size == 3000
    assert np.count_nonzero(there) == pytest.approx(2000 / slow, abs=2)  # none counts twice
    np.testing.assert_allclose(
        trace.end_tension_N[there], slack_N(trace.time_s[there]), atol=5.0 * 0.0005 + 1e-9
    )


def test_two_time_columns_of_unequal_length_are_two_clocks(write):
    rows = [f"{i / 100},{i}," + (f"{i / 10 + 0.05},{20 + i}" if i < 10 else ",") for i in range(100)]
    path = write("t_s,F,t2_s,S\n" + "\n".join(rows) + "\n")
    channels = {"time": Channel(column="t_s"), "force": Channel(column="F", unit="N")}
    channels["end_tension"] = Channel(column="S", unit="N", time="t2_s")
    (trace,) = read(path, channels=channels)
    assert trace.time_s.tolist() == pytest.approx((np.arange(100) / 100).tolist())
    assert trace.end_tension_N[[5, 15, 95]].tolist() == [20, 21, 29]
    assert np.count_nonzero(np.isfinite(trace.end_tension_N)) == 10
    (trace,) = read(path, channels=channels, derived={"force": "force - 2 * end_tension"})
    assert trace.force_N[10] == pytest.approx(10 - 2 * 20.5)  # between its readings a signal is a line


def test_the_unit_of_a_second_time_must_be_one(write):
    channels = {"time": Channel(column="t_s"), "force": Channel(column="F", unit="N")}
    of_none, of_force = (
        channels | {"end_tension": Channel(column="S", unit="N", time=u)} for u in ("u", "u_kN")
    )
    (trace,) = read(write("t_s,F,u,S\n0,1,0,1\n1,2,1,2\n"), channels=of_none)
    assert trace.end_tension_N.tolist() == [1, 2]
    assert refused(write("t_s,F,u_kN,S\n0,1,0,1\n1,2,1,2\n"), channels=of_force).code == "RF106"


@pytest.mark.parametrize("hold", [2, 3.125, 7, 100])
@pytest.mark.parametrize("seed", range(3))
def test_a_hold_is_reduced_to_the_readings_whatever_its_length(hold, seed):
    rng = np.random.default_rng(seed)
    readings = np.round(
        np.interp(np.arange(200), [0, 50, 150, 151, 200], [0, 0, 120, 90, 90]) + rng.normal(0, 0.2, 200), 2
    )
    at = np.arange(int(200 * hold))
    held = readings[((at + rng.uniform(0, 1)) / hold).astype(int).clip(max=199)]
    kept, period = held_readings(held)
    assert period == pytest.approx(hold, rel=0.02)
    assert kept.size == pytest.approx(200, abs=2)
    assert set(readings[5:195]) <= set(held[kept])


@pytest.mark.parametrize("lsb_N", [0.01, 1.0, 5.0])
@pytest.mark.parametrize("noise_N", [0.0, 0.02, 0.5])
def test_what_is_only_coarse_or_smooth_is_no_hold(lsb_N, noise_N):
    time_s = np.arange(6000) / 1000
    force_N = np.interp(time_s, [0, 1, 4, 4.02, 6], [0, 0, 150, 110, 115])
    force_N += noise_N * np.random.default_rng(1).standard_normal(time_s.size)
    assert held_readings(np.round(force_N / lsb_N) * lsb_N)[0].size == 0


def test_a_held_file_is_read_as_the_slow_one(real_data):
    folder = real_data / "field_inputs" / "held-slow-sensor"
    slow, held = (read(folder / name)[0] for name in ("slow_3.csv", "held_3.csv"))
    assert any("each reading of the sensor is repeated 100 times" in note for note in held.notes)
    shared = np.intersect1d(np.round(slow.time_s, 3), np.round(held.time_s, 3))
    assert shared.size >= slow.time_s.size - 2
    at = np.isin(np.round(held.time_s, 3), shared)
    np.testing.assert_allclose(
        held.force_N[at], np.interp(held.time_s[at], slow.time_s, slow.force_N), atol=1e-9
    )
