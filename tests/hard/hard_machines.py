"""A rope on a wheel as a scene assembles it, and a belt press, where stiffness or speed leaves next to nothing."""

import math
from dataclasses import replace
from functools import partial

import hard_truth
import mpmath as mp
import numpy as np
import pytest
from hard_regime import answer, fact, refusals, refused, regime, relative

from ropefric.accuracy.studies.press_transient import INTEGRATORS, LinearStartUp
from ropefric.friction.condition import one_condition
from ropefric.friction.laws import ALL_LAWS
from ropefric.friction.laws.bending import lifted_arc_rad
from ropefric.systems.effect import assemble
from ropefric.systems.friction import WrapFriction
from ropefric.systems.hoist.contact import HoistProblem
from ropefric.systems.hoist.effects import SYSTEM
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.transient.drives import DRIVE_LAWS, press_inputs
from ropefric.systems.press.transient.motion import ElasticPress
from ropefric.systems.press.transient.start_up import start_up

# R² and ρv² = 16 N exactly, so that EI/(2R²) and what is left of F_B are the floats that were meant.
WHEEL, ROPE = 0.1875, 0.0625
RADIUS = WHEEL + ROPE
DENSITY, SPEED = 0.0625, 16.0
CIRCLING = DENSITY * SPEED**2
TENSION, WRAP = 64.0, 9.0
LEFT = {False: TENSION, True: TENSION - CIRCLING}  # what presses and bends, by whether it runs
SHARE = 0.375
ARCS = 2.0 * float(lifted_arc_rad(SHARE))


def rope(*, wrap=WRAP, tension=TENSION, mu=0.2, friction=None, stiffness_N=0.0, moving=False):
    """Return a rope of EI = 2R²E, of a constant coefficient if no friction is given."""
    motion = {"linear_density_kg_m": DENSITY, "speed_m_s": SPEED} if moving else {}
    return HoistProblem(friction=WrapFriction.constant(mu) if friction is None else friction,
                        wheel_radius_m=WHEEL, rope_radius_m=ROPE, wrap_angle_rad=wrap,
                        end_tension_N=tension, bending_stiffness_N_m2=2.0 * RADIUS**2 * stiffness_N,
                        **motion)  # fmt: skip


def lifted(problem):
    """Return the answer with every effect that there are data for."""
    known = [name for name, effect in SYSTEM.effects.items() if not effect.needs(problem)]
    model = assemble(SYSTEM, problem, known)
    return SYSTEM.solve(model, SYSTEM.method(model, 1e-9))


def lift_error(*, mu=0.2, wrap=WRAP, tension=TENSION, stiffness_N=0.0, moving=False):
    """Return how far ln F_A is off: what does not hold the rope on its circle bends it and rubs."""
    found = lifted(rope(mu=mu, wrap=wrap, tension=tension, stiffness_N=stiffness_N, moving=moving)).log_lift[
        0
    ]
    with mp.workdps(60):
        circling = mp.mpf(CIRCLING) if moving else mp.mpf(0)
        F, rise = mp.mpf(tension) - circling, mp.mpf(mu) * mp.mpf(wrap)
        if stiffness_N:
            rigidity = 2 * mp.mpf(RADIUS) ** 2 * mp.mpf(stiffness_N)
            rise = hard_truth.rise("bending", (mu, rigidity), (WHEEL, ROPE, wrap, F))
        return relative(found, mp.log(circling + F * mp.exp(rise)))


HOIST_TRUTH = "the two arcs' equations, solved in 60 digits"


@regime("F_B → ρv²⁺ in a hoist", 1e-12, HOIST_TRUTH,
        "F_B/ρv² − 1 = 1e-3 … 2e-16, without bending stiffness or with half of the largest possible, wraps of "
        "25 and 200 rad: ln F_A as a scene calculates it")  # fmt: skip
def hoist_inertia():
    return max(lift_error(wrap=wrap, tension=CIRCLING * (1.0 + above), stiffness_N=share * CIRCLING * above,
                          moving=True)
               for above in (1e-3, 2.0**-30, 2.0**-52) for share in (0.0, 0.5) for wrap in (25.0, 200.0))  # fmt: skip


