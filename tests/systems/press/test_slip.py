"""Slip: the paper's factor and its inversion, and measures that are 1 exactly where friction ends."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ropefric.errors import InputError, UnknownNameError
from ropefric.friction.condition import Conditions, one_condition
from ropefric.friction.laws import LAWS
from ropefric.systems.friction import WrapFriction
from ropefric.systems.press.critical import sweep_press
from ropefric.systems.press.slip import (
    MEASURES,
    Contact,
    contacts_of,
    slip_table,
    steady_contacts,
    utilisation,
)
from ropefric.systems.press.statics import solve_statics
from ropefric.systems.press.steady import steady_state

MEASURED = ("as_printed", "as_plotted", "utilisation", "log", "mu_required")
# belt_press.md, section 4: 50 rpm, 2000 N, μ = 1.2, closure "share".
TABLE = {
    "1": (0.0627, 0.0098, 0.03787, 0.24892, 0.2987),
    "2": (0.8715, 1.7869, 0.53901, 0.61003, 0.7320),
    "3": (0.0260, 0.0440, 0.01020, 0.07708, 0.0925),
    "4": (1.2479, 1.2479, 0, 0, 0),
    "5": (0.3904, 0.4932, 0.05439, 0.09840, 0.1181),
    "6": (0.0645, 0.0707, 0.00316, 0.01657, 0.0199),
    "7": (0.0371, 0.0405, 0.00173, 0.01330, 0.0160),
    "8": (0.0461, 0.0501, 0.00205, 0.01359, 0.0163),
    "9": (0.1674, 0.1814, 0.00715, 0.02107, 0.0253),
    "10": (0.3033, 0.1628, 0.08111, 0.18254, 0.2190),
    "11": (0.2327, 0.2327, 0, 0, 0),
    "12": (0.3535, 0.3535, 0, 0, 0),
    "13": (0.0740, 0.0796, 0.00283, 0.01371, 0.0165),
}
DECIMALS = (4, 4, 5, 5, 4)


@pytest.fixture(scope="module")
def paper_slip(paper_press, paper_data):
    return slip_table(steady_contacts(steady_state(solve_statics(paper_press))), paper_data["mu"])


@pytest.mark.parametrize("roller", TABLE)
def test_the_table_to_its_printed_digits(paper_slip, roller):
    for name, wanted, decimals in zip(MEASURED, TABLE[roller], DECIMALS, strict=True):
        assert float(paper_slip.of(roller, name)) == pytest.approx(wanted, abs=0.51 * 10.0**-decimals), name


def test_no_roller_slips_and_roller_2_is_nearest(paper_slip):
    assert (paper_slip.utilisation < 1.0).all()
    assert paper_slip.rollers[int(np.argmax(paper_slip.utilisation))] == "2"


def test_measures_are_described_and_misses_are_named(paper_slip):
    assert set(MEASURES) == set(MEASURED)
    with pytest.raises(UnknownNameError, match="no measure 'margin' of a roller '2'"):
        paper_slip.of("2", "margin")
    with pytest.raises(UnknownNameError, match="roller '20'"):
        paper_slip.of("20")


# --- what the paper says of its figures ------------------------------------------------------------------


@pytest.fixture(scope="module")
def trends(paper_press, paper_data):
    statics = solve_statics(paper_press)
    preload = sweep_press(statics, paper_data["mu"], preload_N=np.linspace(1500, 4000, 11))
    speed = sweep_press(statics, paper_data["mu"], speed_m_s=2 * np.pi / 60 * 0.175 * np.linspace(0, 100, 11))
    return preload, speed


@pytest.mark.parametrize("roller", ["2", "5"])
def test_the_inverted_ratio_follows_the_text(trends, roller):
    """Λ2 and Λ5 fall with preload and rise with speed."""
    preload, speed = trends
    assert (np.diff(preload.slip.of(roller, "as_plotted")[:, 0]) < 0).all()
    assert (np.diff(speed.slip.of(roller, "as_plotted")[0]) > 0).all()


@pytest.mark.parametrize("roller", ["2", "5"])
def test_the_printed_ratio_contradicts_the_text(trends, roller):
    """(38) as printed rises with preload and falls with speed on the very rollers of figures 6 and 7."""
    preload, speed = trends
    assert (np.diff(preload.slip.of(roller, "as_printed")[:, 0]) > 0).all()
    assert (np.diff(speed.slip.of(roller, "as_printed")[0]) < 0).all()


def test_only_the_inverted_ratio_lets_rollers_2_and_4_exceed_one(trends):
    above = {
        name: {roller for roller in TABLE if (trends[1].slip.of(roller, name) > 1.0).any()}
        for name in ("as_printed", "as_plotted")
    }
    assert above == {"as_plotted": {"2", "4"}, "as_printed": {"4"}}


def test_the_rollers_called_small_are_the_smallest_as_plotted(paper_slip):
    order = [paper_slip.rollers[i] for i in np.argsort(paper_slip.as_plotted)]
    assert set(order[:6]) == {"1", "3", "6", "7", "8", "13"}
    printed = [paper_slip.rollers[i] for i in np.argsort(paper_slip.as_printed)]
    assert set(printed[:6]) == {"1", "3", "6", "7", "8", "13"}  # the statement does not tell the two apart


def test_unloaded_rollers_keep_their_printed_factor(trends):
    """Λ4, Λ11 and Λ12 are constant, which says that (38) is not 0 without torque."""
    for roller in ("4", "11", "12"):
        factor = trends[1].slip.of(roller, "as_plotted")[0]
        np.testing.assert_allclose(factor, factor[0], rtol=1e-12)
        assert factor[0] > 0.2
        np.testing.assert_allclose(trends[1].slip.of(roller), 0.0, atol=1e-12)


def test_tensions_fall_only_slightly_with_speed(trends):
    falling = trends[1].effective_tension_N[0]
    assert (np.diff(falling, axis=0) < 0).all()
    assert ((falling[0] - falling[-1]) / falling[0] < 0.065).all()


# --- exactly 1 at the limit ------------------------------------------------------------------------------


class Element:
    """The belt element dT/dφ = ρAR²θ̈ − F with F at its greatest everywhere, integrated directly."""

    def __init__(self, mu, alpha, inertia_N):
        self.mu, self.alpha, self.inertia_N = mu, alpha, inertia_N

    def driven(self, slack_N):
        """Friction brakes the belt; the slack side comes first and the angle counts from there."""
        return self.solve(lambda s, T: self.inertia_N + self.mu(s) * T, slack_N)

    def driver(self, slack_N):
        """Friction pushes the belt; seen from the slack side, against the travel, inertia counts negative."""
        return self.solve(lambda s, T: -self.inertia_N + self.mu(s) * T, slack_N)

    def solve(self, slope, slack_N):
        run = solve_ivp(slope, (0.0, self.alpha), [slack_N], method="DOP853", rtol=1e-13, atol=1e-12)
        return run.y[0, -1]


def contact(*, role, slack_N, tight_N, alpha, inertia_N=0.0, R=0.2):
    upstream, downstream = (slack_N, tight_N) if role == "driven" else (tight_N, slack_N)
    return Contact(
        roller="x", radius_m=R, wrap_angle_rad=alpha, half_thickness_m=0.0025,
        upstream_N=np.array(upstream), downstream_N=np.array(downstream), inertia_N=inertia_N,
    )  # fmt: skip


def law_friction(b, *, a=0.5, c=0.1):
    return WrapFriction(
        law=LAWS["wrap-power"], theta=np.array([a, b, c]), reference=one_condition(0.2, 0.0025, 2.0, 500.0)
    )


def local_mu(friction, slack_N):
    """Return μ(s) of the law by the derivative of its own ∫μ, high above the accuracy asked for."""
    law, theta = friction.law, friction.theta
    a, b, c = theta
    # φ0 from ∫₀^φ0 μ = ln F_B, independent of the package.
    phi0 = float(mpmath.findroot(lambda p: a * p ** (b + 1) / (b + 1) + c * p - mpmath.log(slack_N), 5.0))
    at = Conditions(wheel_radius_m=0.2, rope_radius_m=0.0025, wrap_angle_rad=1.0, end_tension_N=slack_N)
    assert float(law.local_mu(theta, 0.0, at)[0]) == pytest.approx(a * phi0**b + c)
    return lambda s: a * (phi0 + s) ** b + c


@pytest.mark.parametrize("role", ["driven", "driver"])
@pytest.mark.parametrize("inertia_N", [0.0, 3.0, -3.0, 60.0])
@pytest.mark.parametrize("alpha", [0.5, 2.5, 5.0])
def test_utilisation_is_one_at_the_limit_of_constant_friction(role, inertia_N, alpha):
    mu, slack_N = 0.8, 500.0
    tight_N = getattr(Element(lambda s: mu, alpha, inertia_N), role)(slack_N)
    q = inertia_N / mu if role == "driven" else -inertia_N / mu
    assert tight_N == pytest.approx(
        (slack_N + q) * np.exp(mu * alpha) - q, rel=1e-12
    )  # the page's closed form
    table = slip_table(
        [contact(role=role, slack_N=slack_N, tight_N=tight_N, alpha=alpha, inertia_N=inertia_N)], mu
    )
    assert float(table.utilisation[0]) == pytest.approx(1.0, abs=1e-12)
    assert float(table.log[0]) == pytest.approx(1.0, abs=1e-12)
    assert float(table.mu_required[0]) == pytest.approx(mu, abs=1e-12)


@pytest.mark.parametrize("role", ["driven", "driver"])
@pytest.mark.parametrize("inertia_N", [0.0, 3.0, -3.0, 60.0])
@pytest.mark.parametrize(("alpha", "b"), [(0.5, -0.5), (2.5, -0.3), (5.0, -0.8)])
def test_utilisation_is_one_at_the_limit_of_wrap_dependent_friction(role, inertia_N, alpha, b):
    friction, slack_N = law_friction(b), 500.0
    tight_N = getattr(Element(local_mu(friction, slack_N), alpha, inertia_N), role)(slack_N)
    table = slip_table(
        [contact(role=role, slack_N=slack_N, tight_N=tight_N, alpha=alpha, inertia_N=inertia_N)], friction
    )
    assert float(table.utilisation[0]) == pytest.approx(1.0, abs=1e-12)
    assert float(table.log[0]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("b", [-0.3, -0.7, -0.95])
def test_the_integral_of_inertia_is_exact_where_the_coefficient_is_steep(b):
    """With a slack side of 1 N the wrap counts from zero, where μ = a φ^b is infinite."""
    friction, alpha, inertia_N = law_friction(b, a=0.2, c=0.05), 2.0, 5.0
    a, c = 0.2, 0.05

    def M(s):
        return a * s ** (b + 1) / (b + 1) + c * s

    with mpmath.workdps(30):
        swell = (
            mpmath.quad(lambda u: 20 * u**19 * mpmath.exp(M(alpha) - M(alpha * u**20)), [0, 0.5, 1]) * alpha
        )
        tight_N = float(mpmath.exp(M(alpha)) + inertia_N * swell)
    found = utilisation(
        [contact(role="driven", slack_N=1.0, tight_N=tight_N, alpha=alpha, inertia_N=inertia_N)], friction
    )
    assert float(found[0]) == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("role", ["driven", "driver"])
def test_a_belt_that_only_accelerates_itself_needs_no_friction(role):
    inertia_N, alpha = 8.0, 2.0
    end_N = 500.0 + inertia_N * alpha
    part = contact(
        role="driven" if role == "driven" else "driver",
        slack_N=500.0 if role == "driven" else end_N,
        tight_N=end_N if role == "driven" else 500.0,
        alpha=alpha,
        inertia_N=inertia_N,
    )
    table = slip_table([part], 0.8)
    assert float(table.utilisation[0]) == pytest.approx(0.0, abs=1e-12)
    assert float(table.log[0]) == pytest.approx(0.0, abs=1e-12)


def test_acceleration_is_continuous_at_zero(paper_press):
    state = steady_state(solve_statics(paper_press))
    still = slip_table(steady_contacts(state), 1.2)
    slow = slip_table(steady_contacts(state, angular_acceleration_rad_s2=1e-9), 1.2)
    for name in MEASURED:
        np.testing.assert_allclose(getattr(slow, name), getattr(still, name), atol=1e-9)


def test_the_printed_acceleration_term_is_that_of_a_driven_roller(paper_press):
    """(37): both tensions plus ρAR²θ̈/μ."""
    state = steady_state(solve_statics(paper_press))
    spin = 5.0
    table = slip_table(steady_contacts(state, angular_acceleration_rad_s2=spin), 1.2)
    q = 15.0 * 0.075**2 * spin / 1.2
    T1, T2 = float(state.effective("1")), float(state.effective("2"))
    wanted = (T1 + q) / ((T2 + q) * np.expm1(1.2 * np.radians(28.1)))
    assert float(table.of("2", "as_printed")) == pytest.approx(wanted, rel=1e-12)


def test_two_belts_on_a_roller_accelerate_twice_the_mass(paper_press):
    state = steady_state(solve_statics(paper_press))
    inertia = {
        part.roller: part.inertia_N for part in steady_contacts(state, angular_acceleration_rad_s2=2.0)
    }
    assert float(inertia["2"]) == pytest.approx(15 * 0.075**2 * 2)
    assert float(inertia["6"]) == pytest.approx(30 * 0.2**2 * 2)


def test_tensions_of_a_transient_are_read_the_same_way(paper_press):
    """T with its rim speeds gives the contacts of T'."""
    state = steady_state(solve_statics(paper_press), speed_m_s=[1.0, 3.0])
    rim = np.array([[1.0], [3.0]])
    for one, other in zip(
        steady_contacts(state), contacts_of(paper_press, state.tension_N, rim_speed_m_s=rim), strict=True
    ):
        np.testing.assert_allclose(one.upstream_N, other.upstream_N, rtol=1e-12)
        np.testing.assert_allclose(one.downstream_N, other.downstream_N, rtol=1e-12)
    with pytest.raises(InputError, match="13,"):
        contacts_of(paper_press, np.zeros(13))
    with pytest.raises(InputError, match="tension_N must be finite"):
        contacts_of(paper_press, np.full(14, np.nan))


