"""The blade as a beam that travels along itself: frequencies to a wanted accuracy, checked after the fact.

They come from its weak form, as a Hermitian eigenproblem that cannot but give real ones.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.polynomial import chebyshev
from scipy.special import ive, jv

from ropefric.arrays import BoolArray, FloatArray, IntArray
from ropefric.errors import SolverError
from ropefric.systems.bandsaw.span import CLAMPED, Ends, Span, refuse_overspeed, string_frequencies_Hz


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaledBeam:
    """w_ττ + 2V w_xτ − S w_xx + ε² w_xxxx = 0 on 0 ≤ x ≤ 1, with S = 1 − V².

    Near the critical speed, V = √(1 + β ε²), all frequencies go with the margin S + β ε², which therefore is a number
    of its own: computed from V it would have no digits left.
    """

    stiffness: float
    speed: float
    net: float
    margin: float
    ends: Ends

    @classmethod
    def at_speed(cls, stiffness: float, speed: float, ends: Ends) -> "ScaledBeam":
        """Return the beam at a speed ratio V."""
        net = (1.0 - speed) * (1.0 + speed)
        margin = net + ends.buckling * stiffness
        return cls(stiffness=stiffness, speed=speed, net=net, margin=margin, ends=ends)


MAX_ORDER = 400
"""Highest order that is tried: some 120 modes."""

# A layer element spans e^{-0.8 p}: less than the polynomials of order p on it resolve anyway.
_LAYER_REACH = 0.8
# The middle part is no shorter than the layers.
_WIDEST_LAYER = 1.0 / 3.0
# A layer thinner than the inverse of this takes nothing that a float could show, and its powers stay floats.
_STEEPEST_RATE = 1e60
# Eigenvalues err with the square of the best approximation; how much more was found by experiment.
_SAFETY = {True: 10.0, False: 40.0}


class Waves(NamedTuple):
    """Of what a mode is made: waves e^{ikx} inside, layers e^{−κx} at the ends."""

    longest: float
    shortest: float
    layer_rate: float


@lru_cache(maxsize=64)
def waves_of(beam: ScaledBeam, mode: int) -> Waves:
    """Return the waves of a mode, closely enough to choose an order by.

    The four wave numbers solve ε²k⁴ + S k² − 2Vωk − ω² = 0: they are m ± q and −m ± iκ. With q given by
    the half waves between the ends, what remains is one equation for m², which has one root in [0, q²].
    """
    waves = _waves_between(beam, mode * math.pi)
    if not beam.ends.turns:
        # A clamp turns the phase by arctan(q/κ) at each end: nothing for a string, a quarter wave for a bare beam.
        turn = 2.0 * math.atan2(0.5 * (waves.shortest + waves.longest), waves.layer_rate)
        waves = _waves_between(beam, mode * math.pi + turn)
    return waves


def _waves_between(beam: ScaledBeam, q: float) -> Waves:
    # S + ε²q², written with the margin where S is negative.
    lifted = beam.margin + beam.stiffness * (q**2 - beam.ends.buckling)

    def surplus(m_squared: float) -> float:
        rigid = lifted + beam.stiffness * (q**2 + 2.0 * m_squared)
        moving = beam.speed**2 * (q**2 - m_squared) * (lifted + 3.0 * beam.stiffness * m_squared)
        return moving - m_squared * rigid**2

    low, high = 0.0, q**2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if surplus(middle) > 0.0 else (low, middle)
    m = math.sqrt(high)
    rate_squared = lifted / beam.stiffness + 2.0 * m**2
    rate = min(math.sqrt(max(rate_squared, 0.0)), _STEEPEST_RATE)
    return Waves(longest=q - m, shortest=q + m, layer_rate=rate)


def widths_for(beam: ScaledBeam, order: int) -> tuple[float, ...]:
    """Return the lengths of the elements: one where the layers are thick, else three with a thin one at each end."""
    rate = waves_of(beam, 1).layer_rate
    if _LAYER_REACH * order >= _WIDEST_LAYER * rate:
        return (1.0,)
    thin = _LAYER_REACH * order / rate
    return (thin, 1.0 - 2.0 * thin, thin)


def order_for(beam: ScaledBeam, n_modes: int, accuracy: float) -> int:
    """Return the smallest order expected to give the first modes to a relative accuracy.

    A polynomial of degree p leaves J_p(kh/2) of a wave e^{ikx} on an element of length h, and I_p(κh/2) e^{−κh/2}
    of a layer; the eigenvalue errs with the square.
    """
    waves, safety = waves_of(beam, n_modes), _SAFETY[beam.ends.turns]
    for order in range(n_modes + 3, MAX_ORDER + 1):
        widths = widths_for(beam, order)
        wave, layer = 0.5 * waves.shortest * max(widths), 0.5 * waves.layer_rate * min(widths)
        # Below its turning point a Bessel function oscillates and tells nothing.
        if order > wave and safety * (jv(order, wave) ** 2 + ive(order, layer) ** 2) <= accuracy:
            return order
    words = f"{n_modes} modes need an order above {MAX_ORDER}"
    raise SolverError(words, key="n_modes", fix="use fewer modes")


class Matrices(NamedTuple):
    """Matrices of a moving beam of length 1 in a basis φ_1 … φ_k; each (k, k)."""

    mass: FloatArray
    travel: FloatArray
    tension: FloatArray
    bending: FloatArray


@lru_cache(maxsize=64)
def assemble(widths: tuple[float, ...], order: int, turning_ends: bool) -> Matrices:  # noqa: FBT001  (for the cache)
    """Return the matrices of a span divided into elements, both ends held in place."""
    value, slope, curvature = _reference(order)
    weights = 2.0 / (2.0 * np.arange(order + 1) + 1.0)
    n_bubbles, n_nodes = order - 3, len(widths) + 1
    whole = np.zeros((4, *[2 * n_nodes + n_bubbles * len(widths)] * 2))
    blocks = np.array(
        [
            (value * weights) @ value.T,
            (value * weights) @ slope.T - (slope * weights) @ value.T,
            (slope * weights) @ slope.T,
            (curvature * weights) @ curvature.T,
        ]
    )
    for element, width in enumerate(widths):
        first = 2 * n_nodes + n_bubbles * element
        place = np.r_[2 * element : 2 * element + 4, first : first + n_bubbles]
        scale = np.ones(order + 1)
        scale[[1, 3]] = 0.5 * width
        factors = np.array([0.5 * width, 1.0, 2.0 / width, (2.0 / width) ** 3])
        whole[:, place[:, None], place] += factors[:, None, None] * np.outer(scale, scale) * blocks
    kept = free_freedoms(len(widths), order, turning_ends=turning_ends)
    whole = whole[:, kept][:, :, kept]
    whole.flags.writeable = False
    return Matrices(*whole)


def free_freedoms(n_elements: int, order: int, *, turning_ends: bool) -> BoolArray:
    """Return which freedoms are not held at the ends, as a boolean array."""
    kept = np.ones(2 * (n_elements + 1) + (order - 3) * n_elements, dtype=np.bool_)
    kept[[0, 2 * n_elements]] = False
    if not turning_ends:
        kept[[1, 2 * n_elements + 1]] = False
    return kept


@lru_cache(maxsize=128)
def _reference(order: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value, slope and curvature of the basis on [−1, 1] as Legendre series, each (order + 1, order + 1).

    Bubbles are twice integrated Legendre polynomials, so the bending energy of all of them is a unit matrix:
    nothing is lost to rounding at high order.
    """
    # ∫ P_k from −1 is (P_{k+1} − P_{k−1})/(2k + 1), and P_1 + P_0 for k = 0.
    k = np.arange(1, order)
    integral = np.zeros((order + 1, order + 1))
    integral[0, :2] = 1.0
    integral[k, k + 1], integral[k, k - 1] = 1.0 / (2 * k + 1), -1.0 / (2 * k + 1)
    curvature = np.zeros((order + 1, order + 1))
    curvature[:4, :2] = [[0.0, 1.5], [-0.5, 1.5], [0.0, -1.5], [0.5, 1.5]]
    bubbles = np.arange(2, order - 1)
    curvature[bubbles + 2, bubbles] = np.sqrt(bubbles + 0.5)
    slope = curvature @ integral
    slope[1, 0] += 1.0  # the second cubic begins with a slope of 1, the first one with a value of 1
    value = slope @ integral
    value[0, 0] += 1.0
    for table in (value, slope, curvature):
        table.flags.writeable = False
    return value, slope, curvature


