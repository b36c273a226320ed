"""Laws of friction where a wrap, an exponent, a size or a load vanishes, grows without bound or nearly meets another."""

import math
from functools import partial

import mpmath as mp
import numpy as np
import pytest
from hard_regime import EPS, START, answer, fact, refusals, refused, regime, relative, worst_law_error

from ropefric.fitting.fit import guess
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.integral import PowerSpan, power_log_start
from ropefric.friction.law import LiftModel
from ropefric.friction.laws import ALL_LAWS

EQUATION = "the printed equation, its slopes by differences"
# A stiff rope does not touch the wheel at a small wrap, and is refused there.
LIMP = [name for name in ALL_LAWS if name != "bending"]


def pull(wrap=6.0, tension=20.0, wheel=0.04, rope=0.005):
    """Return a pull as the truth takes it."""
    return wheel, rope, wrap, tension


def at(*args, **settings):
    """Return a pull as the library takes it."""
    return one_condition(*pull(*args, **settings))


def lift(name, theta, *args, **settings):
    return ALL_LAWS[name].log_lift(theta, at(*args, **settings))[0]


def moving(wrap, tension, density, speed, *, name="constant", theta=(0.2,)):
    return _log_lift_running(ALL_LAWS[name], density, speed, theta, at(wrap, tension))[0]


@regime("φ → 0", 1e-12, EQUATION,
        "every law, wraps of 1e-3 down to 1e-300 rad: ln F_A, mean coefficient and slopes")  # fmt: skip
def small_wrap():
    near = [(name, START[name], pull(wrap)) for name in LIMP for wrap in (1e-3, 1e-12)]
    far = [(name, START[name], pull(1e-300)) for name in LIMP]
    return max(worst_law_error(near), worst_law_error(far, digits=500))


@refusals
def small_wraps_without_a_mean():
    """Zero adds nothing and has no mean; nor has a rise that is no normal float, nor a rope too stiff to touch."""
    for name in LIMP:
        assert lift(name, START[name], 0.0) == at(0.0).log_end_tension[0], name
        yield partial(ALL_LAWS[name].average_mu, START[name], at(0.0)), "no average .* over a wrap of zero"
    for wrap in (5e-324, 1e-310, 1e-291):
        assert lift("constant", [0.2], wrap) == at(wrap).log_end_tension[0]
        yield partial(ALL_LAWS["constant"].average_mu, [0.2], at(wrap)), "no average coefficient"
    slopes = ALL_LAWS["wrap-power-from-zero"].log_lift_gradient_conditions
    assert slopes([0.2, 0.0, 0.1], at(0.0))[0, 1] == 0.2 + 0.1
    yield partial(slopes, [0.2, -0.5, 0.1], at(0.0)), "coefficient is infinite where"
    yield partial(lift, "bending", [0.2, 1e-4], 1e-9), "too stiff"


@regime("b → 0⁻", 1e-12, EQUATION,
        "power, exponential and coupled laws, exponents and rates of −1e-3 … −1e-300: ln F_A and slopes")  # fmt: skip
def exponent_to_zero():
    def cases(*sizes):
        for b in sizes:
            for name in ("wrap-power", "wrap-exponential"):
                yield name, [0.2, -b, 0.1], pull(7.0)
                yield f"{name}-from-zero", [0.2, -b, 0.1], pull(7.0)
            yield "coupled", [0.2, -0.2, -0.3, -b, 0.05], pull(7.0)

    return max(worst_law_error(cases(1e-3, 1e-9, 1e-16)), worst_law_error(cases(1e-300), digits=500))


@fact
def ordinary_pulls_keep_a_digit_more():
    """With b + 1 or b of any size, either part of μ nothing or next to it, and an end tension just below the limit."""
    rng = np.random.default_rng(7)
    for _ in range(6):
        (wrap, b), tension = rng.uniform((0.1, -0.95), (40.0, -0.01)), math.exp(rng.uniform(0.1, 6.0))
        steep, tiny, saturating = (-(10.0 ** rng.uniform(-1.0, 1.3)), 10.0 ** rng.uniform(-200, -10),
                                   math.exp(0.6))  # fmt: skip
        power = ([0.2, b, 0.1], [0.0, b, 0.1], [tiny, b, 0.1])
        exponential = ([0.2, 2.0 * b, 0.1], [0.2, steep, 0.1], [0.2, b, 1e-12], [0.0, b, 0.1])
        cases = [("wrap-power", theta, pull(wrap, tension)) for theta in power]
        cases += [("wrap-exponential", theta, pull(wrap, tension)) for theta in exponential]
        limited = ("wrap-exponential", [0.2, -rng.uniform(0.01, 0.33), 0.0], pull(wrap, saturating))
        assert worst_law_error([*cases, limited], digits=60, slopes=False) < 1e-13


