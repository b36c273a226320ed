"""Sweeps are planned once: what may go goes, and no number, no yes or no differs from everything."""

import csv
from dataclasses import replace

import numpy as np
import pyarrow.parquet
import pytest

import ropefric as rf
from ropefric.errors import InputError
from ropefric.files import plain_text
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes import points as solving
from ropefric.scenes import sweep as tables
from ropefric.scenes.sweep import parse_axis, sweep_scene
from ropefric.systems.effect import Model
from ropefric.systems.hoist.contact import solve_lift
from ropefric.systems.hoist.effects import SYSTEM, stiffness_bound

STIFF = {"linear_density": "62 g/m", "hanging_length": "5 m", "bending_stiffness": "1e-4 N*m^2"}
AXES = ("wheel.wrap=90deg:1440deg:100", "load.end_tension=10N:500N:60")


def compared(make, *axes, **changes):
    """The sweep as planned, after it was held against that with everything, point by point."""
    found = []
    for effects in ("auto", "all"):
        scene = make(effects=effects, **changes)
        found.append(sweep_scene(scene, tuple(parse_axis(scene, text) for text in axes)))
    planned, whole = found
    assert planned.failed == whole.failed
    assert planned.failures == whole.failures, "a yes or no differs"
    for name, wanted in whole.columns.items():
        values = planned.columns[name]
        assert (np.isnan(values) == np.isnan(wanted)).all(), name
        off = np.abs(values - wanted) / np.where(wanted == 0.0, 1.0, np.abs(wanted))
        rounding = 1e-11  # of a coefficient, ln(F_A/F_B) over the wrap
        limit = (
            planned.accuracy if name == "margin_N" else min(planned.accuracy, planned.error_bound + rounding)
        )
        assert np.nanmax(off) <= limit, name
    return planned


def test_a_stiffness_that_matters_nowhere_much_goes_where_its_own_bound_lets_it(hoist_of):
    planned = compared(hoist_of, *AXES, accuracy=0.02, rope=STIFF)
    assert 4_000 < planned.left_out["bending-stiffness"] < 6_000
    assert "bending-stiffness" in planned.simulated, "not at every point"


def test_whether_a_hoist_lifts_is_never_left_open(hoist_of):
    planned = compared(
        hoist_of, *AXES, accuracy=0.1, rope=STIFF, load={"end_tension": "80 N", "payload": "30 kg"}
    )
    assert planned.left_out
    assert planned.failures


def test_where_the_box_ends_at_lift_off_the_bounds_hold_for_what_still_has_an_answer(hoist_of):
    axes = ("wheel.speed=0.1m/s:40m/s:100", "load.end_tension=5N:100N:60")
    planned = compared(hoist_of, *axes, accuracy=0.1, rope=STIFF)
    assert planned.failed > 0
    assert 0 < planned.left_out["bending-stiffness"] < 6_000 - planned.failed


def test_a_small_sweep_is_solved_whole(hoist_of):
    scene = hoist_of(accuracy=0.5, rope=STIFF)
    assert not sweep_scene(scene, (parse_axis(scene, "wheel.wrap=90deg:1440deg:50"),)).left_out


def test_a_blade_is_a_string_where_its_tension_makes_it_one(loaded, scene_of):
    saw = loaded("band-saw").document.data | {"accuracy": 0.02}
    planned = compared(
        lambda effects: scene_of(**(saw | {"effects": effects})), "tension.preload=3000N:300000N:12:log"
    )
    assert 0 < planned.left_out["bending"] < 12


def test_random_sweeps_keep_the_promise(hoist_of):
    """Boxes of two numbers, each from a scene of its own, with every optional part and near their limits."""
    laws = {"wrap-power": {"a": (0.0, 0.4), "b": (-0.9, -0.05), "c": (0.02, 0.2)},
            "wrap-exponential": {"a": (0.0, 0.4), "b": (-1.0, -0.02), "c": (0.02, 0.2)},
            "size-exponential": {"mu_inf": (0.1, 0.4), "a": (-0.4, -0.05), "b": (-1.0, 0.0)},
            "constant-offset": {"a": (0.05, 0.4), "b": (0.0, 0.2)},
            "howell": {"a": (0.1, 0.5), "b": (0.7, 0.99)}}  # fmt: skip
    spared = 0
    for part in range(8):
        rng = np.random.default_rng([1, part])
        name = str(rng.choice(sorted(laws)))
        bounds = list(laws[name].values())
        names = ALL_LAWS[name].parameter_names
        parameters = {key: float(rng.uniform(*bound)) for key, bound in zip(names, bounds, strict=True)}
        tension, wrap = 10.0 ** rng.uniform(0.7, 2.7), rng.uniform(30.0, 1200.0)
        speed, stiff = rng.uniform(0.0, 12.0), 10.0 ** rng.uniform(-7.0, -2.5)
        axes = {"load.end_tension": f"{tension:g}N:{tension * rng.uniform(1.05, 20):g}N:60:log",
                "wheel.wrap": f"{wrap:g}deg:{wrap * rng.uniform(1.01, 3.0):g}deg:50",
                "wheel.radius": f"15mm:{rng.uniform(16, 300):g}mm:50",
                "wheel.speed": f"0.1m/s:{0.2 + speed:g}m/s:50",
                "rope.bending_stiffness": f"{stiff:g}N*m^2:{stiff * rng.uniform(1.1, 100):g}N*m^2:50:log"}  # fmt: skip
        chosen = rng.choice(list(axes), 2, replace=False)
        try:
            planned = compared(hoist_of, *(f"{key}={axes[key]}" for key in chosen),
                               accuracy=float(rng.choice([0.001, 0.01, 0.02, 0.1])),
                               friction={"law": name, "parameters": parameters},
                               wheel={"wrap": f"{wrap:g} deg", "speed": f"{speed:g} m/s"},
                               rope=STIFF | {"bending_stiffness": f"{stiff:g} N*m^2"},
                               load={"end_tension": f"{tension:g} N",
                                     "payload": f"{tension * rng.uniform(0.05, 1.0):g} kg"})  # fmt: skip
        except InputError as error:
            assert "no point of the sweep" in str(error) or "gives the coefficient" in str(error)  # noqa: PT017
            continue
        spared += bool(planned.left_out)
    assert spared > 3


