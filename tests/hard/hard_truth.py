"""Every friction law from its printed equation in many digits: values, and slopes by differences.

Nothing is shared with the library: no closed form that was rearranged, no derivative made by hand. Each root is
proven by a change of sign about it. The digits are those of mpmath: inputs far apart need more than their distance in
powers of ten.
"""

from functools import cache

import mpmath as mp

__all__ = ["condition_slopes", "parameter_slopes", "rise"]

WHEEL, ROPE, WRAP, TENSION = range(4)


def _step():
    return mp.mpf(10) ** -(mp.mp.dps // 3)


def _exactly(numbers):
    return [mp.mpf(x) for x in numbers]


def rise(name, theta, pull):
    """Return ln F_A − ln F_B of one pull (R_w, R_r, φ, F_B), all numbers taken exactly as they are."""
    return _RISE[name](*_exactly(theta), _exactly(pull))


def parameter_slopes(name, theta, pull):
    """Return ∂ ln F_A/∂θ, by central differences of a relative step."""
    theta, pull = _exactly(theta), _exactly(pull)
    return [_slope(lambda moved: _RISE[name](*moved, pull), theta, i) for i in range(len(theta))]


def condition_slopes(name, theta, pull):
    """Return ∂ ln F_A by R_w, φ and ln F_B; from F_B = F_0 only upwards, because below there is no answer."""
    theta, pull = _exactly(theta), _exactly(pull)

    def by(place, *, upwards=False):
        return _slope(lambda moved: _RISE[name](*theta, moved), pull, place, upwards=upwards)

    by_tension = 1 + by(TENSION, upwards=pull[TENSION] == 1) * pull[TENSION]
    return [by(WHEEL), by(WRAP, upwards=pull[WRAP] == 0), by_tension]


def _slope(function, at, i, *, upwards=False):
    h = abs(at[i]) * _step() or _step()

    def moved(step):
        return function([*at[:i], at[i] + step, *at[i + 1 :]])

    if upwards:
        return (4 * moved(h) - moved(2 * h) - 3 * moved(0)) / (2 * h)
    return (moved(h) - moved(-h)) / (2 * h)


def _proven(root, function):
    """Return a root of an increasing function after making sure of it."""
    off = _step() ** 2 * max(1, abs(root))
    assert function(root - off) <= 0 <= function(root + off), root
    return root


def _newton(function, slope, start):
    root = start
    for _ in range(2000):
        step = function(root) / slope(root)
        root -= step
        if abs(step) <= _step() ** 2 / 1000 * max(1, abs(root)):
            return _proven(root, function)
    raise AssertionError(f"no root from {start}")


@cache
def _log_start_of_power(y, a, b, c):
    """Return ln φ0 of a φ0^{b+1}/(b+1) + c φ0 = y; in u = ln φ0 the left side is convex and rises."""
    s = b + 1
    tops = ([mp.log(y * s / a) / s] if a > 0 else []) + ([mp.log(y / c)] if c > 0 else [])
    return _newton(lambda u: a / s * mp.exp(s * u) + c * mp.exp(u) - y,
                   lambda u: a * mp.exp(s * u) + c * mp.exp(u), min(tops))  # fmt: skip


def _power(y, delta, a, b, c):
    s = b + 1
    if y == 0 or y is None:
        return a * delta**s / s + c * delta
    u = _log_start_of_power(y, a, b, c)
    end = u + mp.log1p(delta * mp.exp(-u))
    return a / s * (mp.exp(s * end) - mp.exp(s * u)) + c * delta


def _exponential(y, delta, a, b, c):
    def integral(phi):
        return (a * mp.expm1(b * phi) / b if b else a * phi) + c * phi

    if not y:
        return integral(delta)
    # Concave and rising, so Newton's method climbs from below.
    p = _newton(lambda phi: integral(phi) - y, lambda phi: a * mp.exp(b * phi) + c, y / (a + c))
    return integral(p + delta) - y


def _size(mu_inf, a, b, pull):
    return mu_inf * (1 - mp.exp(a * pull[WHEEL] / pull[ROPE] + b))


def _thickness(mu, pull):
    A = pull[ROPE] / (pull[WHEEL] + pull[ROPE])
    return (-1 + mp.sqrt(1 + 4 * A * mu**2 * (1 - A))) / (2 * A * mu) * pull[WRAP]


def _howell(A, n, pull):
    T, R, q = pull[TENSION], pull[WHEEL] + pull[ROPE], 1 - n
    if q == 0:
        return A * pull[WRAP]
    return mp.log(T**q + q * A * R**q * pull[WRAP]) / q - mp.log(T)


def _bending(mu, rigidity, pull):
    E = rigidity / (2 * (pull[WHEEL] + pull[ROPE]) ** 2)
    F_B = pull[TENSION]

    def balance(h):
        F_A = F_B * mp.exp(h)
        contact = pull[WRAP] - mp.acos(1 - E / F_A) - mp.acos(1 - E / F_B)
        return mp.log((F_A - E) / (F_B - E)) - mu * contact

    low, high = mp.mpf(0), mu * pull[WRAP]
    h = mp.findroot(
        balance, (low, high), solver="anderson", tol=_step() ** 2 / 1000, verify=False, maxsteps=200
    )
    return _proven(h, balance)


_RISE = {
    "constant": lambda mu, pull: mu * pull[WRAP],
    "constant-offset": lambda mu, k, pull: mu * pull[WRAP] + k,
    "size-power": lambda mu, a, b, pull: (
        (mu * (pull[WHEEL] / (pull[WHEEL] + pull[ROPE])) ** a + b) * pull[WRAP]
    ),
    "size-exponential": lambda mu, a, b, pull: _size(mu, a, b, pull) * pull[WRAP],
    "wrap-average": lambda a, b, pull: a * pull[WRAP] ** (1 + b),
    "wrap-power": lambda a, b, c, pull: _power(mp.log(pull[TENSION]), pull[WRAP], a, b, c),
    "wrap-power-from-zero": lambda a, b, c, pull: _power(None, pull[WRAP], a, b, c),
    "wrap-exponential": lambda a, b, c, pull: _exponential(mp.log(pull[TENSION]), pull[WRAP], a, b, c),
    "wrap-exponential-from-zero": lambda a, b, c, pull: _exponential(None, pull[WRAP], a, b, c),
    "coupled": lambda mu, a, b, c, d, pull: _power(
        mp.log(pull[TENSION]), pull[WRAP], _size(mu, a, b, pull), c, d
    ),
    "coupled-from-zero": lambda mu, a, b, c, d, pull: _power(None, pull[WRAP], _size(mu, a, b, pull), c, d),
    "thickness": _thickness,
    "bending": _bending,
    "howell": _howell,
    "groove": lambda mu, half_angle, pull: mu / mp.sin(half_angle) * pull[WRAP],
}