# --- friction laws ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("theta", [(1.1, 0.0, 0.1), (1.1, -1e-10, 0.1), (0.0, -0.5, 1.2), (1e-12, -0.5, 1.2)])
def test_a_law_that_hardly_depends_on_the_wrap_is_a_constant(paper_press, paper_slip, theta):
    """b → 0 or a → 0."""
    friction = replace(law_friction(-0.5), theta=np.array(theta))
    table = slip_table(steady_contacts(steady_state(solve_statics(paper_press))), friction)
    for name in MEASURED:
        np.testing.assert_allclose(getattr(table, name), getattr(paper_slip, name), rtol=1e-8, atol=1e-12)


def test_a_law_sees_radius_thickness_and_slack_tension_of_each_roller(paper_press):
    law, theta = LAWS["coupled"], np.array([0.4, -0.02, -0.3, -0.4, 0.1])
    friction = WrapFriction(law=law, theta=theta, reference=one_condition(0.1, 0.0025, 2.0, 500.0))
    contacts = steady_contacts(steady_state(solve_statics(paper_press)))
    found = slip_table(contacts, friction).exponent
    slack = [min(float(part.upstream_N), float(part.downstream_N)) for part in contacts]
    at = Conditions(
        wheel_radius_m=np.array([roller.radius_m for roller in paper_press.rollers]),
        rope_radius_m=0.0025,
        wrap_angle_rad=np.array([roller.wrap_angle_rad for roller in paper_press.rollers]),
        end_tension_N=np.array(slack),
    )
    np.testing.assert_allclose(found, law.log_lift(theta, at) - np.log(slack), rtol=1e-12)


