"""A laboratory to write campaigns in, a good campaign to spoil, and a small one, extracted once."""

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ropefric.rig.campaign import prth_bench_plan, simulate_campaign
from ropefric.traces.breakaway import Status
from ropefric.trials import extract as extract_module
from ropefric.trials.campaign import check_campaign, load_campaign
from ropefric.trials.extract import extract_campaign

GOOD = Path(__file__).parent / "good"


class Lab:
    """A folder with a campaign in it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "campaign.toml"

    def write(self, rows, settings="", data="."):
        """Write campaign.toml and trials.csv; `rows` are dictionaries with the same keys."""
        columns = list(rows[0])
        lines = [",".join(columns), *(",".join(str(row[name]) for name in columns) for row in rows)]
        (self.folder / "trials.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
        text = f'schema = "ropefric.campaign/1"\nname = "lab"\ntrials = "trials.csv"\ndata = "{data}"\n'
        text += f'[rope]\ndiameter = "9.8 mm"\n{settings}\n'
        self.path.write_text(text, encoding="utf-8")
        return self

    def row(self, file, **cells):
        """Return a row of the trial list: the same condition unless `cells` say otherwise."""
        return {"file": file, "wheel_radius_mm": 40, "wrap_angle_deg": 180, "end_tension_N": 20} | cells

    def record(self, name, **columns):
        """Write a recording; times to a tenth of a millisecond, whole numbers as they are."""
        kinds = ["%d" if values.dtype.kind == "i" else "%.5f" for values in columns.values()]
        form = ",".join(["%.4f", *kinds[1:]])
        rows = zip(*map(np.ndarray.tolist, columns.values()), strict=True)
        lines = [",".join(columns), *(form % row for row in rows), ""]
        (self.folder / name).write_text("\n".join(lines), encoding="utf-8")

    def pulls(self, **peaks_N):
        """Write a campaign of clean break-away recordings, one a name."""
        for seed, (name, peak_N) in enumerate(peaks_N.items()):
            (self.folder / f"{name}.csv").write_text(pull_text(peak_N, seed=seed), encoding="utf-8")
        return self.write([self.row(f"{name}.csv") for name in peaks_N])

    def load(self, **options):
        return load_campaign(self.path, **options)

    def extract(self, *, missing_recordings="error", **options):
        return extract_campaign(self.load(missing_recordings=missing_recordings), **options)


def pull(peak_N=100.0, *, seed=0, rate_Hz=1000.0):
    """Idle, a straight ramp of a second up to the peak, a drop to eight tenths, sliding; 0.05 N of noise."""
    time_s = np.arange(int(2.5 * rate_Hz)) / rate_Hz
    force_N = np.interp(time_s, [0.0, 0.3, 1.3, 1.32, 2.5], np.array([0, 0, 1.0, 0.8, 0.8]) * peak_N)
    return time_s, force_N + 0.05 * np.random.default_rng(seed).standard_normal(time_s.size)


def pull_text(peak_N=100.0, *, seed=0, rate_Hz=1000.0):
    rows = zip(*(values.tolist() for values in pull(peak_N, seed=seed, rate_Hz=rate_Hz)), strict=True)
    return "time_s,force_N\n" + "".join(f"{t:.4f},{f:.4f}\n" for t, f in rows)


@pytest.fixture
def lab(tmp_path):
    return Lab(tmp_path)


def one_by_one(work, n, *, backwards=False, **_limits):
    """Do the work in this process, in its order or backwards."""
    yield from ((place, work(place)) for place in sorted(range(n), reverse=backwards))


@pytest.fixture(autouse=True, scope="module")
def in_process(request):
    """Have recordings read in this process: to fork another takes longer. Files about processes have `PROCESSES`."""
    with pytest.MonkeyPatch.context() as patch:
        if not hasattr(request.module, "PROCESSES"):
            patch.setattr(extract_module, "guarded", one_by_one)
        yield


@pytest.fixture(scope="session")
def pull_csv():
    """Return the text of a clean recording with a known peak."""
    return pull_text


@pytest.fixture(scope="session")
def allowed():
    """Assert what holds for every result: a number comes with ok, and what is not ok has a problem and a reason."""

    def allowed(trial):
        assert isinstance(trial.breakaway.status, Status)
        if trial.breakaway.status is Status.OK:
            assert math.isfinite(trial.peak_N)
            assert trial.peak_N > 0
        else:
            assert math.isnan(trial.peak_N)
            assert trial.breakaway.detail
            assert trial.problems
            assert not trial.kept

    return allowed


@pytest.fixture(scope="session")
def small_campaign(tmp_path_factory):
    """Sixteen simulated recordings of two conditions, among them some that are spoilt; do not write to it."""
    folder = tmp_path_factory.mktemp("small")
    plan = prth_bench_plan()
    faults = {"spike": 0.2, "dropout": 0.1, "no-peak": 0.1, "too-short": 0.1, "unreadable": 0.1}
    simulate_campaign(folder, replace(plan, conditions=plan.conditions[:2], repeats=8, faults=faults), seed=3)
    return folder


@pytest.fixture(scope="session")
def small_extraction(small_campaign):
    """What it gives: forces, one of them rejected, and statuses without a force."""
    return extract_campaign(load_campaign(small_campaign / "campaign.toml"))


class Bench:
    """A campaign in a folder, whose texts can be changed by replacing parts."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "campaign.toml"
        self.table = folder / "trials.csv"
        (folder / "recordings").mkdir()
        for name in "abc":
            self.record(f"{name}.csv")
        self.write((GOOD / "campaign.toml").read_bytes(), (GOOD / "trials.csv").read_bytes())

    def record(self, name):
        path = self.folder / "recordings" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("time_s,counts\n", encoding="utf-8")

    def write(self, toml=None, trials=None):
        for path, text in ((self.path, toml), (self.table, trials)):
            if text is not None:
                path.write_bytes(text if isinstance(text, bytes) else text.encode())

    def spoil(self, old, new, *, pattern=False):
        text = self.path.read_text(encoding="utf-8")
        changed = re.sub(old, new, text, flags=re.MULTILINE) if pattern else text.replace(old, new)
        assert changed != text, f"{old!r} is not in the campaign file"
        self.write(toml=changed)

    def spoil_table(self, old, new):
        text = self.table.read_text(encoding="utf-8")
        assert old in text
        self.write(trials=text.replace(old, new))

    def problems(self):
        return check_campaign(self.path)

    def places(self):
        return [(p.path.rsplit("/", 1)[1], p.code, p.key) for p in self.problems()]

    def errors(self):
        return [problem for problem in self.problems() if problem.severity == "error"]

    def only(self):
        errors = self.errors()
        assert len(errors) == 1, "\n".join(map(str, errors))
        return errors[0]

    def warnings(self):
        return [problem for problem in self.problems() if problem.severity == "warning"]


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)