@pytest.mark.parametrize(
    "others", [(), ("centrifugal",), ("wrap-dependence", "size", "end-tension", "rope-weight")]
)
def test_the_bound_of_a_stiffness_holds_case_by_case(hoist_of, others):
    problem = replace(hoist_of(rope=STIFF).problem, wrap_angle_rad=np.linspace(0.3, 25.0, 500),
                      bending_stiffness_N_m2=np.geomspace(1e-7, 3e-3, 500), speed_m_s=6.0)  # fmt: skip
    assert SYSTEM.effects["bending-stiffness"].bound is stiffness_bound
    with_it, without = (solve_lift(Model(problem=problem, effects=frozenset(others) | own))
                        for own in ({"bending-stiffness"}, frozenset()))  # fmt: skip
    bound = stiffness_bound(problem, without)
    assert (stiffness_bound(problem) <= bound).all()
    worth = np.abs(with_it.logs - without.logs).max(axis=0)
    assert (worth <= bound).all()
    assert np.median(bound / worth) < 4.0, "a bound that is ten times too large helps nobody"


# --- tables ---


@pytest.mark.parametrize("name", ["sweep.csv", "sweep.parquet"])
def test_the_table_has_the_points_as_asked_for_and_empty_cells_without_an_answer(
    hoist_of, tmp_path, monkeypatch, name
):
    scene = hoist_of(effects="all")
    axes = ("wheel.speed=60m/s:1m/s:9", "wheel.wrap=1turn:4turn:5")
    whole = rf.sweep(scene, *axes, table=tmp_path / "made" / name)
    assert whole.failed > 7
    if name == "sweep.csv":
        written = (tmp_path / "made" / name).read_text(encoding="utf-8")
        header, *rows = csv.reader(written.splitlines())
        cells = np.array([[float(cell or "nan") for cell in row] for row in rows])
        for module in (solving, tables):
            monkeypatch.setattr(module, "BLOCK", 7)
        rf.sweep(scene, *axes, table=tmp_path / name)
        assert (tmp_path / name).read_text(encoding="utf-8") == written
    else:
        found = pyarrow.parquet.read_table(tmp_path / "made" / name)
        header, cells = found.column_names, found.to_pandas().to_numpy()
        assert found["lift_force_N"].null_count == whole.failed
    wanted = ["wheel.speed [m/s]", "wheel.wrap [turn]", "lift_force_N", "mu_average", "extrapolated"]
    assert header == wanted
    assert cells[:, 0] == pytest.approx(np.repeat(whole.axes[0].values, 5))
    assert cells[:, 1] == pytest.approx(np.tile([1.0, 1.75, 2.5, 3.25, 4.0], 9))
    assert cells[:, 2] == pytest.approx(whole.columns["lift_force_N"], rel=1e-8, nan_ok=True)


def test_without_pyarrow_parquet_says_what_to_install(hoist_of, tmp_path, monkeypatch):
    def missing(name):
        raise ImportError

    monkeypatch.setattr(plain_text, "import_module", missing)
    with pytest.raises(InputError, match=r"ropefric\[parquet\]"):
        rf.sweep(hoist_of(), "wheel.wrap=1turn,2turn", table=tmp_path / "s.parquet")
    assert not list(tmp_path.iterdir())


def test_a_list_of_effects_says_how_far_it_is_from_everything(hoist_of, loaded):
    axes = ("wheel.wrap=90deg:1440deg:20", "load.end_tension=20N:500N:15")
    listed, whole = (sweep_scene(scene, tuple(parse_axis(scene, text) for text in axes))
                     for scene in (hoist_of(effects=effects, rope=STIFF)
                                   for effects in (["wrap-dependence", "size"], "all")))  # fmt: skip
    off = max(
        np.abs(values / whole.columns[name] - 1.0).max()
        for name, values in listed.columns.items()
        if name != "extrapolated"
    )
    assert off <= listed.error_bound < (1.0 + 1e-9) * off + 1e-9, "what is quick is solved to know it"
    assert listed.left_out["centrifugal"] == 300
    saw = loaded("band-saw")
    swept = sweep_scene(saw, (parse_axis(saw, "tension.preload=3000N,30000N"),))
    assert 0.05 < swept.error_bound < 0.2, "the bound of its stiffness at the smaller preload"
    lacking = hoist_of(effects=["bending-stiffness"])
    with pytest.raises(InputError, match=r"rope\.bending_stiffness"):
        sweep_scene(lacking, (parse_axis(lacking, "wheel.wrap=1turn,2turn"),))
