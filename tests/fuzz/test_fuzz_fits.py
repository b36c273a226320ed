"""Fits of nasty tables, and files of fits that somebody edited: sound, or refused."""

import copy
import json
import math
from functools import cache

import numpy as np
from fuzz_kit import HOSTILE, answered, fuzzed, scratch
from hypothesis import strategies as st

from ropefric.fitting.fit import fit_law
from ropefric.fitting.predict import predict
from ropefric.fitting.result import FitStatus
from ropefric.fitting.store import fit_text, load_fit, verify_fit
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS
from ropefric.trials.table import TrialTable

FOLDER = scratch()
EXTREME = (5e-324, 1e-310, 1e-300, 1e-160, 1e-16, 1e16, 1e160, 1e300)
PULLS = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[0.0, 3.0, 30.0],
    end_tension_N=[1.5, 20.0, 90.0])  # fmt: skip


def sound(fit):
    """Assert what holds for every fit, made or loaded."""
    json.dumps(fit.to_dict(), allow_nan=False)
    assert np.isfinite(fit.covariance).all()
    assert (np.diag(fit.covariance) >= 0.0).all()
    assert fit.statistics.chi2 >= 0.0
    assert fit.status is FitStatus.OK or fit.advice
    for item in fit.parameters:
        assert math.isfinite(item.value)
        assert item.lower <= item.value <= item.upper
        assert not item.std < 0.0
        if item.at_bound:
            assert fit.status is not FitStatus.OK
            continue
        if fit.statistics.interval_dof == 0.0 and math.isnan(item.ci95[0]):
            continue  # nothing tells the scatter
        assert item.ci95[0] <= item.value <= item.ci95[1]
        if fit.status is FitStatus.OK:
            assert math.isfinite(item.std)
    for i in range(len(PULLS)):
        found = answered(lambda i=i: predict(fit, PULLS.select([i])))
        if found is not None:
            assert found.lift_force_N[0] > 0.0
            low, high = found.interval_N[0]
            if found.dof == 0.0:  # nothing is left to estimate a scatter from
                assert math.isnan(found.std_N[0])
                assert math.isnan(low)
                assert not found.verdict.supported
                continue
            assert found.std_N[0] >= 0.0
            assert low * (1 - 1e-12) <= found.lift_force_N[0] <= high * (1 + 1e-12)


CHANGES = {"plain": {}, "one wrap": {"wrap_angle_rad": 3.0}, "one wheel": {"wheel_radius_m": 0.04},
    "one condition": {"wheel_radius_m": 0.04, "wrap_angle_rad": 3.0, "end_tension_N": 20.0},
    "reference load": {"end_tension_N": 1.0}, "below the reference": {"end_tension_N": 0.5},
    "no wrap": {"wrap_angle_rad": 0.0}, "tiny wraps": {"wrap_angle_rad": 1e-9},
    "many turns": {"wrap_angle_rad": 900.0}}  # fmt: skip


@np.errstate(all="ignore")
def trials(kind, n, scatter, seed, extreme):
    """Return a table of pulls."""
    rng = np.random.default_rng(seed)
    columns = {"wheel_radius_m": rng.choice([0.01, 0.02, 0.04, 0.08], n), "rope_radius_m": np.full(n, 0.005),
        "wrap_angle_rad": rng.choice([1.5, 3.0, 6.0, 9.0, 12.0], n),
        "end_tension_N": rng.choice([2.0, 5.0, 20.0, 80.0], n)}  # fmt: skip
    change = CHANGES[kind]
    for name, value in change.items():
        columns[name] = np.full(n, value)
    mu = 0.2 * (1 - np.exp(-0.3 * columns["wheel_radius_m"] / columns["rope_radius_m"]))
    columns["peak_N"] = columns["end_tension_N"] * np.exp(mu * columns["wrap_angle_rad"] + scatter *
        rng.normal(size=n))  # fmt: skip
    for place, value in extreme:
        columns[sorted(columns)[place % len(columns)]][place % n] = value
    return TrialTable(trial=tuple(f"t{i}" for i in range(n)), **columns)


def check_fit(law, **table):
    """Whatever the table, a fit is sound or refused."""
    fit = answered(lambda: fit_law(trials(**table), law, n_starts=2))
    if fit is not None:
        sound(fit)


