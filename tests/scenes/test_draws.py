"""Draws of what a scene is not sure of: their spread is that of the law of propagation where all is linear, and each
answer is that of the scene with the numbers drawn."""

import csv
import math
import pickle
from concurrent.futures import Future
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtr

import ropefric as rf
from ropefric.errors import DataError, InputError, RopefricError
from ropefric.files.toml import TomlDocument
from ropefric.fitting.predict import degrees_of_freedom
from ropefric.fitting.result import CommonError, FitStatus
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.scenes.draws import _Draws, draw_scene
from ropefric.scenes.points import _Run
from ropefric.scenes.scene import read_scene, replaced
from ropefric.scenes.solve import solve_scene
from ropefric.systems.beltdrive.drive import solve_drive
from ropefric.systems.friction import ScaleTo, WrapFriction
from ropefric.uncertainty.budget import directions

N = 20_000
SMALL = {"wheel": {"wrap": "0.5 deg"}, "load": {"end_tension": "0.1 %"}}
FIT = {"fit": "../../fits/prth-coupled.json"}
STIFF = {"linear_density": "62 g/m", "hanging_length": "5 m", "bending_stiffness": "1e-4 N*m^2"}


def with_covariance(scene, share, dof=None, common=()):
    """The scene with a share of its fit's covariance, all of it or all but common errors with degrees of freedom."""
    fit = scene.source.fit
    statistics = fit.statistics if dof is None else replace(fit.statistics, interval_dof=dof)
    fit = replace(fit, covariance=share * fit.covariance, common_errors=common, statistics=statistics)
    return replace(scene, source=scene.source._replace(fit=fit))


# --- against the law of propagation, and against each draw by itself ---


def test_a_constant_coefficient_spreads_as_its_closed_form_says(hoist_of):
    """ln F_A = ln F_B + μφ: three flat quantities, each of standard deviation half-width/√3."""
    tolerances = {**SMALL, "friction": {"mu": 0.001}}
    found = draw_scene(hoist_of(friction={"mu": 0.2}, wheel={"speed": None}, tolerances=tolerances), N)
    wrap, mu = math.radians(540), 0.2
    variance = (mu * math.radians(0.5)) ** 2 + 0.001**2 + (wrap * 0.001) ** 2
    lift = found.numbers["lift_force_N"]
    value = 80.0 * math.exp(mu * wrap)
    assert lift.value == pytest.approx(value)
    std = value * math.sqrt(variance / 3.0)
    noise = std / math.sqrt(N)
    assert lift.mean == pytest.approx(value, abs=4.0 * noise + value * variance / 6.0)
    # A flat one scatters less than a normal one: std/√(2N).
    assert lift.std == pytest.approx(std, abs=4.0 * noise)
    coefficient = found.numbers["mu_average"]
    assert coefficient.std == pytest.approx(0.001 / math.sqrt(3.0), rel=0.02)
    assert coefficient.quantiles == pytest.approx((0.19905, 0.2, 0.20095), abs=4e-5)  # of a flat distribution


def test_the_parameters_of_a_fit_spread_as_to_first_order(hoist_of):
    scene = hoist_of(effects="all")
    scene = with_covariance(scene, 1e-2)
    found, first, dof = draw_scene(scene, N), solve_scene(scene), degrees_of_freedom(scene.source.fit)
    wider = math.sqrt(dof / (dof - 2.0))  # of Student's t
    for one in first.quantities:
        drawn = found.numbers[one.name]
        assert drawn.std == pytest.approx(wider * one.std[0], rel=4.0 / math.sqrt(2 * N))
        assert drawn.mean == pytest.approx(one.value[0], abs=4.0 * one.std[0] / math.sqrt(N))
        assert drawn.quantiles[::2] == pytest.approx(one.interval[0], abs=0.1 * one.std[0])


def test_few_degrees_of_freedom_spread_as_student_s_t(hoist_of):
    scene = hoist_of(effects="all")
    few, many = (with_covariance(scene, 1e-4, dof) for dof in (5.0, 1e9))
    found, normal = (draw_scene(one, N, level=0.9).numbers["lift_force_N"] for one in (few, many))
    assert found.std / normal.std == pytest.approx(math.sqrt(5.0 / 3.0), rel=0.05)
    width = found.quantiles[2] - found.quantiles[0]
    assert width / normal.std == pytest.approx(2.0 * 2.015, rel=0.04)  # t of 5 degrees of freedom at 95 %


