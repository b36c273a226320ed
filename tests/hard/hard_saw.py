"""A travelling blade in many digits: its characteristic equation, and a string's by the time a wave takes."""

import mpmath as mp
import numpy as np

__all__ = ["beam_frequencies", "beam_of_span_Hz", "first_of_string_Hz"]

_DIGITS = 40
_SETTLED = 22


def first_of_string_Hz(*, c, v, length):
    """Return f_1, one over the time of a wave there and back."""
    return 1 / (length / (c + v) + length / (c - v))


def beam_frequencies(near, stiffness, ends, *, speed=None, shortfall=None):
    """Return the roots of the characteristic equation nearest to some scaled frequencies, as mpmath numbers.

    Either the speed ratio V is given, or the shortfall δ of V = (1 − δ) V_c; all floats are taken as they are.
    """
    with mp.workdps(_DIGITS):
        eps2, beta = mp.mpf(stiffness), mp.pi**2 * (1 if ends.turns else 4)
        if speed is not None:
            V = mp.mpf(speed)
            S = 1 - V**2
        else:
            delta, limit = mp.mpf(shortfall), 1 + beta * eps2
            V = mp.sqrt(limit) * (1 - delta)
            S = limit * delta * (2 - delta) - beta * eps2
        return [_root(mp.mpf(float(omega)), eps2, S, V, ends) for omega in near]


def beam_of_span_Hz(near_Hz, span, ends):
    """Return f_1 of a span's own floats, near some value; the tension and the shortfall in many digits."""
    with mp.workdps(_DIGITS):
        m, F_0, pull, EI, length, kappa, w, v = (
            mp.mpf(float(getattr(span, name)[0]))
            for name in (
                "linear_density_kg_m", "preload_N", "pull_N", "bending_stiffness_N_m2", "free_span_m",
                "mounting_factor", "wheel_speed_m_s", "travel_speed_m_s",
            )
        )  # fmt: skip
        F = F_0 + pull + kappa * m * w**2
        scale = mp.sqrt(F / m) / (2 * mp.pi * length)
        V = v / mp.sqrt(F / m)
        near = mp.mpf(float(near_Hz)) / scale
        return _root(near, EI / (F * length**2), 1 - V**2, V, ends) * scale


def _root(near, eps2, S, V, ends):
    settled = mp.mpf(10) ** -_SETTLED
    last, root = near, near * (1 + mp.mpf(10) ** -9)
    value = _characteristic(last, eps2, S, V, ends)
    for _ in range(20):
        old, value = value, _characteristic(root, eps2, S, V, ends)
        last, root = root, root - value * (root - last) / (value - old)
        if abs(root - last) < abs(root) * settled:
            break
    assert abs(root - last) < abs(root) * settled
    assert abs(mp.im(root)) < abs(root) * mp.mpf(10) ** -20
    return mp.re(root)


def _characteristic(omega, stiffness, net, speed, ends):
    """Return the determinant of the end conditions of the four waves e^{ikx}; ε²k⁴ + S k² − 2Vωk − ω² = 0."""
    ks = _quartic_roots([1, 0, net / stiffness, -2 * speed * omega / stiffness, -(omega**2) / stiffness])
    matrix = mp.matrix(4, 4)
    bends = 2 if ends.turns else 1
    for row, (place, order) in enumerate(((0, 0), (0, bends), (1, 0), (1, bends))):
        for column, k in enumerate(ks):
            # Waves that grow towards the far end are measured there.
            shift = 1j * k if mp.im(k) < -1 else 0
            matrix[row, column] = (1j * k) ** order * mp.exp(1j * k * place - shift)
    for row in (1, 3):
        largest = max(abs(matrix[row, column]) for column in range(4))
        for column in range(4):
            matrix[row, column] /= largest
    apart = mp.mpf(1)
    for i in range(4):
        for j in range(i):
            apart *= ks[i] - ks[j]
    return mp.det(matrix) / apart


def _quartic_roots(coefficients):
    """Return all four roots at once (Durand and Kerner), from those of doubles."""
    roots = [mp.mpmathify(complex(root)) for root in np.roots([complex(c) for c in coefficients])]
    for _ in range(100):
        largest = mp.mpf(0)
        for i, root in enumerate(roots):
            apart = mp.fprod(root - other for j, other in enumerate(roots) if j != i)
            value = coefficients[0]
            for coefficient in coefficients[1:]:
                value = value * root + coefficient
            step = value / apart
            roots[i] = root - step
            largest = max(largest, abs(step) / abs(root))
        if largest < mp.mpf(10) ** (2 - mp.mp.dps):
            break
    return roots
