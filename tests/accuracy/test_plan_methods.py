"""The method a scene's plan picks for an accuracy is one that the studies show to be enough; no clock is read."""

import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import STUDIES, blade_modes, press_transient, scenes
from ropefric.accuracy.studies.blade_modes import chebyshev_frequencies
from ropefric.scenes.plan import make_plan
from ropefric.systems.bandsaw.beam import ScaledBeam, scaled_beams, solve_beam
from ropefric.systems.bandsaw.effects import SYSTEM as SAW
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.span import CLAMPED, string_frequencies_Hz
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.effects import SYSTEM as HOIST
from ropefric.systems.press.answer import PressProblem
from ropefric.systems.press.effects import SYSTEM as PRESS
from ropefric.systems.press.transient.drives import DRIVE_LAWS

ACCURACIES = [10.0**-n for n in range(2, 11)]
LAYOUTS = {1: "Galerkin, one element", 3: "Galerkin, thin end elements"}


def model_of(case, accuracy, effects="all"):
    return scenes.planned(case, accuracy, effects)[1]


def beam_errors(stiffness, accuracy):
    """The solution that a plan's method gives a blade of the study, and its error there."""
    method = SAW.method(model_of("saw", accuracy), accuracy)
    assert method.name == "spectral elements"
    beam = ScaledBeam.at_speed(stiffness, blade_modes.SPEED, CLAMPED)
    modes = solve_beam(beam, 3, accuracy=method.settings["accuracy"])
    return method, modes, np.abs(modes.frequencies / blade_modes.FREQUENCIES[stiffness] - 1.0).max()


def test_the_hoist_takes_the_closed_form():
    errors = [
        error_table("integral", one.name, method="closed form")[0].error for one in STUDIES["integral"].cases
    ]
    for accuracy in ACCURACIES:
        method = HOIST.method(model_of("hoist", accuracy), accuracy)
        assert method.name == "closed form"
        assert not method.settings, "there is nothing coarser to be had"
        assert max(errors) <= method.error <= accuracy


@pytest.mark.parametrize(
    ("case", "stiffness"), [*zip(("moderate", "blade", "tiny"), blade_modes.FREQUENCIES, strict=True)]
)
def test_a_stiff_blade_is_as_accurate_as_its_plan_says_and_no_order_that_fails_is_taken(
    errors, case, stiffness
):
    studied = {n: errors("blade-modes", case, layout) for n, layout in LAYOUTS.items()}
    orders = {}
    for accuracy in (*ACCURACIES, 1e-11, 1e-12):
        method, modes, error = beam_errors(stiffness, accuracy)
        assert error <= method.error <= max(accuracy, 1e-12)
        found, orders[accuracy] = studied[modes.n_elements], modes.orders.max()
        failing = [order for order, error in found.items() if error > accuracy]
        assert all(orders[accuracy] > order for order in failing)
        assert min(found) in failing or accuracy >= 1e-3, "the study is too easy to tell"
    # To a thousandth it is as cheap as it gets.
    beam = ScaledBeam.at_speed(stiffness, blade_modes.SPEED, CLAMPED)
    assert orders[1e-2] == orders[1e-3]
    # The plan asks for a quarter of what may be missed, because the estimate of the error is not a bound.
    assert orders[1e-3] - solve_beam(beam, 3, accuracy=1e-2).orders.max() <= 2


def test_a_string_is_taken_only_where_the_plan_left_the_stiffness_out():
    for accuracy in ACCURACIES:
        model = model_of("saw", accuracy, "auto")
        stiff = "bending" in scenes.planned("saw", accuracy)[0].simulated
        assert (SAW.method(model, accuracy).name == "closed form") == (not stiff), accuracy
    # In the study the string is off by what the stiffness is worth, far more than any accuracy here.
    (string,) = error_table("blade-modes", "blade", method="string")
    assert string.error > max(ACCURACIES)