def test_what_errors_have_in_common_is_known_for_sure_and_normal(hoist_of):
    scene = with_covariance(hoist_of(effects="all"), 1e-4)
    roots = directions(np.asarray(scene.source.fit.covariance)).T
    shared = tuple(
        CommonError(name=str(i), unit="", std=1.0, change=tuple(one)) for i, one in enumerate(roots)
    )
    drawn = draw_scene(with_covariance(scene, 1.0, dof=3.0, common=shared), N, level=0.9)
    found = drawn.numbers["lift_force_N"]
    std = solve_scene(scene).quantities[0].std[0]
    assert found.std == pytest.approx(std, rel=4.0 / math.sqrt(2 * N))
    assert (found.quantiles[2] - found.quantiles[0]) / std == pytest.approx(2.0 * 1.645, rel=0.04)


@pytest.mark.parametrize(
    ("name", "tolerances", "friction"),
    [("hoist", {"wheel.wrap": 0.1, "rope.diameter": 1e-4}, None),
     ("climbing-hoist", {"wheel.wrap": 0.1, "rope.diameter": 1e-4}, None),
     ("fast-belt-press", {"press.preload": 20.0}, None),
     ("belt-drive", {}, {**FIT, "scale_to": {"mu": 0.15, "wrap": "180 deg"}}),
     ("traction", {}, {**FIT, "scale_to": {"mu": 0.15, "wrap": "180 deg"}})],
)  # fmt: skip
def test_each_draw_is_the_scene_with_what_was_drawn(loaded, scene_of, name, tolerances, friction):
    """All draws are one call; friction that differs between them is that of each alone, wherever a rope slides."""
    tree = loaded(name).document.data | {"effects": "all"}
    tree |= {"friction": friction} if friction else {}
    names = []
    columns = draw_scene(replace(scene_of(**tree), tolerances=tolerances), 10).table
    for i in range(3):
        data, theta = tree, []
        for column, values in columns.items():
            key, _, unit = column.partition(" [")
            if key in tolerances:
                data = replaced(data, key, f"{float(values[i])!r} {unit.removesuffix(']')}")
            elif key.startswith("friction."):
                theta.append(values[i])
        alone = scene_of(**data)
        own = replace(alone.source.friction, theta=np.array(theta) if theta else alone.source.friction.theta)
        alone = replace(alone, problem=replace(alone.problem, friction=own), source=None)
        for one in solve_scene(alone).quantities:
            names.append(one.name)
            assert columns[one.name][i] == pytest.approx(one.value[0], rel=1e-9, nan_ok=True), (i, one.name)
    assert names


def test_every_law_takes_parameters_of_its_own_for_each_case():
    for name in ALL_LAWS:
        law, rng = ALL_LAWS[name], np.random.default_rng(3)
        start = np.array([one.start for one in law.parameters])
        theta = start * rng.uniform(0.95, 1.05, (4, start.size))
        at = {"wheel_radius_m": rng.uniform(0.03, 0.05, 4), "rope_radius_m": 0.005,
              "wrap_angle_rad": rng.uniform(3.0, 9.0, 4),
              "slack_tension_N": rng.uniform(40.0, 90.0, (2, 4))}  # fmt: skip
        whole = WrapFriction(
            law=law, theta=theta, reference=one_condition(0.04, 0.005, 6.0, 50.0), scale_to=ScaleTo(0.2, 3.0)
        )
        for told in (frozenset(), frozenset({"wrap", "end-tension", "size"})):
            found = whole.exponent(**at, regressors=told)
            turned = {
                key: one.T[..., None] if np.ndim(one) == 1 else np.transpose(one) for key, one in at.items()
            }
            places = whole.exponent(**turned, regressors=told, places=1)
            for i in range(4):
                alone = {key: one if np.ndim(one) == 0 else one[..., i : i + 1] for key, one in at.items()}
                wanted = replace(whole, theta=theta[i]).exponent(**alone, regressors=told)
                assert found[..., i : i + 1] == pytest.approx(wanted, rel=1e-12), name
                assert places[i] == pytest.approx(wanted.ravel(), rel=1e-12), name