@cache
def stored():
    """Return the trees of a few fits, good and doubtful."""
    cases = (("constant", "plain", 6), ("wrap-power", "plain", 24), ("coupled", "plain", 5),
        ("size-power", "one wheel", 12))  # fmt: skip
    tables = [(law, trials(kind=kind, n=n, scatter=0.01, seed=5, extreme=[])) for law, kind, n in cases]
    return [json.loads(fit_text(fit_law(table, law, n_starts=1))) for law, table in tables]


VALUES = (None, 0, -1, 1.5, 1e300, -1e300, 1e-310, -0.0, 10**400, 2**70, math.nan, math.inf, -math.inf, "",
    "x", "ok", "scaled", True, False, [], {}, [[]], [1, 2], ["a", "b"], {"a": None}, [None] * 3,
    *HOSTILE)  # fmt: skip


def _places(tree, at=()):
    if at:
        yield at
    if isinstance(tree, dict | list):
        for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree):
            yield from _places(value, (*at, key))


@cache
def places(which):
    return list(_places(stored()[which]))


def check_stored(which, edits, cut):
    """A file of a fit with values changed or removed is a sound fit or is refused."""
    tree = copy.deepcopy(stored()[which])
    for place, value in edits:
        at = place if isinstance(place, tuple) else places(which)[place % len(places(which))]
        try:
            inner = tree
            for key in at[:-1]:
                inner = inner[key]
            if value < 0:
                del inner[at[-1]]
            else:
                inner[at[-1]] = VALUES[value % len(VALUES)]
        except (KeyError, IndexError, TypeError):
            continue  # an edit before this one took the place away
    text = json.dumps(tree)
    if cut:
        place, length, junk = cut
        at = place % len(text)
        text = text[:at] + junk + text[at + length :]
    path = FOLDER / "fit.json"
    path.write_text(text, encoding="utf-8")
    fit = answered(lambda: load_fit(path))
    if fit is not None:
        sound(fit)
        fit_text(fit)
        assert verify_fit(path).message


def _edit(which, *at, value):
    return {"which": which, "edits": [(at, VALUES.index(value))], "cut": None}


test_fit, test_fit_long = fuzzed(
    check_fit, short=18, share=0.003,
    # An uncertainty or a wrap so large that its square is no float.
    examples=[{"law": "constant", "kind": "plain", "n": 12, "scatter": 0.5,
               "seed": 2, "extreme": [(5, 1e160)]}],
    law=st.sampled_from(sorted(ALL_LAWS)),
    kind=st.sampled_from(list(CHANGES)), n=st.sampled_from([1, 2, 3, 4, 6, 12, 24]),
    scatter=st.sampled_from([0.0, 1e-15, 1e-3, 0.02, 0.5]), seed=st.integers(0, 10**6),
    extreme=st.lists(st.tuples(st.integers(0, 99), st.sampled_from(EXTREME)), max_size=2),
)  # fmt: skip
test_stored, test_stored_long = fuzzed(check_stored, short=40, share=0.04,
    examples=[_edit(0, "law", value=[None] * 3), _edit(0, "parameters", "mu", "value", value=1e300),
    _edit(0, "parameters", "mu", "value", value=10**400),
    _edit(0, "parameters", "mu", "at_bound", value=True), _edit(0, "covariance", 0, 0, value=-1e300),
    _edit(0, "covariance", 0, 0, value=math.inf), _edit(0, "statistics", "chi2", value=math.nan),
    _edit(0, "statistics", "interval_dof", value=2**70),
    _edit(0, "statistics", "scatter_within", value=10**400),
    _edit(0, "statistics", "scatter_between", value=1e300), _edit(0, "provenance", "input", value=["a", "b"]),
    _edit(0, "identifiability", "ratio", value=10**400), _edit(1, "covariance", 1, 0, value=-1e300),
    _edit(1, "parameters", "a", "ci95", value=[1, 2]), _edit(2, "status", value="ok"),
    _edit(2, "advice", value=[])], which=st.integers(0, 3),
    edits=st.lists(st.tuples(st.integers(0, 999), st.integers(-6, len(VALUES) - 1)), max_size=4),
    cut=st.none() | st.tuples(st.integers(0, 5000), st.integers(0, 6),
    st.sampled_from(["", "}", "NaN", "1e999", "\\ud800", ",", '"', "-", "]"])))  # fmt: skip
