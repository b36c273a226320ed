"""How time and memory grow: `python docs/scale/measure.py` measures this machine and writes scale.json.

`python docs/scale/measure.py page` puts what was measured into docs/scale.md, as a table and a figure. On Linux only.
Each point is work of its own in a process of its own: its processor time with that of its children, and the most memory
it held, both beyond what loading the program takes. A point that is there already is not measured again.
"""

import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SIZES = {
    "samples": (1_000, 10_000, 100_000, 1_000_000),
    "trials": (100, 1_000, 10_000, 100_000),
    "points": (100, 1_000, 10_000, 100_000, 1_000_000),
    "dear points": (100, 1_000, 10_000),
    "recordings": (100, 1_000, 10_000, 100_000),
}
_FIRST = 20
SCENES = HERE.parents[1] / "data" / "scenes"


def pull(seed: int, n: int) -> str:
    """Return a recording of a clean pull, as CSV."""
    time_s = np.arange(n) * (2.0 / n)
    force_N = (60.0 + 0.4 * (seed % 100)) * np.interp(time_s, [0.3, 1.3, 1.32], [0.0, 1.0, 0.8])
    force_N += np.random.default_rng(seed).normal(0.0, 0.05, n)
    rows = (f"{t:.7f},{f:.4f}" for t, f in zip(time_s, force_N, strict=True))
    return "\n".join(["time_s,force_N", *rows, ""])


def campaign(folder: Path, n: int) -> Path:
    """Return a campaign of `n` recordings of 400 samples, ten a condition: a hundred, and further names for them."""
    (folder / "traces").mkdir(parents=True)
    rows = []
    for i in range(n):
        path = folder / "traces" / f"{i:06}.csv"
        if i < 100:
            path.write_text(pull(i, 400), encoding="utf-8")
        else:
            os.link(folder / "traces" / f"{i % 100:06}.csv", path)
        rows.append(f"traces/{path.name},40,{90 + i // 10 % 40},{10 + i // 400 * 0.05:g}")
    header = "file,wheel_radius_mm,wrap_angle_deg,end_tension_N"
    (folder / "trials.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    text = (
        'schema = "ropefric.campaign/1"\nname = "many"\ntrials = "trials.csv"\n[rope]\ndiameter = "9.8 mm"\n'
    )
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder / "campaign.toml"