def test_blocks_of_points_are_the_points(paper_press):
    statics = solve_statics(paper_press)
    preload = np.linspace(1500, 3000, 70_001)
    whole = utilisation(steady_contacts(steady_state(statics, preload_N=preload)), 1.2)
    assert whole.shape == (70_001, 13)
    some = [0, 32767, 32768, 65536, 70_000]
    part = utilisation(steady_contacts(steady_state(statics, preload_N=preload[some])), 1.2)
    np.testing.assert_array_equal(whole[some], part)


@pytest.mark.parametrize("spin", [0.0, 4.0])
def test_each_point_can_have_its_own_coefficient(paper_press, spin):
    mu, preload = np.array([[0.8], [1.0], [1.2]]), np.array([1800.0, 2500.0])
    state = steady_state(solve_statics(paper_press), preload_N=preload)
    contacts = steady_contacts(state, angular_acceleration_rad_s2=spin)
    table = slip_table(contacts, mu)
    np.testing.assert_allclose(utilisation(contacts, mu), table.utilisation, rtol=1e-14, atol=1e-15)
    for i, each in enumerate(mu.ravel()):
        for name in MEASURED:
            np.testing.assert_allclose(
                getattr(table, name)[i], getattr(slip_table(contacts, each), name), rtol=1e-12, atol=1e-15
            )


