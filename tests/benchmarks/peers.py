"""How long ropefric takes beside what its users would write instead: the two of each pair in turn, in one run.

`python tests/regenerate_readme.py peers` writes the table into the docs. Both do the same task, which is checked; only
their times are compared, and nothing asserts on them.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from textwrap import indent
from time import perf_counter
from typing import NamedTuple

import numpy as np
import pandas as pd
from rivals import (
    BEAM,
    LAW,
    STD,
    TIMES_S,
    TRUTH,
    designs,
    hermite,
    lift_by_quadrature,
    lift_force_N,
    lmfit_fit,
    machine,
    smallest,
    smallest_hermite,
    spectral,
    tensions,
)
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks

import ropefric as rf
from ropefric.accuracy.studies.press_transient import INTEGRATORS, LinearStartUp
from ropefric.fitting.problem import FitProblem, batched_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import LAWS
from ropefric.rig.stories import draw_recording
from ropefric.systems.bandsaw.beam import solve_beam
from ropefric.systems.press.transient.drives import DRIVE_LAWS, press_inputs
from ropefric.systems.press.transient.motion import ElasticPress

ROUNDS = 9
REFITS, LOOPED = 2000, 40
RECORDINGS, OF_ROUND = 20_000, 400
"""Recordings of the large campaign, and samples of each."""
SHARE = 100
"""A quick run has this fraction of the recordings, samples and points."""


class Pair(NamedTuple):
    """A task, two ways of doing it with how often each is repeated in its time, and what only ropefric's way does."""

    task: str
    ours: Callable[[], object]
    peer: str
    theirs: Callable[[], object]
    more: str
    ours_count: float = 1.0
    theirs_count: float = 1.0


def timed(work):
    """Return the seconds of one call."""
    begin = perf_counter()
    work()
    return perf_counter() - begin


def row(pair, rounds=ROUNDS):
    """Return the line of the table: median times, and their ratio with its quartiles."""
    pair.ours(), pair.theirs()
    times = np.array([(timed(pair.ours), timed(pair.theirs)) for _ in range(rounds)])
    times /= [pair.ours_count, pair.theirs_count]
    low, middle, high = np.quantile(times[:, 0] / times[:, 1], [0.25, 0.5, 0.75])
    ours, theirs = (span(value) for value in np.median(times, axis=0))
    ratio = f"**{middle:.2g}** ({low:.2g} to {high:.2g})"
    return f"| {pair.task} | {ours} | {pair.peer} | {theirs} | {ratio} | {pair.more} |"


def span(seconds):
    """Return a time in words: "3.1 ms"."""
    unit, size = next(
        (one for one in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)) if seconds >= one[1]), ("ns", 1e-9)
    )
    return f"{float(f'{seconds / size:.2g}'):g}\N{NO-BREAK SPACE}{unit}"


def picking(folder):
    """A pull of 60 000 samples in a CSV file: read, and the break-away found."""
    one = next(found for seed in range(99)
               if (found := draw_recording(np.random.default_rng([5, seed]))).status == "ok")  # fmt: skip
    time_s = np.linspace(0.0, 20.0, 60_000)
    force_N = np.interp(time_s, one.time_s * 20.0 / one.time_s[-1], one.force_N)
    path = Path(folder) / "pull.csv"
    pd.DataFrame({"time_s": time_s, "force_N": force_N.round(3)}).to_csv(path, index=False)

    def mean_of_15():
        return pd.read_csv(path)["force_N"].rolling(15, center=True).mean().max()

    def peaks():
        force = pd.read_csv(path)["force_N"].rolling(15, center=True).mean().fillna(0.0).to_numpy()
        return find_peaks(force, prominence=0.1 * np.ptp(force))[0]

    def ours():
        return rf.find_breakaway(path, rest="pretension")

    task = "read a recording of 60 000 samples and find F_A"
    yield Pair(
        task,
        ours,
        "pandas, highest 15-point mean",
        mean_of_15,
        "decides which peak; probability, u, zero, faults of the file",
    )
    yield Pair(task, ours, "pandas, `find_peaks` of that mean", peaks, "the same")