@refusals
def hoists_that_lift_off():
    """16 N and a last bit above come back: over e^40 the bit outweighs the rest."""
    bit = 2.0**-52
    found = lifted(rope(wrap=200.0, tension=CIRCLING * (1.0 + bit), moving=True))
    np.testing.assert_allclose(found.lift_force_N, CIRCLING * (1.0 + bit * np.exp(40.0)), rtol=1e-13)
    for stiffness in (0.0, 1.0):
        at_rest = rope(wrap=25.0, tension=CIRCLING, stiffness_N=stiffness, moving=True)
        for speed in (SPEED, np.nextafter(SPEED, 17.0), -17.0, 1e9, 1e30):
            fast = replace(at_rest, speed_m_s=speed)
            yield partial(lifted, fast), "is not below the end tension of 16 N: the rope lifts off the wheel"
    from_reference = WrapFriction(law=ALL_LAWS["wrap-power"], theta=np.array([0.2, -0.5, 0.1]),
                                  reference=one_condition(WHEEL, ROPE, 6.0, 60.0))  # fmt: skip
    barely = rope(wrap=25.0, tension=16.5, friction=from_reference, moving=True)
    yield partial(lifted, barely), "F_B = 0.5 N is below F_0"


@regime("stiff rope", 1e-12, HOIST_TRUTH,
        "a hoist with EI/(2R²) of 1e-3 … 1e-300 F_B and 1e-3 … 1e-16 below F_B, and a wrap 1e-3 … 1e-14 "
        "above the arcs without contact, μ = 0.1 … 3, at rest and running: ln F_A")  # fmt: skip
def stiff_rope():
    ratios = [*(1e-3, 1e-12, 1e-100, 1e-300), *(1.0 - below for below in (2.0**-10, 2.0**-30, 2.0**-53))]
    cases = [(WRAP, ratio) for ratio in ratios]
    for share in (2.0**-20, SHARE, 1.0 - 2.0**-10):
        cases += [(2.0 * float(lifted_arc_rad(share)) * (1 + above), share) for above in (1e-3, 1e-8, 1e-14)]
    return max(lift_error(mu=mu, wrap=wrap, stiffness_N=LEFT[moving] * share, moving=moving)
               for moving in LEFT for mu in (0.1, 3.0) for wrap, share in cases)  # fmt: skip


@refusals
def ropes_that_cannot_follow_or_never_touch():
    """One that hardly touches lifts what pulls it."""
    found = lifted(rope(wrap=ARCS * (1.0 + 1e-14), stiffness_N=SHARE * TENSION))
    assert 0.0 <= found.contact_rad[0] < 1e-13
    assert found.log_lift[0] == pytest.approx(math.log(TENSION), rel=1e-14)
    for moving, left in LEFT.items():
        for more in (0.0, 2.0**-52, 1.0, 1e20):
            stiff = rope(stiffness_N=left * (1.0 + more), moving=moving)
            said = rf"EI/\(2 R\^2\) = .* N is not below the {left:g} N that pull the rope round the wheel"
            yield partial(lifted, stiff), said
        for less in (1e-12, 1e-3, 1.0 - 1e-12):
            off = rope(wrap=ARCS * (1.0 - less), stiffness_N=left * SHARE, moving=moving)
            yield partial(lifted, off), f"is less than the {ARCS:.6g} rad by which this stiff rope lifts off"


@fact
def the_first_of_several_arcs_is_taken_and_where_it_ends_none():
    """Above μ = 3.33 the wrap that an arc needs may fall with it in between; the rope slips at the first."""
    share, mu = 0.99, 30.0

    def first_arc(wrap):
        return lifted(rope(mu=mu, wrap=wrap, stiffness_N=share * TENSION)).contact_rad[0]

    def needed(contact):
        e = mp.mpf(share)
        return contact + mp.acos(1 - e) + mp.acos(1 - e / (e + (1 - e) * mp.exp(mu * contact)))

    with mp.workdps(30):
        top = mp.findroot(lambda contact: mp.diff(needed, contact), 0.04)
        wrap, top = float(needed(top)), float(top)
    assert 0.2 * top < first_arc(wrap * (1.0 - 1e-3)) < top
    assert first_arc(wrap * 1.01) > 2.0 * top
    refused(lambda: first_arc(wrap * (1.0 + 1e-9)), "has no solution: the friction is too high")


