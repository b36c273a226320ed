"""The method a scene's plan picks for an accuracy is one that the studies show to be enough; no clock is read."""

import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import blade_modes, scenes
from ropefric.accuracy.studies.blade_modes import chebyshev_frequencies
from ropefric.systems.bandsaw.beam import ScaledBeam, scaled_beams, solve_beam
from ropefric.systems.bandsaw.effects import SYSTEM as SAW
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.span import CLAMPED

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


@pytest.mark.slow
def test_planned_sweeps_keep_their_accuracy_and_simulate_less():
    rows = error_table("scenes", scenes.SWEEP, method="plan and solve")
    (whole,) = error_table("scenes", scenes.SWEEP, method="all effects")
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