def fitting():
    """The coupled law in 216 conditions, once and 2000 times; checked against lmfit's answer."""
    wheel, wrap, load = np.meshgrid(
        [0.02, 0.03, 0.04, 0.06, 0.08, 0.12],
        np.pi * np.array([0.5, 1, 2, 3, 4, 6]),
        [2.0, 5.0, 10.0, 20.0, 80.0, 200.0],
    )
    plan = Conditions(wheel_radius_m=wheel.ravel(), rope_radius_m=0.0049, wrap_angle_rad=wrap.ravel(),
                      end_tension_N=load.ravel())  # fmt: skip
    rng = np.random.default_rng(1)
    log_lift = LAW.log_lift(TRUTH, plan) + STD * rng.standard_normal(216)
    problem = FitProblem(law=LAW, conditions=plan, log_lift=log_lift, std=np.full(216, STD), group=np.arange(216),
                         start=np.array([0.3, -0.3, -0.5, -0.3, 0.08]), lower=LAW.lower, upper=LAW.upper,
                         vary=np.ones(5, bool))  # fmt: skip
    frame = pd.DataFrame(
        {name: getattr(plan, name) for name in ("wheel_radius_m", "wrap_angle_rad", "end_tension_N")}
    )
    frame = frame.assign(rope_radius_m=0.0049, peak_N=np.exp(log_lift))
    exact = batched_fit(problem).theta[0]
    assert np.allclose(exact, lmfit_fit(problem, log_lift, problem.start), rtol=1e-4)
    every = LAW.log_lift(exact, plan) + STD * rng.standard_normal((REFITS, 216))

    def looped():
        return [lmfit_fit(problem, one, exact) for one in every[:LOOPED]]

    def by_lmfit():
        return lmfit_fit(problem, log_lift, problem.start)

    task = "fit the coupled law to 216 conditions"
    yield Pair(
        task + ", least squares alone", lambda: batched_fit(problem, tolerance=1e-3), "lmfit", by_lmfit, "–"
    )
    yield from fitted_elsewhere(task, problem, log_lift, exact)
    yield Pair(task + ", as `rf.fit` does", lambda: rf.fit(frame, "coupled"), "lmfit", by_lmfit,
               "several starts, components of scatter, small-sample errors, intervals, doubts")  # fmt: skip
    yield Pair(f"fit it {REFITS} times", lambda: batched_fit(problem, every, exact), f"lmfit, {LOOPED} times", looped,
               "–", REFITS, LOOPED)  # fmt: skip


def fitted_elsewhere(task, problem, log_lift, exact):
    """The same least squares by iminuit and kafe2, where they are installed."""

    def predicted(*theta):
        return problem.law.log_lift(np.array(theta), problem.conditions)

    def by_iminuit():
        import iminuit

        names, limits = problem.law.parameter_names, list(zip(problem.lower, problem.upper, strict=True))
        cost = lambda *theta: float((((predicted(*theta) - log_lift) / STD) ** 2).sum())  # noqa: E731
        minimum = iminuit.Minuit(cost, *problem.start, name=names)
        minimum.errordef, minimum.limits = iminuit.Minuit.LEAST_SQUARES, limits
        return np.array(minimum.migrad().values)

    def by_kafe2():
        import kafe2

        def model(mu_inf=0.3, a=-0.3, b=-0.5, c=-0.3, d=0.08):
            return predicted(mu_inf, a, b, c, d)

        fit = kafe2.IndexedFit(log_lift, model)
        fit.add_error(STD)
        for name, low, high in zip(("mu_inf", "a", "b", "c", "d"), problem.lower, problem.upper, strict=True):
            fit.limit_parameter(name, *(None if np.isinf(end) else float(end) for end in (low, high)))
        fit.do_fit()
        return fit.parameter_values

    for name, theirs in (("iminuit", by_iminuit), ("kafe2", by_kafe2)):
        if find_spec(name):
            assert np.allclose(predicted(*theirs()), predicted(*exact), atol=1e-4)
            yield Pair(
                task + ", least squares alone",
                lambda: batched_fit(problem, tolerance=1e-3),
                name,
                theirs,
                "–",
            )


