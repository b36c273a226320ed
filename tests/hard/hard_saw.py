"""A travelling blade near its critical speed, without stiffness, without tension; its truth in many digits."""

import math
from functools import partial

import mpmath as mp
import numpy as np
from hard_machines import extreme
from hard_regime import answer, fact, refusals, refused, regime, relative

from ropefric.systems.bandsaw.answer import SawProblem, frequencies_Hz, span_of
from ropefric.systems.bandsaw.beam import (
    ScaledBeam,
    beam_frequencies_Hz,
    galerkin_modes,
    order_for,
    solve_beam,
    widths_for,
)
from ropefric.systems.bandsaw.effects import SYSTEM
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.span import CLAMPED, ENDS, PINNED, Span, string_frequencies_Hz
from ropefric.systems.effect import assemble

LENGTH, DENSITY, PRELOAD, STIFFNESS = 1.6, 0.5967, 3412.0, 1.0637
BLADE = {"free_span_m": LENGTH, "linear_density_kg_m": DENSITY, "preload_N": PRELOAD}
PULLED = BLADE | {"pull_N": -105.475}
STIFF = BLADE | {"bending_stiffness_N_m2": STIFFNESS}
STRING = "the inverse of the time of a wave there and back"
CHARACTERISTIC = "the characteristic equation"
_DIGITS = 40
_SETTLED = 22


def first_of_string_Hz(*, c, v, length):
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


def floats_of(span):
    """Return F_0, its change, m, κ, both speeds, EI and l of a span, as they are."""
    names = ("preload_N", "pull_N", "linear_density_kg_m", "mounting_factor", "wheel_speed_m_s", "travel_speed_m_s",
             "bending_stiffness_N_m2", "free_span_m")  # fmt: skip
    return [mp.mpf(float(getattr(span, name)[0])) for name in names]


def beam_of_span_Hz(near_Hz, span, ends):
    """Return f_1 of a span's own floats, near some value; the tension and the shortfall in many digits."""
    with mp.workdps(_DIGITS):
        F_0, pull, m, kappa, w, v, EI, length = floats_of(span)
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


def running(v, kappa=0.0, blade=BLADE, **more):
    return Span(**blade | more, mounting_factor=kappa, wheel_speed_m_s=v, travel_speed_m_s=v)


def limit(kappa, blade=BLADE, ends=PINNED):
    return float(Span(**blade, mounting_factor=kappa).critical_speed_m_s(ends)[0])


def string_errors(span, count=1):
    with mp.workdps(60):
        F_0, pull, m, kappa, w, v, _, length = floats_of(span)
        truth = first_of_string_Hz(c=mp.sqrt((F_0 + pull + kappa * m * w**2) / m), v=v, length=length)
        for n, found in enumerate(string_frequencies_Hz(span, count)[0], start=1):
            yield relative(found, n * truth)


def beam_error(span):
    found = beam_frequencies_Hz(span, CLAMPED, 1, accuracy=1e-13)[0, 0]
    return relative(found, beam_of_span_Hz(found, span, CLAMPED))


def saw(wheel_speed_rad_s, tension_difference_N, **more):
    return SawProblem(**BLADE, n_modes=1, wheel_radius_m=0.35, wheel_speed_rad_s=wheel_speed_rad_s,
               tension_difference_N=tension_difference_N, **more)  # fmt: skip


SHORTFALLS = [10.0**-k for k in range(3, 16)]


@regime("v → c⁻, string", 1e-14, STRING,
        "1 − v/c = 1e-3 … 1e-15: frequencies from tension, mass, mounting and speed")  # fmt: skip
def critical_string():
    return max(error for shortfall in SHORTFALLS for kappa in (0.0, 0.3, 0.75)
               for error in string_errors(running(limit(kappa, PULLED) * (1.0 - shortfall), kappa, PULLED),
                                          6))  # fmt: skip


@refusals
def strings_at_their_critical_speed_and_above():
    """√(100/0.25) = 20 exactly: the last speed below is answered."""
    blade = {"free_span_m": 1.0, "linear_density_kg_m": 0.25, "preload_N": 100.0}
    assert max(string_errors(Span(**blade, travel_speed_m_s=math.nextafter(20.0, 0.0)))) <= 1e-14
    for speed in (20.0, math.nextafter(20.0, 21.0), 1e3, 1e30, -20.0):
        call = partial(string_frequencies_Hz, Span(**blade, travel_speed_m_s=speed), 1)
        yield call, "its critical speed is 20 m/s: there its first frequency is zero"
    for kappa in (0.0, 0.5, 0.99):
        critical = math.sqrt((PRELOAD - 105.475) / (DENSITY * (1.0 - kappa)))
        fast = saw(critical * (1.0 + 1e-9) / 0.35, 210.95, mounting_factor=kappa)
        fast = assemble(SYSTEM, fast, SYSTEM.effects)
        assert frequencies_Hz(fast, Side.TIGHT, 1)[0, 0] > 0.0
        yield partial(frequencies_Hz, fast, Side.SLACK, 1), f"its critical speed is {critical:.9g} m/s"