@pytest.mark.parametrize("mu", [0.0, -1.0, float("nan"), float("inf")])
def test_a_coefficient_is_positive(paper_press, mu):
    with pytest.raises(InputError, match="friction coefficient"):
        utilisation(steady_contacts(steady_state(solve_statics(paper_press))), mu)


def test_a_law_without_friction_is_refused(paper_press):
    contacts = steady_contacts(steady_state(solve_statics(paper_press)))
    friction = WrapFriction(
        law=LAWS["constant"], theta=np.array([0.0]), reference=one_condition(0.2, 0.0025, 2.0, 500.0)
    )
    with pytest.raises(InputError, match="roller 1: there is no friction at all"):
        utilisation(contacts, friction)


def test_a_belt_that_lifts_off_has_no_grip(paper_press):
    state = steady_state(solve_statics(paper_press), preload_N=[100.0, 2000.0], on_slack="flag")
    for spin in (0.0, 1.0):
        table = slip_table(steady_contacts(state, angular_acceleration_rad_s2=spin), 1.2)
        for name in ("utilisation", "log", "mu_required"):
            values = getattr(table, name)
            assert np.isinf(values[0, :2]).all()  # span 1 is slack: rollers 1 and 2
            assert np.isfinite(values[0, 2:]).all()
            assert np.isfinite(values[1]).all()