def table(folder: Path, n: int) -> Path:
    """Return a table of `n` trials, five a condition, of a law that is known."""
    group, rng = np.arange(n) // 5, np.random.default_rng(1)
    wrap_rad, end_N = np.pi * (0.5 + 0.05 * (group % 70)), 10.0 * 1.01 ** (group // 70 % 300)
    log_rise = (0.25 * wrap_rad**-0.4 + 0.1) * wrap_rad + 0.02 * rng.standard_normal(n)
    rows = zip(wrap_rad, end_N, end_N * np.exp(log_rise), strict=True)
    lines = (f"40,9.8,{wrap:.6f},{end:.6f},{peak:.6f}" for wrap, end, peak in rows)
    header = "wheel_radius_mm,rope_diameter_mm,wrap_angle_rad,end_tension_N,peak_N"
    (folder / "trials.csv").write_text("\n".join([header, *lines, ""]), encoding="utf-8")
    return folder / "trials.csv"


def work(kind: str, n: int, folder: Path) -> Callable[[], object]:
    """Return what is to be measured, everything it needs being there."""
    import ropefric as rf  # noqa: PLC0415

    if kind == "recordings":
        path = campaign(folder, n)
        return lambda: rf.extract(path, jobs=2)
    if kind == "samples":
        (folder / "pull.csv").write_text(pull(1, n), encoding="utf-8")
        return lambda: rf.find_breakaway(rf.read_trace(folder / "pull.csv"))
    if kind == "trials":
        path = table(folder, n)
        return lambda: rf.compare(path)
    scene, axis = (
        ("hoist", "wheel.wrap=90deg:1440deg")
        if kind == "points"
        else ("belt-press", "belts.upper.width=1m:2m")
    )
    return lambda: rf.sweep(SCENES / f"{scene}.toml", f"{axis}:{n}", table=folder / "sweep.csv")


def used_s() -> float:
    """Return the processor time of this process and of those it started."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def most_kB() -> int:
    """Return the most memory this process held since it was last told to forget."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.partition("VmHWM:")[2].split()[0])


def measure(kind: str, n: int) -> dict[str, float]:
    """Return the time and memory of one point, in this process."""
    with tempfile.TemporaryDirectory(dir=os.environ.get("SCALE_FOLDER")) as folder:
        small = Path(folder) / "small"
        small.mkdir()
        work(kind, _FIRST, small)()  # what is loaded or set up once
        large = Path(folder) / "large"
        large.mkdir()
        call = work(kind, n, large)
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        before_kB, before_s, start = most_kB(), used_s(), time.perf_counter()
        call()
        wall_s, cpu_s = time.perf_counter() - start, used_s() - before_s
        grown_MB = (most_kB() - before_kB) / 1024
    return {
        "size": n,
        "processor_s": round(cpu_s, 4),
        "wall_s": round(wall_s, 4),
        "memory_MB": round(grown_MB, 1),
    }


NAMES = {
    "recordings": "recordings of 400 samples, extracted",
    "samples": "samples of one recording, picked",
    "trials": "trials, all laws compared",
    "points": "points of a sweep, solved in one call (hoist)",
    "dear points": "points of a sweep, solved one by one (belt press)",
}


def text_of(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for size, unit in ((86_400, "d"), (3_600, "h"), (60, "min"), (1, "s")):
        if seconds >= 0.995 * size:
            return f"{float(f'{seconds / size:.2g}'):g} {unit}"
    return f"{float(f'{1e3 * seconds:.2g}'):g} ms"


def grown(points: list[dict], key: str, n: float) -> tuple[float, float]:
    """Return the power by which a number grows over the last measured decade, and what follows for `n`."""
    first, last = points[-2], points[-1]
    ratio = max(last[key], 1e-9) / max(first[key], 1e-9)
    power = float(np.log(ratio) / np.log(last["size"] / first["size"]))
    return power, last[key] * (n / last["size"]) ** max(power, 1.0)


def table_of(told: dict) -> str:
    """Return a row a kind of work: measured times, the power they grow by, memory, and a time computed from them."""
    head = "| what grows | measured: processor time | grows as | memory for the largest | computed for 10⁶ |"
    rows = [head, "|---|---|---|---|---|"]
    for kind, said in NAMES.items():
        points = told["points"][kind]
        times = ", ".join(
            f"10{str(len(str(p['size'])) - 1).translate(RAISED)}: {text_of(p['processor_s'])}" for p in points
        )
        power, later_s = grown(points, "processor_s", 1e6)
        last = points[-1]
        computed = text_of(later_s) if last["size"] < 1e6 else "measured"
        memory = f"{last['memory_MB']:.0f} MB" if last["memory_MB"] >= 1.0 else "–"
        rows.append(f"| {said} | {times} | n^{power:.2f} | {memory} | {computed} |")
    return "\n".join(rows)


RAISED = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def picture(told: dict) -> str:
    """Return the measured times over the sizes, both logarithmic, as SVG."""
    from ropefric.plotting import style  # noqa: PLC0415
    from ropefric.plotting.figure import (  # noqa: PLC0415
        FigureWithData,
        drawing,
        svg_text,
    )

    with drawing(7.2, 4.6) as (figure, axes):
        for place, (kind, said) in enumerate(NAMES.items()):
            points = told["points"][kind]
            look = style.line_look(place) | {"marker": style.MARKERS[place % len(style.MARKERS)]}
            axes.plot([p["size"] for p in points], [p["processor_s"] for p in points], label=said, **look)
        axes.set(xscale="log", yscale="log", xlabel="How many [-]", ylabel="Processor time [s]")
        style.legend_of_figure(figure, columns=2)
    drawn = FigureWithData(
        figure=figure, tables=(), alt="Processor time over size: all lines rise as n or slower"
    )
    namespace = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
    return svg_text(drawn, stem="scale").replace("<svg", namespace, 1) + "\n"


def page(text: str, told: dict) -> str:
    """Return the page with what was measured between its two marks."""
    before, _, rest = text.partition(FIRST)
    _, _, after = rest.partition(LAST)
    return f"{before}{FIRST}\n{table_of(told)}\n\nMeasured on {told['machine']}.\n{LAST}{after}"


FIRST, LAST = "<!-- measured -->", "<!-- end -->"


def main() -> None:
    """Measure every point that is not there yet."""
    path = HERE / "scale.json"
    told = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"points": {}}
    told["machine"] = (
        f"{os.cpu_count()} cores, {platform.system()} {platform.machine()}, Python {platform.python_version()}"
    )
    for kind, sizes in SIZES.items():
        for n in sizes:
            there = told["points"].setdefault(kind, [])
            if any(point["size"] == n for point in there):
                continue
            run = subprocess.run(  # noqa: S603  (itself)
                [sys.executable, __file__, kind, str(n)], check=True, capture_output=True, text=True
            )
            there.append(json.loads(run.stdout))
            path.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
            print(kind, there[-1], flush=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["page"]:
        there = json.loads((HERE / "scale.json").read_text(encoding="utf-8"))
        about = HERE.parent / "scale.md"
        about.write_text(page(about.read_text(encoding="utf-8"), there), encoding="utf-8")
        (HERE / "scale.svg").write_text(picture(there), encoding="utf-8")
    elif len(sys.argv) == 3:
        print(json.dumps(measure(sys.argv[1], int(sys.argv[2]))))
    else:
        main()