# Below this share of its parts the margin no longer survives in the stiffness matrix by itself.
_NEAR_CRITICAL = 0.1


class Modes(NamedTuple):
    """The first modes in some space: scaled frequencies ω = 2π f l/c [-], and their decrease in a richer space."""

    frequencies: FloatArray
    errors: FloatArray


def galerkin_modes(
    beam: ScaledBeam, widths: tuple[float, ...], order: int, n_modes: int, beyond: int = 0
) -> Modes:
    """Return the first modes by polynomials of an order, and the relative error of each by those of `beyond` more.

    With w = Re Σ q_j φ_j e^{iωτ} the weak form is (K + iωG − ω²M) q = 0, K = S K_2 + ε² K_4 positive below the
    critical speed and G skew. In the energy norms of K and M it is the eigenproblem of a skew matrix; the one of
    its inverse gives the small frequencies to full relative precision and needs neither M⁻¹ nor large numbers. A
    Rayleigh quotient then makes the error of every mode quadratic in its vector's.

    What polynomials of higher order leave of a mode, its residual, is taken up by those made orthogonal to the others
    in energy; the frequency they lower it by is its error. Nothing but a small system a mode has to be solved for it.
    """
    turning = beam.ends.turns
    parts = assemble(widths, order + beyond, turning)
    degrees = np.r_[[3] * (2 * len(widths) + 2), np.tile(np.arange(4, order + beyond + 1), len(widths))]
    degrees = degrees[free_freedoms(len(widths), order + beyond, turning_ends=turning)]
    # The unknowns of the order itself come first: of the triangular factors theirs are the leading blocks.
    first, size = np.argsort(degrees > order, kind="stable"), int((degrees <= order).sum())
    mass, travel = parts.mass, parts.travel
    stiffness = beam.net * parts.tension + beam.stiffness * parts.bending
    if beam.margin < _NEAR_CRITICAL * abs(beam.net):
        mass, travel, stiffness = _near_critical(beam, parts, widths, order + beyond)
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    stiffness, mass, gyroscopic = (
        (one * np.outer(scale, scale))[np.ix_(first, first)] for one in (stiffness, mass, beam.speed * travel)
    )
    try:
        lower = np.asarray(np.linalg.cholesky(stiffness), dtype=np.float64)
        root = np.asarray(np.linalg.cholesky(mass), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise SolverError(
            f"the beam's stiffness is lost in rounding at order {order} on {len(widths)} elements",
            fix="use a lower order",
        ) from None
    half = scipy.linalg.solve_triangular(lower, gyroscopic, lower=True)
    turned = scipy.linalg.solve_triangular(lower, half.T, lower=True).T
    turned = 0.5 * (turned - turned.T)
    coupling = scipy.linalg.solve_triangular(lower, root, lower=True)
    hermitian = np.zeros((2 * size, 2 * size), dtype=np.complex128)
    hermitian[:size, :size] = -1j * turned[:size, :size]
    hermitian[:size, size:] = -1j * coupling[:size, :size]
    hermitian[size:, :size] = 1j * coupling[:size, :size].T
    _, vectors = scipy.linalg.eigh(hermitian, subset_by_index=[2 * size - n_modes, 2 * size - 1])
    energy_part = vectors[:size, ::-1]
    shape = scipy.linalg.solve_triangular(lower[:size, :size], energy_part, lower=True, trans="T")
    masses = np.sum(np.abs(root[:size, :size].T @ shape) ** 2, axis=0)
    energies = np.sum(np.abs(energy_part) ** 2, axis=0)
    gyration = -np.sum(shape.conj() * (1j * (gyroscopic[:size, :size] @ shape)), axis=0).real
    # −ω²m − gω + k = 0 for g as it stands here; the root without cancellation for either sign of g.
    swing = np.hypot(gyration, 2.0 * np.sqrt(masses * energies))
    with np.errstate(divide="ignore", invalid="ignore"):
        omega = np.where(
            gyration > 0.0, 2.0 * energies / (swing + gyration), (swing - gyration) / (2.0 * masses)
        )
    errors = np.zeros(n_modes)
    if beyond:
        # In energy coordinates the stiffness is 1, and what is richer is orthogonal to what is known.
        residual = 1j * omega * (turned[size:, :size] @ energy_part) - omega**2 * (
            coupling[size:, :size] @ (coupling[:size, :size].T @ energy_part)
        )
        at = omega[:, np.newaxis, np.newaxis]
        richer = 1j * at * turned[size:, size:] - at**2 * (coupling[size:] @ coupling[size:].T)
        values, axes = np.linalg.eigh(np.eye(len(first) - size) + richer)
        taken = np.sum(
            np.abs(np.swapaxes(axes.conj(), 1, 2) @ residual.T[..., np.newaxis])[..., 0] ** 2 / values, axis=1
        )
        # Where the richer polynomials swing as slowly as the mode itself, the order does not resolve it.
        errors = np.where(values[:, 0] > 0.0, taken / (energies + omega**2 * masses), np.inf)
    order_of = np.argsort(omega)
    return Modes(omega[order_of], errors[order_of])


def _near_critical(
    beam: ScaledBeam, parts: Matrices, widths: tuple[float, ...], order: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return mass, travel and stiffness in a basis that has the buckling mode in it.

    S K_2 + ε² K_4 = (−β K_2 + K_4) ε² + margin · K_2. The bracket times the buckling mode is exactly zero and is made
    so, which lets the margin stand by itself on the mode's own diagonal, however small it is.
    """
    buckled = _buckling_mode(beam, widths, order)
    replaced = int(np.argmax(np.abs(buckled) * np.sqrt(np.diag(parts.bending))))
    basis = np.eye(buckled.size)
    basis[:, replaced] = buckled
    mass, travel, tension, bending = (basis.T @ matrix @ basis for matrix in parts)
    travel[replaced, replaced] = 0.0
    critical = beam.stiffness * (bending - beam.ends.buckling * tension)
    critical[replaced, :] = 0.0
    critical[:, replaced] = 0.0
    return mass, travel, critical + beam.margin * tension


def _buckling_mode(beam: ScaledBeam, widths: tuple[float, ...], order: int) -> FloatArray:
    """Return the coefficients of the buckling mode, whose bending energy and nodal values they keep."""
    nodes, half = np.concatenate([[0.0], np.cumsum(widths)]), 0.5 * np.array(widths)
    values, slopes, _ = beam.ends.buckled(nodes)
    points, weights = np.polynomial.legendre.leggauss(order + 1)
    weighted = (np.polynomial.legendre.legvander(points, order) @ _reference(order)[2][4:].T).T * weights
    bubbles = [
        one**2 * weighted @ beam.ends.buckled(start + one * (1.0 + points))[2]
        for start, one in zip(nodes[:-1], half, strict=True)
    ]
    whole = np.concatenate([np.stack([values, slopes], axis=1).ravel(), *bubbles])
    return np.asarray(whole[free_freedoms(len(widths), order, turning_ends=beam.ends.turns)])


# Polynomials of so many orders more take up practically all of what an order errs by.
_BEYOND = 3
# Rounding alone, over many cases of stiffness and speed.
_ROUNDING = 1e-13


class BeamModes(NamedTuple):
    """Scaled frequencies with their cost and their errors."""

    frequencies: FloatArray
    errors: FloatArray
    orders: IntArray
    n_elements: int


def solve_beam(beam: ScaledBeam, n_modes: int = 6, *, accuracy: float = 1e-10) -> BeamModes:
    """Return the first frequencies of a scaled beam, each by an order at which its own error is small enough.

    A mode's error is taken off it and counts in full. The order is raised for the modes that need it, on the same
    elements: what has settled stays.
    """
    order = order_for(beam, n_modes, accuracy)
    widths, found = widths_for(beam, order), np.zeros(n_modes)
    errors, orders = np.full(n_modes, np.inf), np.zeros(n_modes, dtype=np.int64)
    while order + _BEYOND <= MAX_ORDER:
        modes = galerkin_modes(beam, widths, order, n_modes, _BEYOND)
        fresh = (orders == 0) | (errors > max(accuracy, _ROUNDING))
        found[fresh] = (modes.frequencies * (1.0 - modes.errors))[fresh]
        errors[fresh], orders[fresh] = modes.errors[fresh], order
        if (errors <= max(accuracy, _ROUNDING)).all():
            found.flags.writeable = False
            return BeamModes(found, errors, orders, len(widths))
        order += _BEYOND
    raise SolverError(
        f"{n_modes} modes do not settle to {accuracy:g} up to order {MAX_ORDER}; mode {int(np.argmax(errors)) + 1} "
        f"is off by {errors.max():g}",
        fix="use fewer modes or a larger accuracy",
    )


def scaled_beams(span: Span, ends: Ends) -> list[ScaledBeam]:
    """Return the scaled form of every case of a span that has a stiffness."""
    tension_N, margin_N = span.tension_N, refuse_overspeed(span, ends)
    numbers = {
        "stiffness": span.bending_stiffness_N_m2 / (tension_N * span.free_span_m**2),
        "speed": np.abs(span.travel_speed_m_s) / span.wave_speed_m_s,
        "net": span.net_tension_N / tension_N,
        "margin": margin_N / tension_N,
    }
    rows = np.stack([*numbers.values()], axis=1).tolist()
    return [ScaledBeam(ends=ends, **dict(zip(numbers, row, strict=True))) for row in rows]


def beam_frequencies_Hz(
    span: Span, ends: Ends = CLAMPED, n_modes: int = 6, *, accuracy: float = 1e-10
) -> FloatArray:
    """Return the first frequencies of spans as travelling beams; a case without stiffness is a string."""
    stiff = span.bending_stiffness_N_m2 / (span.tension_N * span.free_span_m**2) > 0.0
    if not stiff.any():
        return string_frequencies_Hz(span, n_modes)
    refuse_overspeed(span, ends)
    frequencies = np.empty((span.n, n_modes))
    if not stiff.all():
        frequencies[~stiff] = string_frequencies_Hz(span.select(~stiff), n_modes)
    hertz = span.wave_speed_m_s / (2.0 * math.pi * span.free_span_m)
    beams = scaled_beams(span.select(stiff), ends)
    scaled = _between_few(beams, n_modes, accuracy)
    if scaled is None:
        scaled = np.stack([solve_beam(beam, n_modes, accuracy=accuracy).frequencies for beam in beams])
    frequencies[stiff] = hertz[stiff, np.newaxis] * scaled
    return frequencies


_NODES = (3, 5, 9)
"""Along each axis; each are among the next."""
_FASTEST = 0.95
"""Of the wave speed: up to it frequencies change smoothly with speed."""


def _between_few(beams: list[ScaledBeam], n_modes: int, accuracy: float) -> FloatArray | None:
    """Return the scaled frequencies of many beams from those of a few in their box; None where that saves nothing.

    ln ω is interpolated in ln ε² and V between Chebyshev's nodes, until more of them change it by less than the
    accuracy: by about that much it is off with fewer, and by far less with these.
    """
    at = np.array([(math.log(one.stiffness), one.speed) for one in beams])
    if at[:, 1].max() > _FASTEST:
        return None

    @cache
    def log_frequencies(log_stiffness: float, speed: float) -> FloatArray:
        beam = ScaledBeam.at_speed(math.exp(log_stiffness), speed, beams[0].ends)
        return np.log(solve_beam(beam, n_modes, accuracy=accuracy).frequencies)

    def table_at(log_stiffnesses: list[float], speeds: list[float]) -> FloatArray:
        return np.array([[log_frequencies(one, speed) for speed in speeds] for one in log_stiffnesses])

    before = np.full(1, np.inf)
    for count in _NODES:
        axes, to_cases = zip(*(_nodes_between(values, count) for values in at.T), strict=True)
        if 2 * math.prod(axis.size for axis in axes) > len(beams):
            return None
        found = np.einsum("ni,nj,ijm->nm", *to_cases, table_at(*(axis.tolist() for axis in axes)))
        change = float(np.abs(found - before).max())
        if change <= accuracy:
            return np.asarray(np.exp(found))
        # Twice as many nodes square what is left.
        if math.sqrt(accuracy) < change < math.inf:
            return None
        before = found
    return None


def _nodes_between(values: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return Chebyshev's nodes from the least to the largest value, and the matrix from there to each, (n, nodes)."""
    middle, half = 0.5 * (values.max() + values.min()), 0.5 * np.ptp(values)
    n = count if half > 0.0 else 1
    nodes = np.cos(np.pi * np.arange(n) / max(n - 1, 1))
    at_values = chebyshev.chebvander((values - middle) / (half or 1.0), n - 1)
    return middle + half * nodes, np.asarray(at_values @ np.linalg.inv(chebyshev.chebvander(nodes, n - 1)))
