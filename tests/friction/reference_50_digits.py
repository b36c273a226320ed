"""Independent 50-digit references for the wrap integrals, written from the differential equation alone."""

import mpmath as mp

mp.mp.dps = 50


def root(function, low, high):
    """Bisection and then secant steps on a bracket: slow, dull, and sharing nothing with the library."""
    low, high = mp.mpf(low), mp.mpf(high)
    assert function(low) <= 0 <= function(high), (low, high)
    for _ in range(60):
        middle = (low + high) / 2
        if function(middle) <= 0:
            low = middle
        else:
            high = middle
    return mp.findroot(
        function, (low, high), solver="anderson", tol=mp.mpf(10) ** -180, verify=False, maxsteps=200
    )


def power_antiderivative(phi, a, b, c):
    a, b, c = mp.mpf(a), mp.mpf(b), mp.mpf(c)
    if b == -1:
        return a * mp.log(phi) + c * phi
    return a * phi ** (b + 1) / (b + 1) + c * phi


def power_rise(y, delta, a, b, c):
    """∫ μ over [φ0, φ0 + δ] for μ = a φ^b + c with ∫ μ over [0, φ0] = y."""
    a, b, c, y, delta = (mp.mpf(value) for value in (a, b, c, y, delta))
    if y == 0:
        return power_antiderivative(delta, a, b, c)
    s = b + 1
    tops = []
    if a > 0:
        tops.append(mp.log(y * s / a) / s)
    if c > 0:
        tops.append(mp.log(y / c))
    top = min(tops)
    with mp.extradps(50):
        u = root(
            lambda v: a / s * mp.exp(s * v) + c * mp.exp(v) - y, top - 2 / s - 2, top + mp.mpf(10) ** -40
        )
        # In the logarithm of the angle, because for b near -1 the start lies at e^-1e9 rad, far below any digit.
        log_end = u + mp.log1p(delta * mp.exp(-u))
        return a / s * (mp.exp(s * log_end) - mp.exp(s * u)) + c * delta


def exponential_rise(y, delta, a, b, c):
    """The same for μ = a e^{bφ} + c."""
    a, b, c, y, delta = (mp.mpf(value) for value in (a, b, c, y, delta))

    def integral(phi):
        return (a * mp.expm1(b * phi) / b if b else a * phi) + c * phi

    if y == 0:
        return integral(delta)
    tops = [y / c] if c else []
    if a and b and -b * y / a < 1:
        tops.append(mp.log1p(b * y / a) / b)
    if not b:
        tops.append(y / (a + c))
    with mp.extradps(50):
        p = root(lambda v: integral(v) - y, 0, min(tops) * (1 + mp.mpf(10) ** -40))
        return integral(p + delta) - y