# --- tendencies ------------------------------------------------------------------------------------------

PROVABLE = st.sampled_from(["share", "equal-torque"])


@given(
    closure=PROVABLE,
    mu=st.floats(0.05, 2.0),
    speed_m_s=st.floats(0.0, 4.0),
    load=st.floats(0.01, 1.2),
    preload_N=st.floats(1600.0, 5000.0),
    more=st.floats(1.0, 3000.0),
)
@settings(max_examples=40, deadline=None)
def test_more_preload_never_raises_utilisation(paper_press, *, closure, mu, speed_m_s, load, preload_N, more):
    """Constant μ, all tensioners together, closures that split by the loads alone; see `utilisation`."""
    state = steady_state(
        solve_statics(paper_press, closure=closure),
        preload_N=[preload_N, preload_N + more],
        speed_m_s=speed_m_s,
        load_factor=load,
        on_slack="flag",
    )
    less, tighter = utilisation(steady_contacts(state), mu)
    assert (tighter <= less * (1 + 1e-12) + 1e-12).all()


@given(
    closure=PROVABLE,
    mu=st.floats(0.05, 2.0),
    speed_m_s=st.floats(0.0, 4.0),
    load=st.floats(0.01, 1.0),
    more=st.floats(1e-3, 0.4),
    preload_N=st.floats(1600.0, 5000.0),
)
@settings(max_examples=40, deadline=None)
def test_more_load_never_lowers_utilisation(paper_press, *, closure, mu, speed_m_s, load, more, preload_N):
    """Constant μ and one factor on all loads."""
    state = steady_state(
        solve_statics(paper_press, closure=closure),
        preload_N=preload_N,
        speed_m_s=speed_m_s,
        load_factor=[load, load + more],
        on_slack="flag",
    )
    less, heavier = utilisation(steady_contacts(state), mu)
    assert (heavier >= less * (1 - 1e-12) - 1e-12).all()


def test_outside_that_domain_it_does_not_hold(paper_press):
    """One load alone tightens another roller's slack side; `equal` moves load between the drivers; μ may fall."""
    rollers = tuple(replace(r, gravity_torque_N_m=60.0) if r.name == "3" else r for r in paper_press.rollers)
    heavier = utilisation(
        steady_contacts(steady_state(solve_statics(replace(paper_press, rollers=rollers)))), 1.2
    )
    base = utilisation(steady_contacts(steady_state(solve_statics(paper_press))), 1.2)
    assert heavier[4] < base[4]
    equal = solve_statics(paper_press, closure="equal")
    one, other = utilisation(
        steady_contacts(steady_state(equal, preload_N={"3": np.array([2000.0, 3000.0])})), 1.2
    )
    assert other[9] > one[9]
    friction = law_friction(-0.9, a=0.5, c=0.0)
    state = steady_state(solve_statics(paper_press), preload_N=[2000.0, 4000.0])
    less, tighter = utilisation(steady_contacts(state), friction)
    loaded = np.array([float(value) > 0.0 for *_, value in TABLE.values()])
    assert (tighter > less)[loaded].any()
