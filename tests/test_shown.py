"""Results show themselves: short in a terminal, a table in a notebook, a frame, a figure."""

import inspect
import re
import typing
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import ropefric as rf
from ropefric.shown import Shown, in_words

ROOT = Path(__file__).parents[1]
TRIALS, COUPLED = ROOT / "fits" / "prth-trials.csv", ROOT / "fits" / "prth-coupled.json"
HOIST = ROOT / "data" / "scenes" / "hoist.toml"
PUBLIC = [name for name in rf.__all__ if inspect.isfunction(getattr(rf, name))]
WHEEL = {"wheel_radius_m": 0.035, "wrap_angle_rad": 7.0, "end_tension_N": 60.0}
time_s = np.arange(2500) / 1000
force_N = np.interp(time_s, [0.3, 1.3, 1.32], [0, 100, 80]) + 0.1 * np.sin(1e4 * time_s)


@cache
def compared():
    return rf.compare(TRIALS, ["wrap-power"])


MADE = {
    "table": lambda: rf.trial_table(TRIALS),
    "fit": lambda: rf.load_fit(COUPLED),
    "comparison": compared,
    "diagnosis": lambda: rf.diagnose(TRIALS, compared()),
    "prediction": lambda: rf.predict(COUPLED, **WHEEL),
    "design": lambda: rf.design(COUPLED, lift_N=900.0, wheel_radius_m=[0.03, 0.04], end_tension_N=80.0),
    "budget": lambda: rf.budget(COUPLED, **WHEEL, draws=20_000),
    "campaign": lambda: rf.load_campaign(ROOT / "data" / "prth-bench" / "campaign.toml"),
    "series": lambda: rf.reject([7.18, 7.64, 8.00, 7.40, 9.14, 7.82]),
    "smoothed": lambda: rf.smooth({"time_s": time_s, "force_N": force_N}, 0.01),
    "solution": lambda: rf.solve(HOIST),
    "explanation": lambda: rf.explain(HOIST),
    "sweep": lambda: rf.sweep(HOIST, "wheel.wrap=1turn,2turn", "wheel.radius=20mm,40mm,50mm"),
    "draws": lambda: rf.monte_carlo(HOIST, draws=100),
    "plan": lambda: rf.plan_tests(
        COUPLED, wheels_m=["20 mm"], wraps_rad=["1 turn", "2 turn"], end_tensions_N=[20, 40], **WHEEL,
        n_conditions=2, repeats=3, largest_force_N="1 kN",
    ),
}  # fmt: skip


def test_trials_and_conditions_of_a_campaign_are_short():
    """In a terminal; a trial holds its outline of hundreds of numbers."""
    found = rf.extract(ROOT / "docs" / "samples" / "german" / "campaign.toml")
    for one in (found.trials[0], found.conditions[0]):
        assert 5 < len(repr(one).splitlines()) < 12
        assert len(one.to_frame()) == 1
    assert re.search(r"peak +24\d\.\d+ ± 0\.\d+ N\n", repr(found.trials[0]))
    assert found.trials[0].plot().get_title().startswith("W40_540Grad_60N_1")
    with pytest.raises(rf.RopefricError, match="the whole result of extract"):
        rf.compare(found.trials)


@pytest.mark.parametrize("name", MADE)
def test_a_result_shows_itself_in_every_form(name):
    result = MADE[name]()
    lines = repr(result).splitlines()
    assert str(result) == repr(result)
    assert lines[0] == type(result).__name__
    assert 2 < len(lines) <= 12
    assert max(map(len, lines)) < 120
    assert re.search(r"\d", "".join(lines[1:]))
    assert result._repr_html_().count("<tr>") >= 2
    frame = result.to_frame()
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) >= 1
    drawn = result.plot()
    assert isinstance(drawn, Axes)
    assert callable(drawn._repr_png_)
    page = Figure(layout="constrained")
    left, right = page.subplots(ncols=2)
    right.set_title("$x$")
    given = result.plot(left)
    several = {"explanation"}  # has two panels, which take the place of the axes
    assert (given is left) == (name not in several)
    assert given.figure.figure is page
    assert given.has_data()
    assert right.get_title() == "$x$"
    assert not right.has_data()
    for wrong in ({"ax": page}, {"colour": "red"}):
        with pytest.raises(rf.RopefricError, match=f"{next(iter(wrong))}.* Fix: .*ax"):
            result.plot(**wrong)


def test_a_campaign_is_drawn_as_its_design():
    campaign = rf.load_campaign(ROOT / "data" / "prth-bench" / "campaign.toml")
    few = tuple(one for one in campaign.trials if one.trial != "c04-r01")
    (drawn,) = campaign.model_copy(update={"trials": few}).plot().collections
    settings = {(one.wheel_radius_m, one.wrap_angle_rad, one.end_tension_N): 0 for one in few}
    assert len(drawn.get_offsets()) == len(settings) == 36
    assert sorted(drawn.get_array()) == sorted(force_N for _, _, force_N in settings)
    areas = np.sort(drawn.get_sizes())
    assert areas[0] / areas[1] == pytest.approx(11 / 12)
    assert len({tuple(point) for point in drawn.get_offsets().tolist()}) == 36  # none hides another


def test_a_scene_is_a_table_without_a_drawing():
    scene = rf.load_scene(HOIST)
    assert len(scene.to_frame()) == 1
    assert scene._repr_html_().count("<tr>") > 1
    assert repr(scene).startswith("Scene")
    with pytest.raises(rf.RopefricError, match=r"no figure of Scene.* Fix: use to_frame"):
        scene.plot()


def test_everything_the_interface_returns_does():
    plain = {"accuracy_table", "lmfit_model", "save_fit", "write_scenes"}
    for name in set(PUBLIC) - plain:
        returned = inspect.signature(getattr(rf, name)).return_annotation
        if typing.get_origin(returned) is tuple:
            returned = typing.get_args(returned)[0]
        assert issubclass(returned, Shown), name


def test_the_numbers_carry_unit_and_uncertainty():
    said = repr(rf.predict(COUPLED, **WHEEL))
    assert re.search(r"lift force +\d+\.\d\d ± 0\.\d\d N\n", said)
    fit = rf.load_fit(COUPLED)
    assert re.search(r"mu_inf +0\.4603 ± 0\.0023\n", repr(fit))
    frame = fit.to_frame().set_index("name")
    assert frame.loc["mu_inf", "value"] == fit["mu_inf"].value
    assert (frame.loc["mu_inf", "ci95_low"], frame.loc["mu_inf", "ci95_high"]) == fit["mu_inf"].ci95
    grid = rf.sweep(HOIST, "wheel.wrap=1turn,2turn", "wheel.radius=20mm,40mm,50mm")
    wide = grid.to_frame()
    assert wide["wheel.radius"].tolist() == [0.02, 0.04, 0.05] * 2
    assert wide["lift_force_N"].tolist() == grid.columns["lift_force_N"].tolist()


def test_numbers_in_words():
    for value, std, said in (
        (70.1234, 0.0512, "70.123 ± 0.051 N"), (70.1234, 0.0996, "70.12 ± 0.10 N"), (12345.6, 250.0, "12350 ± 250 N"),
        (1e-30, 1e-32, "1e-30 ± 1e-32 N"), (np.inf, 1.0, "inf N"), (np.nan, 1.0, ""), (5.0, np.nan, "5 N"),
        (5.0, 0.0, "5 N"), (True, None, "yes"), (np.array([[1.0, 2.0]]), None, "1 to 2 N"),
    ):  # fmt: skip
        assert in_words(value, "N", std) == said
