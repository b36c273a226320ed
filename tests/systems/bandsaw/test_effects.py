"""Each effect of a saw changes the frequencies by what its formula says; what a plan leaves out stays in bounds."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from paper import law_of
from scipy.optimize import brentq

from ropefric.errors import InputError
from ropefric.scenes.plan import make_plan
from ropefric.systems.bandsaw.answer import SawProblem
from ropefric.systems.bandsaw.beam import ScaledBeam, solve_beam
from ropefric.systems.bandsaw.effects import SYSTEM
from ropefric.systems.bandsaw.effects import bending_bound as bound_of
from ropefric.systems.bandsaw.saw import STEEL_85_09, Side
from ropefric.systems.bandsaw.span import CLAMPED, PINNED
from ropefric.systems.effect import Method, assemble
from ropefric.systems.friction import WrapFriction

T, S, R = Side.TIGHT, Side.SLACK, Side.REST
NAMES = ("tension-difference", "wheel-inertia-tension", "travel", "bending", "torsion")

# The saw of Wang and Jiang.
LENGTH, RHO, PRELOAD, PULL = 1.6, 0.5967, 3412.0, 210.95
OMEGA, RADIUS = 970.0 * math.pi / 30.0, 0.35
SPEED = OMEGA * RADIUS


@pytest.fixture(scope="module")
def full_problem(stiffness):
    """The printed saw with data for every effect."""
    return SawProblem(free_span_m=LENGTH, linear_density_kg_m=RHO, preload_N=PRELOAD, n_modes=4,
                      wheel_radius_m=RADIUS, wheel_speed_rad_s=OMEGA, tension_difference_N=PULL,
                      mounting_factor=0.4, bending_stiffness_N_m2=stiffness, section=STEEL_85_09)  # fmt: skip


def solved(problem, effects, *, accuracy=1e-10):
    method = Method(name="as asked", settings={"accuracy": accuracy}, error=accuracy, why="")
    return SYSTEM.solve(assemble(SYSTEM, problem, effects), method)


def string_Hz(tension_N, speed_m_s=0.0, n_modes=4):
    """Eqs. (7), (8): f_n = n (c² − v²)/(2 l c)."""
    c = math.sqrt(tension_N / RHO)
    return np.arange(1.0, n_modes + 1.0) * (c**2 - speed_m_s**2) / (2.0 * LENGTH * c)


def test_the_string_is_eq_8_with_the_tension_that_the_effects_give(full_problem):
    for effects, pull, kappa, speed in [
        ([], 0.0, 0.0, 0.0),
        (["tension-difference"], 1.0, 0.0, 0.0),  # eqs. (16), (17)
        (["wheel-inertia-tension"], 0.0, 0.4, 0.0),  # eqs. (13)-(15), and κ of them
        (["travel"], 0.0, 0.0, 1.0),  # eq. (8)
        (["tension-difference", "wheel-inertia-tension", "travel"], 1.0, 0.4, 1.0),
    ]:
        answer = solved(full_problem, effects)
        for side in (T, S):
            tension_N = PRELOAD + side.sign * pull * 0.5 * PULL + kappa * RHO * SPEED**2
            found = answer.sides[side]
            assert found.tension_N[0] == pytest.approx(tension_N, rel=1e-14), effects
            wanted_Hz = string_Hz(tension_N, speed * SPEED)
            assert found.frequencies_Hz[0] == pytest.approx(wanted_Hz, rel=1e-13), effects
        assert answer.sides[R].frequencies_Hz[0] == pytest.approx(string_Hz(PRELOAD), rel=1e-14), effects


def test_torsion_adds_its_frequencies_and_changes_no_other(full_problem):
    without, with_it = solved(full_problem, ["travel"]), solved(full_problem, ["travel", "torsion"])
    assert SYSTEM.distance(without, with_it, with_it) == 0.0
    assert without.sides[T].torsion_Hz is None
    section = full_problem.section
    slender, wave = section.thickness_m / section.width_m, section.shear_modulus_Pa / section.density_kg_m3
    c_t = math.sqrt(PRELOAD / RHO + 4.0 * wave * slender**2)
    for side, speed in ((T, SPEED), (R, 0.0)):
        wanted = np.arange(1, 5) * (c_t**2 - speed**2) / (2.0 * LENGTH * c_t)
        assert with_it.sides[side].torsion_Hz[0] == pytest.approx(wanted, rel=1e-12)
    assert with_it.sides[R].torsion_Hz[0, 0] == pytest.approx(31.69, abs=0.005)


def test_all_effects_are_the_moving_beam_under_the_sum_of_the_tensions(full_problem, stiffness):
    answer = solved(full_problem, NAMES)
    for side in Side:
        runs = 0.0 if side is R else 1.0
        tension_N = PRELOAD + side.sign * 0.5 * PULL + runs * 0.4 * RHO * SPEED**2
        c = math.sqrt(tension_N / RHO)
        beam = ScaledBeam.at_speed(stiffness / (tension_N * LENGTH**2), runs * SPEED / c, CLAMPED)
        wanted = solve_beam(beam, 4, accuracy=1e-12).frequencies * c / (2.0 * math.pi * LENGTH)
        assert answer.sides[side].frequencies_Hz[0] == pytest.approx(wanted, rel=1e-9)


def test_the_wheels_grip_is_counted_from_what_the_slack_side_presses(full_problem):
    """U = ΔF/((F_slack − ρAv²)(e^M − 1)), M of a power law by its integral from the slack side's angle."""
    a, b, c = 0.15, -0.4, 0.05
    friction = law_of("wrap-power", [a, b, c], (0.35, 4.5e-4, 3.0, 100.0))
    answer = solved(replace(full_problem, friction=friction), ["tension-difference", "travel"])
    slack_N = PRELOAD - 0.5 * PULL - RHO * SPEED**2

    def integral(phi):
        return a * phi ** (b + 1.0) / (b + 1.0) + c * phi

    start = brentq(lambda phi: integral(phi) - math.log(slack_N), 1e-6, 1e3)
    wanted = PULL / (slack_N * math.expm1(integral(start + math.pi) - integral(start)))
    assert answer.wheel_utilisation[0] == pytest.approx(wanted, rel=1e-9)