# --- planned once ---


@pytest.mark.parametrize("payload", [None, "5 kg", "33 kg"])
def test_draws_are_planned_once_and_keep_the_promise(hoist_of, payload):
    """A stiffness that is worth little goes; no number differs by more than wanted, and no draw lifts or not."""
    changes = {"accuracy": 0.02, "rope": STIFF, "load": {"end_tension": "80 N", "payload": payload},
               "tolerances": {"wheel": {"wrap": "20 deg"}, "load": {"end_tension": "10 %"}}}  # fmt: skip
    planned, whole = (draw_scene(hoist_of(effects=effects, **changes), N) for effects in ("auto", "all"))
    assert planned.failures == whole.failures
    if payload == "33 kg":  # whether it lifts, and by how many newtons, hangs on everything
        assert 0.1 < planned.shares["the hoist does not lift its payload"] < 0.9
    else:
        assert planned.left_out["bending-stiffness"] > 0.9 * N
        assert 1e-3 < planned.error_bound <= 0.02
    for name, values in whole.table.items():
        limit = 0.02 if name == "margin_N" else planned.error_bound
        np.testing.assert_allclose(planned.table[name], values, rtol=limit)


def test_draws_of_enormous_forces_have_no_deviation_and_end_in_no_crash(hoist_of):
    enormous = {"friction": {"mu": 0.2}, "wheel": {"wrap": "380 turn", "speed": None}}
    found = draw_scene(hoist_of(**enormous, tolerances={"friction": {"mu": "5 %"}}), 2_000)
    numbers = found.to_dict()["quantities"]["lift_force_N"]
    assert numbers["std"] is None
    assert numbers["value"] > 1e200
    assert numbers["quantiles"][0] < numbers["quantiles"][2]


def test_the_share_that_resonates_is_counted_over_draws(loaded, scene_of):
    """A string's first mode goes with √F_0: from which preload on it leaves the margin has a closed form."""
    tree = {"system": "bandsaw", "effects": "all", "accuracy": 0.1,
            "blade": {"free_span": "1 m", "linear_density": "0.5 kg/m", "modes": 1},
            "wheel": {"radius": "0.35 m", "speed": "0 rpm"}, "tension": {"preload": "3000 N"},
            "excitation": {"wheel_harmonics": 0, "frequencies": ["36 Hz"], "margin": 0.05,
                           "preload_range": ["2000 N", "4000 N"]},
            "tolerances": {"tension": {"preload": "10 %"}}}  # fmt: skip
    first_N, last_N = (0.5 * (2.0 * 36.0 * share) ** 2 for share in (0.95, 1.05))
    share = (min(last_N, 3300.0) - max(first_N, 2700.0)) / 600.0
    assert 0.2 < share < 0.9
    words = "a mode is nearer to what shakes it than the margin wanted"
    found = draw_scene(scene_of(**tree), N)
    assert found.shares[words] == pytest.approx(share, abs=4.0 * math.sqrt(share * (1.0 - share) / N))
    assert any(words in line for line in found.warnings)
    assert found.stands
    assert solve_scene(scene_of(**tree)).failures == (), "a single answer tells the margin itself"
    tree["blade"]["bending_stiffness"], tree["excitation"]["frequencies"] = "0.5 N*m^2", ["38 Hz"]
    stiff = draw_scene(scene_of(**tree), 60)
    fine = draw_scene(scene_of(**tree | {"accuracy": 1e-9}), 60)
    assert 0 < stiff.failures[words] == fine.failures[words] < 60
    del tree["excitation"]["margin"], tree["excitation"]["preload_range"]
    assert draw_scene(scene_of(**tree), 100).shares == {}


# --- yes and no, no answer, what is refused ---