EXTREMES = (5e-324, 1e-310, 1e-300, 1e-160, 1e-30, 1e-29, 1e-16, 0.04, 1.0, 20.0, 1e16, 1e29, 1e30, 1e160, 1e300,
            1.7e308)  # fmt: skip


def extreme(parts, rng):
    """Return parts with up to three of them moved to the ends of what floats, or machines, can be."""
    moved = {name: float(rng.choice(EXTREMES)) for name in rng.choice(list(parts), 3)}
    if "mounting_factor" in moved:
        moved["mounting_factor"] = float(rng.choice([0.0, 5e-324, 1.0 - 2.0**-53, 1.0]))
    return parts | moved


@fact
def hoists_of_extreme_data_answer_or_refuse():
    parts = {"wheel_radius_m": 0.04, "rope_radius_m": 0.005, "wrap_angle_rad": 9.0, "end_tension_N": 80.0,
             "speed_m_s": 3.0, "linear_density_kg_m": 0.06, "hanging_length_m": 5.0,
             "bending_stiffness_N_m2": 1e-3}  # fmt: skip
    rng, answered = np.random.default_rng(14), 0
    for mu in (0.2, 1e-300, 1e3):
        friction = WrapFriction.constant(mu)
        for _ in range(50):
            moved = {"friction": friction} | extreme(parts, rng)
            answered += answer(lambda moved=moved: lifted(HoistProblem(**moved)).log_lift) is not None
    assert answered > 15
    for value in (-1e31, 1e31, 1e160, 1.7e308):
        call = partial(HoistProblem, friction=friction, **parts | {"speed_m_s": value})
        refused(call, "speed_m_s is .*, up to 1e30 in SI units")


LOAD_WRAP, DRIVE_WRAP = 2.0, 3.0


def small_press(EA_N, eta_s, load_N_m=20.0):
    take_up = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0, mass_kg=30.0, damping_N_s_m=200.0)
    load = {"squeeze_torque_N_m": load_N_m, "inertia_kg_m2": 0.3}
    rollers = (Roller(name="drive", radius_m=0.1, wrap_angle_rad=DRIVE_WRAP, role="driver"),
               Roller(name="load", radius_m=0.1, wrap_angle_rad=LOAD_WRAP, **load),
               Roller(name="take-up", radius_m=0.08, wrap_angle_rad=3.0, role="tensioner",
                      tensioner=take_up, inertia_kg_m2=0.2))  # fmt: skip
    belt = Belt(name="belt", loop=("drive", "load", "take-up"), linear_density_kg_m=8.0, thickness_m=0.005,
                width_m=1.0, axial_stiffness_N=EA_N, damping_s=eta_s, span_lengths_m=(0.8, 1.0, 1.3))  # fmt: skip
    return Press(rollers=rollers, belts=(belt,), speed_m_s=1.0)


def linear_start(press, speed):
    model = ElasticPress(press)
    return LinearStartUp(model=model, inputs=press_inputs(model.overspeed, speed, "with-speed"))


def tensions(problem, state, time_s):
    return problem.motion.tension_N @ np.concatenate([state, problem.inputs.at(np.array([time_s]))[0]])


def true_tensions(problem, time_s):
    """Return those in the first piece of the drive, by the exponential of the linear motion."""
    n, rows = problem.n_state, problem.motion.derivative
    taylor = problem.inputs.taylor[0]
    powers = taylor.shape[1]
    with mp.workdps(60):
        whole, time = mp.zeros(n + powers), mp.mpf(float(time_s))
        acting = mp.matrix(rows[:, n:].tolist()) * mp.matrix(taylor.tolist())
        for i in range(n):
            for j in range(n):
                whole[i, j] = mp.mpf(float(rows[i, j])) * time
            for j in range(powers):
                whole[i, n + j] = acting[i, j] * time
        for j in range(1, powers):
            whole[n + j, n + j - 1] = time
        halvings = max(0, int(mp.ceil(mp.log(mp.mnorm(whole, 1), 2)))) + 6
        step = whole / mp.mpf(2) ** halvings
        flow, term = mp.eye(n + powers), mp.eye(n + powers)
        for k in range(1, 22):
            term = term * step / k
            flow += term
        for _ in range(halvings):
            flow = flow * flow
        start = mp.matrix([*problem.start.tolist(), 1, *[0] * (powers - 1)])
        return tensions(problem, np.array([float(x) for x in (flow * start)[:n]]), time_s)


