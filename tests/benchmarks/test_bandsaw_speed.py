"""Six modes of a moving blade to 1e-8, three ways at the smallest order that does; never asserted on the clock."""

import numpy as np
import pytest

from ropefric.accuracy.studies.blade_modes import chebyshev_frequencies
from ropefric.systems.bandsaw.beam import ScaledBeam, galerkin_modes, solve_beam, widths_for
from ropefric.systems.bandsaw.span import CLAMPED, Span, string_frequencies_Hz

ACCURACY = 1e-8
# The blade of the paper, wheels pressed apart with a constant force: e = 0.0099, V = 0.42.
BEAM = ScaledBeam.at_speed(1e-4, 0.42, CLAMPED)


def spectral(order):
    return galerkin_modes(BEAM, widths_for(BEAM, order), order, 6).frequencies


def chebyshev(order):
    return chebyshev_frequencies(BEAM, order, 6)


def hermite(n_elements):
    return galerkin_modes(BEAM, (1.0 / n_elements,) * n_elements, 3, 6).frequencies


def error(found, exact):
    return float(np.abs(found / exact - 1.0).max())


def smallest(solve, exact, orders):
    return next(order for order in orders if error(solve(order), exact) < ACCURACY)


def smallest_hermite(exact):
    """By the law h⁴ from a mesh that is quick to solve: a search would take minutes."""
    law = (error(hermite(100), exact) / ACCURACY) ** 0.25
    return int(np.ceil(100 * law * 1.05))


@pytest.fixture(scope="module")
def exact():
    return solve_beam(BEAM, accuracy=1e-13).frequencies


def run(benchmark, solve, order, exact, rounds):
    benchmark.extra_info["order"] = order
    found = benchmark.pedantic(solve, args=(order,), rounds=rounds, warmup_rounds=1 if rounds > 1 else 0)
    assert error(found, exact) < ACCURACY


def test_spectral_elements(benchmark, exact):
    run(benchmark, spectral, smallest(spectral, exact, range(9, 60)), exact, 20)


def test_chebyshev_series(benchmark, exact):
    run(benchmark, chebyshev, smallest(chebyshev, exact, range(20, 120, 2)), exact, 20)


def test_hermite_cubic_elements(benchmark, exact):
    """The same dense Hermitian eigenproblem on a uniform mesh."""
    run(benchmark, hermite, smallest_hermite(exact), exact, 1)


def test_six_modes_with_the_check(benchmark):
    assert benchmark(solve_beam, BEAM, accuracy=ACCURACY).errors.max() < ACCURACY


def test_a_million_strings(benchmark):
    span = Span(free_span_m=1.6, linear_density_kg_m=0.5967,
                preload_N=np.linspace(2000.0, 9000.0, 1_000_000), wheel_speed_m_s=35.0,
                travel_speed_m_s=35.0, mounting_factor=0.5)  # fmt: skip
    assert benchmark.pedantic(string_frequencies_Hz, args=(span, 1), rounds=3).shape == (1_000_000, 1)