# Far from φ = 1 rad, where ln φ changes sign and the slope by b with it.
INTEGRAL_START = 3.7


def stretches():
    """Yield ∫ φ^b over [3.7, 3.7 + δ] and its slope by b; a logarithm where b = −1."""
    for b in (-1.0, *(-1 + side * s for side in (1, -1) for s in (1e-3, 1e-9, 2.0**-52))):
        for delta in (1e-12, 0.3, 1e3):
            with mp.workdps(90):
                s, low = mp.mpf(b) + 1, mp.mpf(INTEGRAL_START)
                l0, l1 = mp.log(low), mp.log(low + mp.mpf(delta))
                value, slope = l1 - l0, (l1**2 - l0**2) / 2
                if s:
                    value = (mp.exp(s * l1) - mp.exp(s * l0)) / s
                    slope = ((s * l1 - 1) * mp.exp(s * l1) - (s * l0 - 1) * mp.exp(s * l0)) / s**2
            yield b, delta, value, slope


@regime("b → −1, c + 1 → 0", 1e-12, f"the antiderivative; {EQUATION}",
        "∫ φ^b over [p, p + δ] with b + 1 = ±1e-3 … ±2e-16 and 0, δ = 1e-12 … 1e3 rad, with slopes; the "
        "laws from above")  # fmt: skip
def exponent_to_minus_one():
    cases = [("wrap-power-from-zero", [0.2, s - 1, 0.1], pull(7.0)) for s in (1e-3, 1e-9, 2.0**-52)]
    cases += [(name, [0.2, -0.2, -0.3, s - 1, 0.1], pull(7.0)) for name in ("coupled", "coupled-from-zero")
              for s in (1e-3, 2.0**-52)]  # fmt: skip
    errors = [worst_law_error(cases, digits=520)]
    for b, delta, value, slope in stretches():
        span = PowerSpan(np.log(INTEGRAL_START), delta, b)
        errors += [relative(span.integral(), value), relative(span.slope(), slope)]
    return max(errors)


@fact
def where_the_problem_itself_is_ill_conditioned_no_more_is_lost():
    """ln φ0 = ln(y s/a)/s, so one rounding of y or a moves it, where φ0 is of the wrap's size, by κ = 1/s roundings."""
    for s in (1e-2, 1e-4, 1e-6):
        for start in (0.05, 0.7, 4.0):
            tension = min(float(mp.exp(0.2 * start**s / s)), 1e300)
            case = ("wrap-power", [0.2, s - 1.0, 0.0], pull(3.0, tension))
            assert worst_law_error([case], slopes=False) < 8 * EPS / s, (s, start)


@refusals
def integrals_that_diverge():
    for b in (-1.0, -1.0 - 2.0**-52, -1.5, -1e300):
        for name, theta in (("wrap-power", [0.2, b, 0.1]), ("coupled", [0.2, -0.2, -0.3, b, 0.1])):
            yield partial(lift, name, theta, 7.0), "diverges for k <= -1"
            yield partial(lift, f"{name}-from-zero", theta, 7.0), "diverges for k <= -1"


@regime("φ0 underflows", 1e-12, EQUATION,
        "a φ^b + c and the coupled law with b + 1 = 1e-3 … 2e-16, F_B = 1.5 … 1e6 N: ln F_A and slopes")  # fmt: skip
def start_underflow():
    """Return the worst error: ln φ0 is −5298 and far less."""
    power = [("wrap-power", [0.2, s - 1.0, c], pull(wrap, tension))
             for s, c, wrap, tension in [(1e-3, 0.1, 5.0, 2.7), (1e-3, 0.0, 40.0, 200.0),
                                         (1e-3, 0.01, 1e-9, 20.0), (1e-9, 0.1, 5.0, 1e6),
                                         (2.0**-52, 0.1, 17.0, 1.5), (2.0**-52, 0.0, 0.3, 20.0)]]  # fmt: skip
    coupled = [("coupled", [0.2, -0.2, -0.3, s - 1.0, 0.05], pull()) for s in (1e-3, 1e-12)]
    return worst_law_error([*power, *coupled], digits=500)