def forces():
    """Lift forces of a million designs, of the constant law and of the coupled one."""
    many, few, constant = designs(1_000_000), designs(200), LAWS["constant"]
    mu = np.array([0.2])

    def written_out():
        return many.end_tension_N * np.exp(0.2 * many.wrap_angle_rad)

    assert np.allclose(lift_force_N(constant, mu, many), written_out(), rtol=1e-12)
    assert np.allclose(lift_force_N(LAW, TRUTH, few), lift_by_quadrature(few), rtol=1e-8)
    yield Pair("a lift force, constant law", lambda: lift_force_N(constant, mu, many), "`F_B*np.exp(mu*phi)`",
               written_out, "checks of the settings", 1e6, 1e6)  # fmt: skip
    yield Pair("a lift force, coupled law", lambda: lift_force_N(LAW, TRUTH, many), "`scipy.integrate.quad`, `brentq`",
               lambda: lift_by_quadrature(few), "–", 1e6, 200)  # fmt: skip


def start_up():
    """Ten seconds of a press of thirteen rollers, tensions to 1e-6."""
    model = ElasticPress(machine(1e-3))
    inputs = press_inputs(model.overspeed, DRIVE_LAWS["ramp"](speed_m_s=0.9, duration_s=2.0), "with-speed")

    def problem():
        return LinearStartUp(model=model, inputs=inputs)

    one = problem()
    wanted_N = tensions(one, INTEGRATORS["exact"](one, TIMES_S))

    def radau(tolerance):
        return INTEGRATORS["radau"](problem(), TIMES_S, tolerance=tolerance)

    tolerance = next(value for value in 10.0 ** -np.arange(5.0, 11.0)
                     if np.abs(tensions(one, radau(value)) - wanted_N).max() <= 1e-6 * wanted_N.max())  # fmt: skip
    yield Pair("10 s of a press's start-up to 1e-6", lambda: INTEGRATORS["exact"](problem(), TIMES_S),
               f"`{solve_ivp.__name__}`, Radau", lambda: radau(tolerance), "–")  # fmt: skip


def blade():
    """Six modes of a moving blade to 1e-8."""
    exact = solve_beam(BEAM, accuracy=1e-13).frequencies
    order, elements = smallest(spectral, exact, range(9, 60)), smallest_hermite(exact)
    yield Pair("six modes of a moving blade to 1e-8", lambda: spectral(order),
               f"finite elements ({elements}) and `eig`", lambda: hermite(elements), "–")  # fmt: skip


CAMPAIGN = """schema = "ropefric.campaign/1"
name = "many"
trials = "trials.csv"
[rope]
diameter = "9.8 mm"
[wheels.W]
radius = "40 mm"
"""
LOOP = """
import pathlib
import pandas as pd
for path in sorted(pathlib.Path(sys.argv[1]).glob("r*.csv")):
    pd.read_csv(path)["force_N"].rolling(15, center=True).mean().max()
"""
EXTRACT = """
import ropefric as rf
from ropefric.executors import cluster
with cluster("local" if sys.argv[2] == "cluster" else "", 2) as executor:
    rf.extract(sys.argv[1] + "/campaign.toml", jobs=2 if sys.argv[2] == "2" else 1, executor=executor)
"""
READ = """
import pandas as pd
pd.read_csv(sys.argv[1])["force_N"].rolling(15, center=True).mean().max()
"""
ONE = """
import ropefric as rf
rf.find_breakaway(sys.argv[1], rest="pretension")
"""
SWEEP = """
import ropefric as rf
rf.sweep(sys.argv[1], "wheel.wrap=90deg:1440deg:1000", f"wheel.radius=20mm:80mm:{sys.argv[2]}")
"""
MEASURED = """
taken_s = time.perf_counter() - begin
status = open("/proc/self/status").read()
print(taken_s, int(status.split("VmHWM:")[1].split()[0]) / 1024.0)
"""