@regime("EA → 1e10 N", 1e-8, "the exponential of its motion in 60 digits",
        "a press starting up with EA = 1e6 … 1e10 N and η = 0 … 0.1 s: every tension after 1.3 s")  # fmt: skip
def stiff_belts():
    """Return the worst error of decay rates that lie nine powers of ten apart."""
    speed, worst = DRIVE_LAWS["s-curve"](speed_m_s=1.0, duration_s=2.0), 0.0
    for case in [(1e6, 0.0), (1e8, 1e-3), (1e10, 0.1)]:
        problem = linear_start(small_press(*case), speed)
        true = true_tensions(problem, 1.3)
        for times_s in ([1.3], np.linspace(0.0, 1.3, 131)):
            states = INTEGRATORS["exact"](problem, np.array(times_s))
            found = tensions(problem, states[-1], 1.3)
            worst = max(worst, float((np.abs(found - true) / true).max()))
    return worst


def ratio_over_limit(EA_N, eta_s, mu):
    """Return T'_tight/T'_slack over e^M at the first slip, with q = ρAR²θ''/μ as in eq. (37)."""
    press = small_press(EA_N, eta_s, load_N_m=30.0)
    speed = DRIVE_LAWS["s-curve"](speed_m_s=1.0, duration_s=0.5)
    slip = start_up(press, speed=speed, time_s=[0.0, 0.5], friction=mu).slips[0]
    T = true_tensions(linear_start(press, speed), slip.start_s) - 8.0 * float(speed(slip.start_s)) ** 2
    if slip.roller == "drive":
        wrap, before, behind, way = DRIVE_WRAP, T[2], T[0], -1.0
        acceleration = float(speed.derivative()(slip.start_s))
    else:
        assert slip.roller == "load"
        wrap, before, behind, way = LOAD_WRAP, T[0], T[1], 1.0
        pulling = T[1] - T[0] - 300.0 * float(speed(slip.start_s))
        acceleration = pulling / (0.3 / 0.01 + 8.0 * 0.1 * wrap)
    q = way * 8.0 * 0.1 * wrap * acceleration / (mu * wrap)
    tight, slack = (behind, before) if way > 0 else (before, behind)
    return (tight + q) / (slack + q) / np.exp(mu * wrap)


@regime("slip threshold", 1e-8, "e^M, with the tensions of that exponential",
        "tight over slack tension at the computed start of slip, μ = 0.02 … 0.6, over e^M with the belt's "
        "mass")  # fmt: skip
def slip_threshold():
    cases = [(2e5, 2e-3, 0.02), (2e5, 2e-3, 0.3), (1e7, 1e-3, 0.6), (1e8, 0.1, 0.3)]
    return max(abs(ratio_over_limit(*case) - 1.0) for case in cases)


@regime("slack belts", 1e-5, "the balance of energy; no belt pushes",
        "a press started to full speed at once, EA = 1e5 … 1e7 N, 1e8 N in the long run: the rest in the energy "
        "balance of drive, loads, belts, slip and motion, and the largest force with which a belt pushes")  # fmt: skip
def slack_belts(cases=((1e5, 0.0), (1e7, 1e-3))):
    speed, worst = DRIVE_LAWS["constant"](speed_m_s=1.0), 0.0
    for case in cases:
        times_s = np.linspace(0.0, 0.3, 601)
        found = start_up(small_press(*case), speed=speed, time_s=times_s, friction=0.6)
        assert (found.tension_N == 0.0).sum() > 3, f"no belt goes slack: {case}"
        pushed = max(0.0, -float(found.tension_N.min())) / found.tension_N.max()
        worst = max(worst, found.energy.relative_residual, pushed)
    return worst