def at_shortfall(stiffness, shortfall, ends):
    """Return the beam at V = (1 − δ) V_c, as exact as δ is."""
    limit_squared = 1.0 + ends.buckling * stiffness
    margin = limit_squared * shortfall * (2.0 - shortfall)
    speed = math.sqrt(limit_squared) * (1.0 - shortfall)
    net = margin - ends.buckling * stiffness
    return ScaledBeam(stiffness=stiffness, speed=speed, net=net, margin=margin, ends=ends)


@regime("v → v_c⁻, beam", 1e-12, CHARACTERISTIC,
        "1 − v/v_c = 1e-3 … 1e-15, EI/(F l²) = 1 … 1e-10, pinned and clamped: the frequencies, from "
        "scaled numbers and from newtons and metres")  # fmt: skip
def critical_beam():
    errors = []
    # Every shortfall and every stiffness for both ends, not all of their product.
    for number, shortfall in enumerate(SHORTFALLS):
        stiffness = (1.0, 1e-2, 1e-6, 1e-10)[number % 4]
        for ends in ENDS.values():
            found = solve_beam(at_shortfall(stiffness, shortfall, ends), 2, accuracy=1e-12).frequencies
            truth = beam_frequencies(found, stiffness, ends, shortfall=shortfall)
            errors += [relative(*pair) for pair in zip(found, truth, strict=True)]
    for kappa in (0.0, 0.5):
        critical = limit(kappa, STIFF, CLAMPED)
        errors += [beam_error(running(critical * (1 - less), kappa, STIFF)) for less in (1e-3, 1e-9, 1e-12)]
    return max(errors)


@refusals
def beams_at_their_critical_speed_and_above():
    for ends in ENDS.values():
        critical = math.sqrt((PRELOAD + ends.buckling * STIFFNESS / LENGTH**2) / DENSITY)
        for above in (0.0, 1e-12, 1e-3, 10.0):
            more = (1.0 + above) * (1.0 + 1e-15)
            span = Span(**STIFF, travel_speed_m_s=critical * more)
            yield partial(beam_frequencies_Hz, span, ends, 1), f"its critical speed is {critical:.9g} m/s"


@regime("κ → 1", 1e-12, f"{STRING}; {CHARACTERISTIC}",
        "1 − κ = 1e-3 … 1e-16 and 0, v up to 1e6 m/s and to 1e-13 below the critical speed: the string's "
        "frequencies and the critical speed; a beam's at 35 … 1000 m/s")  # fmt: skip
def constant_force():
    """Return the worst error where the wheels' inertia tension and the motion all but cancel."""
    errors = []
    for kappa in [1.0 - 10.0**-k for k in range(3, 17)] + [1.0]:
        critical = limit(kappa, PULLED)
        if kappa < 1.0:
            with mp.workdps(60):
                held = (mp.mpf(PRELOAD) + mp.mpf(PULLED["pull_N"])) / mp.mpf(DENSITY)
                errors.append(relative(critical, mp.sqrt(held / (1 - mp.mpf(kappa)))))
        for v in {min(critical * (1.0 - less), 1e6) for less in (1e-2, 1e-9, 1e-13)} | {35.0}:
            errors += string_errors(running(v, kappa, PULLED))
    return max(*errors,
               *(beam_error(running(v, kappa, PULLED, bending_stiffness_N_m2=STIFFNESS))
                 for kappa in (1.0 - 1e-3, 1.0 - 1e-9, 1.0) for v in (35.0, 1000.0)))  # fmt: skip