def measured(folder, body, *arguments):
    """Return the seconds and the largest memory of one process [MB], imports included, of code run by itself."""
    path = Path(folder) / "timed.py"
    lines = indent("begin = time.perf_counter()" + body + MEASURED, "    ")
    path.write_text(f'import sys, time\nif __name__ == "__main__":\n{lines}', encoding="utf-8")
    command = [sys.executable, str(path), *map(str, arguments)]
    said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout
    taken_s, most_MB = map(float, said.splitlines()[-1].split())
    return taken_s, most_MB


def large(share=1):
    """Yield the lines on what is large: many recordings, a long recording, a fine sweep; once each."""
    with tempfile.TemporaryDirectory() as folder:
        count = RECORDINGS // share
        campaign_of(Path(folder), count)
        ways = (
            ("pandas, highest 15-point mean", LOOP, ()),
            ("`rf.extract`", EXTRACT, ("1",)),
            ("`rf.extract`, two processes", EXTRACT, ("2",)),
            ("`rf.extract`, local cluster of two", EXTRACT, ("cluster",)),
        )
        for way, script, more in ways:
            yield f"{count} recordings of {OF_ROUND} samples", way, *measured(folder, script, folder, *more)
    with tempfile.TemporaryDirectory() as folder:
        path, n = Path(folder) / "long.csv", 25_000_000 // share
        time_s, force_N = (
            np.linspace(0.0, 20.0, n),
            np.interp(np.linspace(0.0, 20.0, n), [2, 12, 12.1, 20], [0, 80, 60, 60]),
        )
        force_N += 0.1 * np.random.default_rng(1).standard_normal(n)
        with path.open("w", encoding="utf-8") as file:
            file.write("time_s,force_N\n")
            for part in np.array_split(np.arange(n), max(1, n // 1_000_000)):
                np.savetxt(file, np.column_stack([time_s[part], force_N[part]]), "%.8f,%.6f")
        size = f"a recording of {n:.3g} samples, {path.stat().st_size / 1e6:.0f} MB"
        yield size, "pandas, highest 15-point mean", *measured(folder, READ, path)
        yield size, "`rf.find_breakaway`", *measured(folder, ONE, path)
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(__file__).parents[2] / "data" / "scenes" / "hoist.toml"
        yield (
            f"a sweep of {1_000_000 // share:.3g} points",
            "`rf.sweep`, hoist",
            *measured(folder, SWEEP, scene, 1000 // share),
        )


def campaign_of(folder, count):
    """Write a campaign of short recordings: one text under many names."""
    time_s = np.linspace(0.0, 4.0, OF_ROUND)
    noise = 0.1 * np.random.default_rng(3).standard_normal(OF_ROUND)
    force_N = np.interp(time_s, [1, 3, 3.05, 4], [0, 80, 60, 60]) + noise
    text = pd.DataFrame({"time_s": time_s, "force_N": force_N.round(3)}).to_csv(index=False)
    lines = ["trial,file,wheel,wrap_angle_deg,end_tension_N"]
    for number in range(count):
        (folder / f"r{number:05d}.csv").write_text(text, encoding="utf-8")
        lines.append(f"r{number:05d},r{number:05d}.csv,W,540,20")
    (folder / "trials.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")


def peers_block(machine_line, rounds=ROUNDS):
    """Return the table, and the machine it was measured on."""
    lines = ["| task | ropefric | instead | takes | ratio of the times (quartiles) | additional work of ropefric |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        for pairs in (picking(folder), fitting(), forces(), start_up(), blade()):
            lines += [row(pair, rounds) for pair in pairs]
    lines += ["", "| large input | method | time | memory |", "|---|---|---|---|"]
    lines += [f"| {what} | {way} | {span(taken_s)} | {most_MB:.0f}\N{NO-BREAK SPACE}MB |"
              for what, way, taken_s, most_MB in large(1 if rounds > 1 else SHARE)]  # fmt: skip
    return "\n".join([*lines, "", f"Measured on: {machine_line}.", ""])
