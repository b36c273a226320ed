"""How long scenes take: from the shell, the solving alone, a plan against everything, a grid of a million."""

import subprocess
import sys
from pathlib import Path
from time import perf_counter

import pytest

from ropefric.accuracy.studies.scenes import SWEEPS, swept_scene
from ropefric.files.folder import Folder
from ropefric.scenes.plan import make_plan
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import parse_axis, sweep_scene, sweep_table

SCENES = Path(__file__).parents[2] / "data" / "scenes"
GRID = ("wheel.wrap=90deg:1440deg:1000", "load.end_tension=10N:500N:1000")
MACHINES = (*("hoist", "climbing-hoist", "belt-press", "fast-belt-press", "band-saw", "fast-band-saw"),
            *("traction", "belt-drive", "band-brake", "cable-pull", "tendon"))  # fmt: skip


def command(*words):
    return subprocess.run(
        [sys.executable, "-m", "ropefric", *map(str, words)], check=True, capture_output=True, timeout=120
    )


def test_a_hoist_from_the_shell(benchmark):
    """The aim: below a second in all, most of it starting Python."""
    done = benchmark.pedantic(command, args=("solve", SCENES / "hoist.toml"), rounds=3)
    assert b"Lift force" in done.stdout


def test_a_million_hoists_from_the_shell(benchmark, tmp_path):
    """The aim: below three seconds in all, with table and figure."""
    words = ("solve", SCENES / "hoist.toml", "--sweep", GRID[0], "--sweep", GRID[1], "--out", tmp_path)
    benchmark.pedantic(command, args=words, rounds=3)
    with (tmp_path / "sweep.csv").open(encoding="utf-8") as stream:
        assert sum(1 for _ in stream) == 1_000_001


@pytest.fixture(scope="module")
def hoist():
    return load_scene(SCENES / "hoist.toml")


def test_a_million_hoists_without_their_table(benchmark, hoist):
    axes = tuple(parse_axis(hoist, text) for text in GRID)
    found = benchmark.pedantic(sweep_scene, args=(hoist, axes), rounds=3)
    assert found.failed == 0


def test_the_table_of_a_million_hoists(benchmark, hoist, tmp_path):
    axes = tuple(parse_axis(hoist, text) for text in GRID)
    blocks = []
    sweep_scene(hoist, axes, write=lambda *block: blocks.append(block))

    def write():
        with sweep_table(axes, Folder(tmp_path), "sweep.csv") as table:
            for block in blocks:
                table.add(*block)

    benchmark.pedantic(write, rounds=3)
    assert (tmp_path / "sweep.csv").stat().st_size > 20_000_000


def test_reading_planning_solving_and_the_uncertainty(benchmark):
    solution = benchmark(lambda: solve_scene(load_scene(SCENES / "hoist.toml")))
    assert solution.quantities[0].value[0] == pytest.approx(319.4, abs=0.1)


@pytest.mark.parametrize("accuracy", [0.2, 1e-3])
@pytest.mark.parametrize("name", MACHINES)
def test_planning_and_solving_over_solving_everything(benchmark, name, accuracy):
    """The aim: a ratio of at most 1.05, the two taken in turn, so that a busy machine slows both."""
    scene = load_scene(SCENES / f"{name}.toml")
    times = {"auto": [], "all": []}

    def both():
        for effects, spent in times.items():
            start = perf_counter()
            plan, model = make_plan(scene.kind.system, scene.problem, accuracy=accuracy, effects=effects)
            assert scene.kind.system.solve(model, plan.method) is not None
            spent.append(perf_counter() - start)

    benchmark.pedantic(both, rounds=100, warmup_rounds=3)
    benchmark.extra_info["ratio"] = min(times["auto"]) / min(times["all"])


@pytest.mark.parametrize("name", SWEEPS)
def test_a_planned_sweep_over_one_with_everything(benchmark, name):
    """The aim at 2 %: half the time where an effect that takes time can go."""
    times = {"auto": [], "all": []}

    def both():
        for effects, spent in times.items():
            start = perf_counter()
            sweep_scene(*swept_scene(name, 0.02, effects))
            spent.append(perf_counter() - start)

    benchmark.pedantic(both, rounds=5, warmup_rounds=1)
    benchmark.extra_info["ratio"] = min(times["auto"]) / min(times["all"])