@refusals
def mountings_beyond_constant_force_and_speeds_above_the_critical():
    """At κ = 1 no speed is critical: what holds the string is F_0 ± ΔF/2 at any speed."""
    span = running(np.array([1.0, 1e3, 1e6, 1e9]), 1.0, PULLED, bending_stiffness_N_m2=STIFFNESS)
    for ends in ENDS.values():
        assert np.isinf(span.critical_speed_m_s(ends)).all()
    np.testing.assert_allclose(span.net_tension_N, PRELOAD - 105.475, rtol=1e-15)
    for kappa in (1.0 - 10.0**-k for k in (3, 9, 15)):
        critical = math.sqrt((PRELOAD - 105.475) / (DENSITY * (1.0 - kappa)))
        fast = running(critical * (1.0 + 1e-9), kappa, PULLED)
        said = f"its critical speed is {critical:.9g} m/s".replace("+", r"\+")
        yield partial(string_frequencies_Hz, fast, 1), said
    for kappa in (math.nextafter(1.0, 2.0), 2.0, math.nan):
        call = partial(Span, **PULLED, mounting_factor=kappa)
        yield call, "mounting_factor is .*from 0 to 1"


def spans_all_but_slack():
    """Yield spans whose tension is all but used up; the last kind by inertia that holds up a negative rest."""
    for k in range(3, 16):
        pulled = BLADE | {"pull_N": -PRELOAD * (1.0 - 10.0**-k)}
        yield Span(**pulled)
        yield running(0.5 * math.sqrt((PRELOAD + pulled["pull_N"]) / DENSITY), blade=pulled)
        yield Span(**pulled, mounting_factor=0.9, wheel_speed_m_s=35.0)
        wheels = math.sqrt(900.1 * (1.0 + 10.0**-k) / DENSITY)
        over = BLADE | {"preload_N": 100.0, "pull_N": -1000.1}
        yield Span(**over, mounting_factor=1.0, wheel_speed_m_s=wheels)


@regime("slack tension → 0⁺", 1e-12, f"{STRING}; {CHARACTERISTIC}",
        "tension over preload of 1e-3 … 1e-15, at rest and at half the speed of its waves, with and without "
        "the inertia of the wheels: the frequencies of string and beam")  # fmt: skip
def slack_side():
    """Return the worst error; as the tension goes, the stiffness takes over."""
    stiff = [Span(**STIFF, pull_N=-PRELOAD * (1.0 - 10.0**-k)) for k in (3, 9, 15)]
    strings = [error for span in spans_all_but_slack() for error in string_errors(span)]
    return max(*strings, *map(beam_error, stiff))


@refusals
def blades_without_tension():
    """By name; one that only inertia tightens holds at no speed: its own motion takes all that the wheels give."""
    for more in (0.0, 1e-15, 1e-3, 10.0):
        pull = -math.nextafter(PRELOAD, math.inf) * (1.0 + more) if more else -PRELOAD
        said = (
            "the tension is (-|0 N).*it must be positive: a slack blade is no string.*raise the preload above"
        )
        yield partial(Span, **BLADE, pull_N=pull), said
    for kappa in (0.9, 1.0):
        span = running(100.0, kappa, BLADE | {"preload_N": 100.0, "pull_N": -1000.0})
        assert span.critical_speed_m_s(CLAMPED)[0] == 0.0
        yield partial(string_frequencies_Hz, span, 1), "at 100 m/s and its critical speed is 0 m/s"
    hard_pulled = saw(50.0, 2.0 * PRELOAD)
    yield (
        partial(span_of, assemble(SYSTEM, hard_pulled, SYSTEM.effects), Side.SLACK),
        "the tension is 0 N .*a slack blade is no string",
    )


SPEEDS = (0.0, 0.47, 0.99)


def with_layers(mode, stiffness, speed, ends):
    """Return ω_n to second order in η = ε/√S.

    S n π (1 + 2η + (4 + n²π²(1 + 6V² + V⁴)/2) η²) clamped; pinned without the 2η and the 4. The inner wave numbers
    m ± q have q = nπ + arctan((q + 2m)/κ) + arctan((q − 2m)/κ) between clamps, with layers e^{−κx}, κ → 1/η.
    """
    V = mp.mpf(speed)
    S = 1 - V**2
    eta = mp.sqrt(mp.mpf(stiffness) / S)
    waves = (mode * mp.pi) ** 2 * (1 + 6 * V**2 + V**4) / 2
    turned = 0 if ends.turns else 2 * eta + 4 * eta**2
    return S * mode * mp.pi * (1 + turned + waves * eta**2)


@regime("EI → 0", 1e-12, f"{CHARACTERISTIC}; the string with its boundary layers",
        "EI/(F l²) = 1e-1 … 1e-14 against the characteristic equation, 1e-15 … 5e-324 against the string "
        "with its boundary layers; v/c = 0, 0.47, 0.99, pinned and clamped")  # fmt: skip