def test_the_share_that_lifts_is_that_of_the_margin_s_distribution(hoist_of):
    def little(**load):
        scene = hoist_of(effects="all", load={"end_tension": "80 N", **load})
        return with_covariance(scene, 1e-2)

    lift = solve_scene(little()).quantities[0]
    weight_N = float(lift.value[0] - 0.9 * lift.std[0])
    scene = little(payload=f"{weight_N / 9.80665!r} kg")
    found, share = draw_scene(scene, N), float(stdtr(degrees_of_freedom(scene.source.fit), -0.9))
    told = found.to_dict()["failures"]["the hoist does not lift its payload"]
    assert told["share"] == pytest.approx(share, abs=4.0 * math.sqrt(share * (1.0 - share) / N))
    assert found.stands, "that it may not lift is an answer"
    light = draw_scene(hoist_of(load={"end_tension": "80 N", "payload": "1 kg"}), 100)
    assert light.shares == {"the hoist does not lift its payload": 0.0}
    assert light.warnings == ()


def test_draws_without_an_answer_are_counted_and_left_out_of_all_numbers(hoist_of):
    scene = hoist_of(
        load={"end_tension": "1.05 N"}, wheel={"speed": None}, tolerances={"load": {"end_tension": "9 %"}}
    )
    found = draw_scene(scene, 2000)
    below = (1.0 - (1.05 - 0.0945)) / 0.189  # of F_0 = 1 N
    assert found.failed / 2000 == pytest.approx(below, abs=0.05)
    assert found.answered == 2000 - found.failed
    assert "below F_0" in found.warnings[0]
    assert math.isfinite(found.numbers["lift_force_N"].std)


def test_tolerances_that_are_none_are_refused(hoist_of):
    for tolerances, words in [({"wheel": {"warp": "5 deg"}}, "did you mean 'wheel.wrap'"),
                              ({"wheel": {"wrap": "5 mm"}}, "not a unit of angle"),
                              ({"wheel": {"wrap": 5.0}}, "written like its value"),
                              ({"wheel": {"wrap": "0 deg"}}, "more than 0"),
                              ({"wheel": {"wrap": "-5 deg"}}, "more than 0"),
                              ({"wheel": {"wrap": True}}, "written like its value"),
                              ({"friction": {"fit": "1 N"}}, "no number"),
                              ({"accuracy": 0.1}, "no number")]:  # fmt: skip
        with pytest.raises(DataError, match=words) as caught:
            hoist_of(tolerances=tolerances)
        assert caught.value.problem.key.startswith("tolerances."), tolerances


def test_a_tolerance_beyond_what_the_scene_can_take_is_refused(hoist_of):
    with pytest.raises(DataError, match="not more than 0"):
        draw_scene(hoist_of(tolerances={"wheel": {"wrap": "600 deg"}}), 100)


def test_nothing_uncertain_and_too_few_or_many_draws_are_refused(hoist_of):
    with pytest.raises(InputError, match="nothing in the scene is uncertain"):
        draw_scene(hoist_of(friction={"mu": 0.2}), 100)
    for count in (1, 10**9):
        with pytest.raises(InputError, match=f"{count} draws"):
            draw_scene(hoist_of(), count)
    unknown = with_covariance(hoist_of(), np.nan)
    with pytest.raises(InputError, match="covariance of the fit is not known"):
        draw_scene(unknown, 100)
    source = hoist_of().source
    hardly = source._replace(fit=replace(source.fit, status=FitStatus.UNIDENTIFIABLE))
    with pytest.raises(InputError, match="not draws of its forces"):
        draw_scene(replace(hoist_of(), source=hardly), 100)


# --- reproducible ---


class Elsewhere:
    """An executor whose work goes and comes as it would to another process."""

    def submit(self, *work):
        done = Future()
        function, *arguments = pickle.loads(pickle.dumps(work))  # noqa: S301  (our own)
        done.set_result(pickle.loads(pickle.dumps(function(*arguments))))  # noqa: S301  (our own)
        return done


@pytest.fixture
def blocks_of_100(monkeypatch):
    """Small blocks; a seed of their own keeps their draws apart from those of usual blocks."""
    for module in ("points", "draws", "sweep"):
        monkeypatch.setattr(f"ropefric.scenes.{module}.BLOCK", 100)
    return 77


