"""What is of no kind that an argument takes is refused by the name of the argument, never by Python itself."""

import numpy as np
import pytest

import ropefric as rf
from ropefric.errors import InputError, RopefricError
from ropefric.fitting.compare import compare_laws
from ropefric.fitting.design import design
from ropefric.fitting.diagnose import diagnose
from ropefric.fitting.fit import fit_law
from ropefric.fitting.intervals import with_intervals
from ropefric.fitting.predict import predict
from ropefric.trials.table import TrialTable

TABLE = TrialTable(
    trial=tuple("abcdef"), wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[2, 3, 4, 6, 8, 9],
    end_tension_N=20, peak_N=[30.1, 36.6, 44.2, 66.1, 99.0, 121.7],
)  # fmt: skip


@pytest.fixture(scope="module")
def fit():
    return fit_law(TABLE, "constant")


@pytest.mark.parametrize("law", [None, 3, ["constant"], {"law": "constant"}, np.zeros(2)])
def test_a_law_that_is_neither_name_nor_law(law):
    for call in (
        lambda: fit_law(TABLE, law),
        lambda: rf.lmfit_model(law),
        lambda: compare_laws(TABLE, [law]),
    ):
        with pytest.raises(InputError) as caught:
            call()
        assert caught.value.where == "law"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("fixed", "mu"), ("fixed", [0.2]), ("fixed", {"mu": None}), ("fixed", {"mu": [0.2]}), ("start", {"mu": "0.2"}),
        ("bounds", {"mu": 0.2}), ("bounds", {"mu": "ab"}), ("bounds", {"mu": (0, 1, 2)}), ("bounds", {"mu": (0, None)}),
        ("n_starts", "4"), ("seed", 1.5), ("loss", 3), ("scale_covar", "no"),
    ],
)  # fmt: skip
def test_a_setting_of_the_wrong_kind(key, value):
    with pytest.raises(RopefricError) as caught:
        fit_law(TABLE, "constant", **{key: value})
    assert caught.value.where == key


def test_arguments_of_the_wrong_kind(fit):
    given = {"lift_N": 90.0, "rope_radius_m": 0.005, "wheel_radius_m": 0.04, "end_tension_N": 20.0}
    calls = {
        "level": lambda: predict(fit, TABLE.conditions(), level="0.95"),
        "n": lambda: predict(fit, TABLE.conditions(), n=2e4),
        "seed": lambda: with_intervals(fit, "bootstrap", seed="one"),
        "method": lambda: predict(fit, TABLE.conditions(), method=["linear"]),
        "intervals": lambda: with_intervals(fit, None),
        "solve_for": lambda: design(fit, solve_for=["wrap"], **given),
        "laws": lambda: compare_laws(TABLE, 5),
        "probability": lambda: design(fit, probability="sure", **given),
        "touching_turns": lambda: diagnose(TABLE, touching_turns="two"),
    }
    for key, call in calls.items():
        with pytest.raises(RopefricError) as caught:
            call()
        assert caught.value.where == key