def test_the_strings_closed_form_is_as_accurate_as_its_plan_says():
    model = model_of("saw", 0.1, "auto")
    method = SAW.method(model, 1e-10)
    assert method.name == "closed form"
    for span in model.spans.values():
        speed = float(span.travel_speed_m_s[0] / span.wave_speed_m_s[0])
        hertz = span.wave_speed_m_s[0] / (2.0 * np.pi * span.free_span_m[0])
        exact = hertz * blade_modes.string_frequencies(speed, 3)
        np.testing.assert_allclose(string_frequencies_Hz(span, 3)[0], exact, rtol=method.error)


def test_a_press_without_start_up_has_one_linear_solution():
    method = PRESS.method(model_of("press", 1e-6), 1e-6)
    assert method.name == "direct solution"
    assert not method.settings
    assert method.error <= min(ACCURACIES)


@pytest.fixture(scope="module", params=list(press_transient.BELTS))
def started(request):
    """The study's press as a scene with a start-up: its model with all effects, and the study's case."""
    speed = DRIVE_LAWS["s-curve"](speed_m_s=press_transient.SPEED_M_S, duration_s=press_transient.RUN_UP_S)
    task = {"speed": speed, "time_s": np.array(press_transient.TIMES_S), "slip": False, "loads": "with-speed"}
    problem = PressProblem(press=press_transient.machine(*press_transient.BELTS[request.param]),
                           closure="share", friction=WrapFriction.constant(0.9),
                           speed_m_s=np.array([press_transient.SPEED_M_S]), load_factor=np.array([1.0]),
                           start_up=task)  # fmt: skip
    return request.param, make_plan(PRESS, problem, accuracy=0.01, effects="all")[1]


def test_a_start_up_takes_the_matrix_exponential_and_has_the_tensions_of_the_study(started):
    case, model = started
    (row,) = error_table("press-transient", case, method="exact")
    for accuracy in ACCURACIES:
        method = PRESS.method(model, accuracy)
        assert "matrix exponential" in method.name
        assert not method.settings
        assert row.error <= min(method.error, accuracy)
    found = PRESS.solve(model, PRESS.method(model, 1e-10)).start_up.tension_N
    np.testing.assert_allclose(found, press_transient.TENSIONS_N[case], rtol=1e-10)


@pytest.mark.parametrize("case", list(scenes.PROBLEMS))
def test_planned_answers_keep_their_accuracy_and_their_bound(case):
    rows = error_table("scenes", case, method="plan and solve")
    assert len(rows) == len(scenes.ACCURACIES_WANTED)
    for row, wanted in zip(rows, scenes.ACCURACIES_WANTED, strict=True):
        plan, _ = scenes.planned(case, wanted)
        assert row.error <= min(wanted, plan.error_bound)
        assert row.evaluations == len(plan.simulated)
    effects = [row.evaluations for row in rows]
    assert effects == sorted(effects)
    if case.startswith("saw"):
        assert effects[0] < effects[-1], "nothing to leave out"
    (bare,) = error_table("scenes", case, method="no effects")
    assert bare.error > rows[-1].error


@pytest.mark.slow
@pytest.mark.parametrize("case", list(scenes.SWEEPS))
def test_planned_sweeps_keep_their_accuracy_and_simulate_less(case):
    rows = error_table("scenes", case, method="plan and solve")
    (whole,) = error_table("scenes", case, method="all effects")
    for row, wanted in zip(rows, scenes.ACCURACIES_WANTED, strict=True):
        assert row.error <= wanted
    # What a law does not look at is left out at any accuracy: it is worth nothing.
    assert rows[0].evaluations < rows[-1].evaluations <= whole.evaluations
    assert rows[-1].evaluations == whole.evaluations or rows[-1].error == 0.0


def test_the_saws_reference_is_that_of_chebyshev_series():
    """The study's reference is the tool's own; here is another method for it."""
    system = scenes.PROBLEMS["saw"][0]
    model = model_of("saw", 1.0)
    answer = system.solve(model, system.method(model, 1e-14))
    for side in Side:
        span = model.spans[side]
        (beam,) = scaled_beams(span, CLAMPED)
        hertz = span.wave_speed_m_s[0] / (2.0 * np.pi * span.free_span_m[0])
        other = hertz * chebyshev_frequencies(beam, 96, 3)
        np.testing.assert_allclose(answer.sides[side].frequencies_Hz[0], other, rtol=1e-12)