@fact
def a_start_far_below_every_float():
    """μ(φ0) is beyond every number there, so that the slope by ln F_B is nothing."""
    assert -5299 < power_log_start(1.0, 0.2, -0.999, 0.0) < -5298
    assert power_log_start(1.0, 0.2, -1 + 2.0**-52, 0.0) < -1e17
    slopes = ALL_LAWS["wrap-power"].log_lift_gradient_conditions([0.2, -0.999, 0.1], at(5.0, 2.7))
    assert slopes[0, 2] == 0.0


FROM_REFERENCE = {"wrap-power": [[0.2, -0.5, 0.1], [0.3, -0.9, 0.0]],
                  "wrap-exponential": [[0.2, -0.5, 0.1], [0.1, -5.0, 1e-6]],
                  "coupled": [[0.2, -0.2, -0.3, -0.6, 0.05]]}  # fmt: skip


@regime("F_B → F_0⁺", 1e-12, EQUATION,
        "F_B/F_0 − 1 = 1e-3 … 2e-16 with wraps of 1e-9 … 60 rad: ln F_A and slopes; F_B < F_0 is refused")  # fmt: skip
def reference_tension():
    """Return the worst error: φ0 vanishes, and μ(φ0) is infinite."""

    def cases(names, place):
        for name in names:
            above = (1e-3, 2.0**-30, 2.0**-52) * 2
            for more, wrap in zip(above, (1e-9, 2.0, 60.0, 60.0, 1e-9, 2.0), strict=True):
                yield name, FROM_REFERENCE[name][place], pull(wrap, 1.0 + more)

    # With b = -0.9 and no plateau the slope by ln F_B is as small as 1e-140.
    steep = worst_law_error(cases(["wrap-power", "wrap-exponential"], 1), digits=350)
    return max(worst_law_error(cases(FROM_REFERENCE, 0)), steep)


@refusals
def tensions_below_the_reference():
    """At F_0 the wrap counts from zero; below, no wrap stands for the tension."""
    for name, (theta, *_) in FROM_REFERENCE.items():
        law, free = ALL_LAWS[name], ALL_LAWS[name].variant
        at_reference = at(2.0, 1.0)
        assert law.log_lift(theta, at_reference)[0] == pytest.approx(
            free.log_lift(theta, at_reference)[0], rel=1e-15
        )
        assert 0.0 <= law.log_lift_gradient_conditions(theta, at_reference)[0, 2] < 1.0
        for tension in (1 - 2.0**-53, 0.5, 1e-300, 5e-324):
            call, said = (partial(lift, name, theta, 2.0, tension),
                          "below F_0 = 1 N, so no wrap angle is equivalent to it")  # fmt: skip
            assert "-from-zero" in refused(call, said).fix
            assert free.average_mu(theta, at(2.0, tension))[0] > 0.0
            yield call, said


@regime("r → 0 and r → ∞", 1e-12, EQUATION,
        "every law with a size effect, R_w/R_r from 1e-298 to 1e298, b = 0 too: ln F_A and slopes")  # fmt: skip
def size_ratio():
    parameters = {"size-power": [[0.2, 1.5, 0.02], [0.2, 1.0, 0.0]],
                  "size-exponential": [[0.2, -0.2, -0.3], [0.2, -0.2, 0.0]],
                  "coupled": [[0.2, -0.2, -0.3, -0.4, 0.05], [0.2, -0.2, 0.0, -0.4, 0.05]],
                  "thickness": [[0.2], [3.0]], "howell": [[0.5, 0.9]]}  # fmt: skip

    def cases(sizes, most):
        for name, sets in parameters.items():
            for theta in sets[:most]:
                yield from ((name, theta, pull(wheel=wheel, rope=rope)) for wheel, rope in sizes)

    near = worst_law_error(cases([(1e-9, 0.005), (0.001, 0.005), (1e9, 0.005), (0.04, 1e-9)], 2))
    far = [case for case in cases([(1e-300, 0.005), (0.04, 1e-298)], 1) if case[0] != "coupled"]
    return max(near, worst_law_error(far, digits=950))