def test_a_tiny_pull_keeps_its_digits(full_problem):
    one = replace(full_problem, friction=WrapFriction.constant(0.2), tension_difference_N=2e-10)
    use = solved(one, ["tension-difference", "wheel-inertia-tension"]).wheel_utilisation[0]
    slack_N = PRELOAD + 0.4 * RHO * SPEED**2
    assert use == pytest.approx(2e-10 / (slack_N * math.expm1(0.2 * math.pi)), rel=1e-12)


def test_an_effect_without_its_data_names_the_key(full_problem):
    for name, field, key in [("tension-difference", "tension_difference_N", "drive.power"),
                             ("wheel-inertia-tension", "mounting_factor", "tension.mounting_factor"),
                             ("travel", "wheel_speed_rad_s", "wheel.speed"),
                             ("bending", "bending_stiffness_N_m2", "blade.bending_stiffness"),
                             ("torsion", "section", "blade.width")]:  # fmt: skip
        lacking = replace(full_problem, **{field: None})
        plan, _ = make_plan(SYSTEM, lacking, accuracy=0.01, effects="all")
        assert next(one for one in plan.decisions if one.name == name).fate == "not applicable", name
        with pytest.raises(InputError, match=rf"{name} cannot be simulated without {key}"):
            make_plan(SYSTEM, lacking, accuracy=0.01, effects=(name,))


def test_what_is_left_out_is_not_evaluated(full_problem):
    plan, model = make_plan(SYSTEM, full_problem, accuracy=0.1, effects="auto")
    assert plan.left_out == ("bending",), "nothing else takes time"
    assert plan.method.name == "closed form"
    other = replace(full_problem, bending_stiffness_N_m2=7.0 * full_problem.bending_stiffness_N_m2)
    again = SYSTEM.solve(assemble(SYSTEM, other, plan.simulated), plan.method)
    wanted_Hz = SYSTEM.solve(model, plan.method).sides[T].frequencies_Hz
    assert np.array_equal(again.sides[T].frequencies_Hz, wanted_Hz)


# --- how far bending can go ---


@cache
def shifts(ends, e, V, n_modes):
    """ln of the beam's frequencies over the string's at the same V = v/c, e = √(EI/F l²)."""
    frequencies = solve_beam(ScaledBeam.at_speed(e**2, V, ends), n_modes, accuracy=1e-9).frequencies
    return np.log(frequencies / (np.arange(1.0, n_modes + 1.0) * math.pi * (1.0 - V**2)))


def bending_bound(ends, e, V, n_modes):
    scaled = SawProblem(free_span_m=1.0, linear_density_kg_m=1.0, preload_N=1.0, n_modes=n_modes,
                        wheel_radius_m=1.0, wheel_speed_rad_s=V, bending_stiffness_N_m2=e**2, ends=ends)  # fmt: skip
    return float(bound_of(scaled).max())


def test_bending_stays_below_its_bound():
    for ends in [PINNED, CLAMPED]:
        for e in [1e-4, 0.01, 0.1, 0.3]:
            for V in [0.0, 0.7, 0.98]:
                found = shifts(ends, e, V, 10)
                assert found.min() > -2e-9
                for n in range(1, 11):
                    assert found[:n].max() <= bending_bound(ends, e, V, n) + 2e-9, (ends, e, V, n)


def test_the_bound_of_bending_is_the_stiffness_itself_for_thin_blades():
    """To first order in what bends a free end, and in the layer at a held one: nothing is given away."""
    for ends in [PINNED, CLAMPED]:
        for V in [0.0, 0.5, 0.9]:
            assert shifts(ends, 1e-4, V, 3)[2] == pytest.approx(bending_bound(ends, 1e-4, V, 3), rel=2e-3)


def test_bending_whose_layers_fill_the_span_has_no_bound():
    assert math.isinf(bending_bound(CLAMPED, 0.5, 0.0, 1))
    assert math.isinf(bending_bound(CLAMPED, 0.05, 0.999, 1))