def test_a_draw_depends_on_the_seed_and_its_place_alone(hoist_of, tmp_path, monkeypatch):
    scene = hoist_of(tolerances={"wheel": {"wrap": "5 deg"}})
    few, many, other = draw_scene(scene, 50), draw_scene(scene, 200), draw_scene(scene, 50, seed=1)
    lift = "lift_force_N"
    assert few.columns[lift].tolist() == many.columns[lift][:50].tolist()
    assert few.columns[lift].tolist() != other.columns[lift].tolist()
    assert draw_scene(scene, 50, executor=Elsewhere()).to_dict() == few.to_dict()


@pytest.mark.parametrize("name", ["draws.csv", "draws.parquet"])
def test_the_table_has_what_was_drawn_and_the_answer_to_it(hoist_of, tmp_path, blocks_of_100, name):
    off = {"wheel": {"wrap": "5 deg"}, "friction": {"mu": 0.01}}
    scene = hoist_of(friction={"mu": 0.2}, wheel={"speed": None}, tolerances=off)
    found = rf.monte_carlo(scene, draws=250, seed=blocks_of_100, table=tmp_path / name)
    if name == "draws.csv":
        header, *rows = csv.reader((tmp_path / name).read_text(encoding="utf-8").splitlines())
        cells = np.array(rows, dtype=float)
    else:
        import pyarrow.parquet

        table = pyarrow.parquet.read_table(tmp_path / name)
        header, cells = table.column_names, table.to_pandas().to_numpy()
    assert header == ["wheel.wrap [deg]", "friction.mu", "lift_force_N", "mu_average"]
    assert cells.shape == (250, 4)
    assert len(set(cells[:, 0])) == 250
    wanted = 80.0 * np.exp(np.radians(cells[:, 0]) * cells[:, 1])
    np.testing.assert_allclose(cells[:, 2], wanted, rtol=1e-7)
    assert found.numbers["lift_force_N"].mean == pytest.approx(cells[:, 2].mean(), rel=1e-9)
    assert found.numbers["lift_force_N"].std == pytest.approx(cells[:, 2].std(ddof=1), rel=1e-7)


@pytest.mark.slow
def test_start_ups_are_drawn_one_by_one(loaded):
    scene = loaded("press-start-up")
    tree = scene.document.data
    tree["start_up"] = tree["start_up"] | {"duration": "0.15 s", "simulate": "0.2 s", "points": 21}
    scene = read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), scene.folder)
    scene = replace(scene, tolerances={"friction.mu": 0.05, "press.preload": 50.0})
    found = draw_scene(scene, 10)
    assert found.answered == 10
    assert found.numbers["largest_utilisation"].std > 0.0
    slips = found.columns["start_up.slips"]
    assert found.numbers["start_up.slips"].mean == slips.mean()
    assert ((found.columns["start_up.slipping_s"] > 0.0) == (slips == 1.0)).all()
    assert found.numbers["start_up.peak_tension_N"].value > found.numbers["start_up.lowest_tension_N"].value


def test_draws_without_an_answer_are_set_apart_and_not_looked_for_one_by_one(loaded):
    scene = loaded("belt-drive")
    tree = scene.document.data | {"friction": {"fit": "../../fits/prth-wrap-power.json"}}
    tree |= {"effects": "all", "tolerances": {"tension.force": "5 %"}}
    scene = read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), scene.folder)
    solved, system = [], scene.kind.system

    def solve(model, method):
        solved.append(model.problem.n)
        return solve_drive(model)

    kind = replace(scene.kind, system=system._replace(solve=solve))
    found = draw_scene(replace(scene, kind=kind), 200, seed=1)
    assert found.failed > 20, "a law of the wrap counted from tension has no answer for a belt so light"
    assert len(solved) < found.failed
    columns, alone = found.columns, _Draws(scene, 200, 1)
    run = _Run(scene, alone)
    for place in range(0, 200, 40):
        (outcome,) = run.outcomes((place, place + 1))
        refused = isinstance(outcome[1], RopefricError)
        assert refused == np.isnan(columns["full_pull_N"][place])
        if not refused:
            (pull_N,) = [one.value[0] for one in outcome[1].quantities if one.name == "full_pull_N"]
            assert columns["full_pull_N"][place] == pytest.approx(pull_N, rel=1e-9)