@refusals
def ratios_that_no_float_holds():
    """A very large wheel is Euler's equation."""
    for name, theta in [
        ("size-power", [0.15, 2.0, 0.05]), ("size-exponential", [0.2, -0.2, -0.3]), ("thickness", [0.2]),
    ]:  # fmt: skip
        assert ALL_LAWS[name].average_mu(theta, at(wheel=1e296))[0] == pytest.approx(0.2, rel=1e-15), name
    for wheel, rope in [(1e300, 1e-300), (5e-324, 1e10), (1.7e308, 1.7e308)]:
        yield partial(at, wheel=wheel, rope=rope), "no number holds R_w/R_r"


@regime("e^(a r + b) > 1", None, "the text of the error",
        "negative μ is refused; the message names the condition")  # fmt: skip
def negative_coefficient():
    small = at(wheel=0.02)  # a r = -0.8
    ways = "log_lift", "jacobian", "log_lift_and_jacobian", "log_lift_gradient_conditions", "average_mu"
    for way in ways:
        for b in (0.8 + 1e-12, 0.9, 20.0, 1e300):
            theta = [0.2, -0.2, b]
            call = partial(getattr(ALL_LAWS["size-exponential"], way), theta, small)
            error = refused(call, r"so e\^\(a r \+ b\) > 1")
            assert "condition 0" in str(error)
            assert error.fix
            for name in ("coupled", "coupled-from-zero"):
                call = partial(getattr(ALL_LAWS[name], way), [*theta, -0.4, 0.05], small)
                yield call, r"e\^\(a r \+ b\) > 1"
    for name, theta, said in [("constant", [-1e-300], "negative"),
                              ("wrap-power", [-1e-300, -0.4, 0.1], "coefficient of φ\\^k is .* negative"),
                              ("wrap-power", [0.2, -0.4, -1e-300], "constant part of μ is .* negative"),
                              ("wrap-exponential", [-1e-300, -0.4, 0.1], "negative: μ would rise"),
                              ("wrap-exponential", [0.2, -0.4, -1e-300], "negative: μ turns negative"),
                              ("thickness", [-1e-300], "negative"), ("groove", [-1e-300, 0.3], "negative"),
                              ("howell", [0.0, 0.9], "needs it positive"),
                              ("bending", [-1e-300, 1e-4], "negative")]:  # fmt: skip
        yield partial(lift, name, theta), said
    pulls = Conditions(
        wheel_radius_m=[0.04, 0.03, 0.01], rope_radius_m=0.005, wrap_angle_rad=6.0, end_tension_N=20
    )
    law, theta = ALL_LAWS["size-exponential"], [0.2, -0.2, 0.5]
    yield partial(law.log_lift, theta, pulls), "condition 2"
    assert len(law.validity(theta, pulls)) == 1
    assert not law.admissible(theta, pulls)
    assert np.isfinite(law.log_lift(theta, pulls.select([0, 1]))).all()


@fact
def just_inside_the_edge_of_a_negative_coefficient_there_is_an_answer():
    """As exact as a r + b itself, which cancels there."""
    small, law = at(wheel=0.02), ALL_LAWS["size-exponential"]
    edge = 0.2 * float(small.size_ratio[0])
    assert law.average_mu([0.2, -0.2, edge], small)[0] == 0.0
    assert law.average_mu([0.2, -0.2, edge - 1e-12], small)[0] == pytest.approx(0.2e-12, rel=1e-3)


@regime("100 turns and more", 1e-12, EQUATION,
        "every law, 100 to 1e12 turns, ln F_A up to 1e12: ln F_A and slopes; the force beyond e^709.78 is "
        "refused")  # fmt: skip
def many_turns():
    cases = [(name, START[name], pull(math.tau * turns)) for name in LIMP for turns in (100, 1000, 1e12)]
    return worst_law_error([*cases, ("bending", START["bending"], pull(math.tau * 100))])


@fact
def the_logarithm_is_finite_where_the_force_is_no_number():
    """Friction that falls with the tension, or along the wrap to a small plateau, never gets there."""
    for name in sorted(set(ALL_LAWS) - {"howell", "wrap-exponential"}):
        assert lift(name, START[name], math.tau * 30_000) > 709.8, name
    wrap = (math.log(1.7976931348623157e308) - math.log(20.0)) / 0.2
    assert 1.79e308 < math.exp(lift("constant", [0.2], wrap * (1 - 1e-15))) < math.inf
    # Inertia counts for nothing there.
    many = math.tau * 1000
    assert np.isclose(moving(many, 20.0, 0.06, 10.0), math.log(14.0) + 0.2 * many, rtol=1e-15, atol=0.0)