def boundary_layer():
    """Return the worst error; the third order of the layers is below 1e-14 from 1e-15 on."""
    errors = []
    for ends in ENDS.values():
        # Every speed and every stiffness for both ends, not all of their product.
        for number, stiffness in enumerate((1e-1, 1e-3, 1e-6, 1e-10, 1e-14)):
            speed = SPEEDS[number % 3]
            found = solve_beam(ScaledBeam.at_speed(stiffness, speed, ends), accuracy=1e-12).frequencies
            truth = beam_frequencies(found[[0, 5]], stiffness, ends, speed=speed)
            errors += [relative(*pair) for pair in zip(found[[0, 5]], truth, strict=True)]
        for speed in SPEEDS:
            for stiffness in (1e-15, 1e-18, 1e-24, 1e-40, 1e-160, 1e-300, 5e-324):
                found = solve_beam(ScaledBeam.at_speed(stiffness, speed, ends), accuracy=1e-12).frequencies
                with mp.workdps(60):
                    truth = [with_layers(n, stiffness, speed, ends) for n in range(1, 7)]
                errors += [relative(*pair) for pair in zip(found, truth, strict=True)]
    return max(errors)


@fact
def an_order_is_as_good_as_foreseen_and_no_waste():
    """Down to a boundary layer of a hundred-thousandth of the span."""
    for ends in ENDS.values():
        for stiffness in (1e-1, 1e-6, 1e-10):
            for speed in SPEEDS:
                _judge_order(ScaledBeam.at_speed(stiffness, speed, ends))


def _judge_order(beam):
    wanted = solve_beam(beam, accuracy=1e-12).frequencies
    assert (np.diff(wanted) > 0.05 * wanted[0]).all()
    for accuracy in (1e-4, 1e-8):
        order = order_for(beam, 6, accuracy)
        found = galerkin_modes(beam, widths_for(beam, order), order, 6).frequencies
        assert np.abs(found / wanted - 1.0).max() < accuracy, beam
        # It is no waste either: four orders less do not suffice, or the layout needs them.
        short = order - 4
        if len(widths_for(beam, short)) == len(widths_for(beam, order)) and short > 9:
            coarse = galerkin_modes(beam, widths_for(beam, short), short, 6).frequencies
            assert np.abs(coarse / wanted - 1.0).max() > accuracy, beam


@refusals
def beams_without_stiffness():
    """A blade of none, or of one of which no float is left, is the string to the last bit."""
    blade = BLADE | {"travel_speed_m_s": 35.0}
    string = string_frequencies_Hz(Span(**blade), 6)
    for ends in ENDS.values():
        np.testing.assert_array_equal(beam_frequencies_Hz(Span(**blade), ends, 6), string)
        faint = beam_frequencies_Hz(Span(**blade, bending_stiffness_N_m2=[1e-30, 1e-300, 5e-324]), ends, 6)
        np.testing.assert_allclose(faint, np.repeat(string, 3, axis=0), rtol=1e-12)
    for stiffness in (-1e-300, math.nan):
        said = "bending_stiffness_N_m2 is .* it must be finite and zero or more"
        yield partial(Span, **BLADE, bending_stiffness_N_m2=stiffness), said


@fact
def blades_of_extreme_data_answer_or_refuse():
    """Never a warning, and no critical speed that is no number."""
    parts = {"free_span_m": 1.6, "linear_density_kg_m": 0.6, "preload_N": 3412.0, "pull_N": 100.0,
             "mounting_factor": 0.5, "wheel_speed_m_s": 35.0, "travel_speed_m_s": 35.0,
             "bending_stiffness_N_m2": 1.06}  # fmt: skip
    rng, answered = np.random.default_rng(13), 0
    for _ in range(80):
        moved = extreme(parts, rng)
        if answer(lambda moved=moved: Span(**moved).tension_N) is None:
            continue
        span = Span(**moved)
        assert not np.isnan(span.critical_speed_m_s(CLAMPED)).any()
        answered += answer(partial(beam_frequencies_Hz, span, CLAMPED, 2)) is not None
        answer(partial(string_frequencies_Hz, span, 2))
        answer(partial(beam_frequencies_Hz, span, PINNED, 2))
    assert answered > 8
    for name in ("pull_N", "travel_speed_m_s"):
        for value in (-1e31, 1e31, 1e160, 1.7e308):
            refused(partial(Span, **parts | {name: value}), f"{name} is .* in SI units")