@regime("F_B → ρv²⁺", 1e-12, "ρv² + (F_B − ρv²) e^(μφ)",
        "F_B/ρv² − 1 = 1e-3 … 2e-16: ln F_A, and the force that friction adds, to the digits that F_B − ρv² "
        "has")  # fmt: skip
def inertia():
    """Return the worst error at ρv² = 16 N, exact in floats."""
    errors = []
    for above in (1e-3, 2.0**-30, 2.0**-52):
        tension = 16.0 * (1 + above)
        with mp.workdps(60):
            truth = mp.log(16 + (mp.mpf(tension) - 16) * mp.exp(mp.mpf(0.2) * 25))
        errors.append(relative(moving(25.0, tension, 0.0625, 16.0), truth))
    return max(errors)


@refusals
def ropes_that_lift_off():
    """A rope at rest is the law itself, whatever its size."""
    for tension in (1e-310, 1e-300, 20.0, 1e300):
        assert moving(25.0, tension, 1e300, 0.0) == lift("constant", [0.2], 25.0, tension)
    for speed in (16.0, 16.000001, 1e9, 1e160, 1.7e308, -17.0):
        yield (partial(moving, 25.0, 16.0, 0.0625, speed),
               "is not below F_B at condition 0 .*: the rope lifts off the wheel")  # fmt: skip
    yield (partial(moving, 25.0, 16.5, 0.0625, 16.0, name="wrap-power", theta=[0.2, -0.5, 0.1]),
           "F_B = 0.5 N is below F_0")  # fmt: skip
    for speed in (np.nan, np.inf, -np.inf):
        yield partial(moving, 25.0, 16.0, 0.0625, speed), "must be finite"


EXTREMES = (5e-324, 1e-310, 1e-300, 1e-160, 1e-16, 0.04, 1.0, 20.0, 1e16, 1e160, 1e300, 1.7e308)


@regime("1e-310 and 1e300", 1e-12, EQUATION,
        "every law with one input at a time at 1e-300, 1e300 or subnormal; every other function on a grid "
        "of such numbers: finite or refused, never a warning")  # fmt: skip
def extreme_inputs():
    plain = ["constant", "constant-offset", "groove", "wrap-power-from-zero", "wrap-exponential-from-zero"]
    loads = dict.fromkeys(plain, (1e-310, 1e300)) | {"howell": (1e-300, 1e300)}
    loads |= dict.fromkeys(["wrap-power", "wrap-exponential", "coupled"], (1e300,))
    load = [(name, START[name], pull(tension=F)) for name, tensions in loads.items() for F in tensions]
    sizes = ["size-exponential", "size-power", "thickness"]
    both = [(name, START[name], pull(wheel=1e300, rope=1e300)) for name in sizes]
    tiny = [("constant", [1e-300], pull()), ("wrap-power", [1e-300, -0.5, 0.1], pull()),
            ("wrap-power", [0.2, -0.5, 1e-300], pull()), ("wrap-exponential", [1e-300, -0.5, 0.1], pull()),
            ("thickness", [1e-150], pull())]  # fmt: skip
    return max(worst_law_error(load, digits=120), worst_law_error([*both, *tiny], digits=500))


@fact
def laws_answer_extremes_or_refuse():
    for name, law in ALL_LAWS.items():
        rng, answered = np.random.default_rng(10), 0
        for _ in range(8):
            settings = rng.choice(EXTREMES, 4)
            if answer(partial(_numbers_of_conditions, settings)) is None:
                continue
            at, bounds = one_condition(*settings), [(p.lower, p.upper, p.start) for p in law.parameters]
            theta = [[*b, rng.choice(EXTREMES), -rng.choice(EXTREMES)][rng.integers(5)] for b in bounds]
            density, speed, force = rng.choice(EXTREMES, 3)
            calls = (partial(law.log_lift_and_jacobian, theta, at),
                     partial(law.log_lift_gradient_conditions, theta, at),
                     partial(law.average_mu, theta, at),
                     partial(_log_lift_running, law, density, speed, theta, at),
                     partial(guess, law, at, [force]))  # fmt: skip
            answered += sum(answer(call) is not None for call in calls)
        assert answered > 2, name


def _numbers_of_conditions(settings):
    found = one_condition(*settings)
    return found.size_ratio, found.centreline_radius_m, found.log_end_tension


def _log_lift_running(law, density, speed, *pull):
    return LiftModel(law=law, linear_density_kg_m=density, speed_m_s=speed).log_lift(*pull)
