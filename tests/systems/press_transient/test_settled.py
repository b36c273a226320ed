"""Where a start-up leads: the state its history leaves, and what creep makes of it; friction that follows tension."""

from dataclasses import replace

import numpy as np
import pytest
from paper import density_on_rollers, law_of

from ropefric.systems.press.slip import SlipTable
from ropefric.systems.press.transient.motion import ElasticPress, friction_limit, settled, settled_press
from ropefric.systems.press.transient.start_up import start_up

LAW = law_of("wrap-power", [1.2, -0.4, 0.1], (0.1, 0.0025, 2.0, 500.0))


@pytest.fixture(scope="module")
def press(kit):
    """Damped enough to settle in some seconds."""
    return kit.paper(eta_s=2e-2, C1=1e4, load=0.3, force_N=3000.0)


def settling(kit, press, mu):
    """Return a start-up that ends in the steady run."""
    times_s = np.linspace(0.0, 40.0, 41)
    return start_up(press, speed=kit.run_up("ramp", duration_s=0.3), time_s=times_s, friction=mu)


@pytest.mark.parametrize(("mu", "slipped"), [(1.2, set()), (0.45, {"10"})])
def test_a_start_up_settles_where_it_says_slips_on_the_way_included(kit, press, mu, slipped):
    found = settling(kit, press, mu)
    assert set(found.summary()["first_slip_s"]) >= slipped
    assert bool(found.slips) == bool(slipped)
    assert not any(found.summary()["at_end"].values())
    np.testing.assert_allclose(found.tension_N[-1], found.settled.tension_N, rtol=1e-6)
    unslipped = settled(ElasticPress(press), kit.speed_m_s).tension_N
    assert (np.abs(found.settled.tension_N / unslipped - 1.0).max() > 1e-3) == bool(slipped)


@pytest.mark.slow
def test_what_still_slips_or_stands_at_the_end_settles_nowhere(kit):
    found = start_up(
        kit.paper(force_N=1100.0), speed=kit.run_up(), time_s=np.linspace(0.0, 4.0, 41), friction=0.2
    )
    assert found.settled is None
    ends = found.summary()["at_end"]
    assert ends["1"] == ends["10"] == "slips"
    assert ends["9"] == "stands"


@pytest.mark.parametrize("force_N", [1300.0, pytest.param(2000.0, marks=pytest.mark.slow)])
def test_friction_that_follows_the_tensions_ends_at_the_steady_measure(kit, force_N):
    """The utilisation at the end is that of the law at the tensions there, in the roller that slips as well."""
    press = kit.paper(eta_s=1e-2, force_N=force_N)
    question = {"speed": kit.run_up(duration_s=1.5), "time_s": np.linspace(0.0, 2.5, 251), "friction": LAW}
    found, frozen = (start_up(press, follows=follows, **question) for follows in (True, False))
    T = found.tension_N[-1] - press.density_kg_m * kit.speed_m_s**2
    steady = SlipTable(press, T, LAW).utilisation
    assert steady[1] == pytest.approx(1.0, abs=2e-4), "roller 2 slips"
    np.testing.assert_allclose(found.utilisation[-1], steady, rtol=2e-4, atol=1e-5)
    T = frozen.tension_N[-1] - press.density_kg_m * kit.speed_m_s**2
    assert abs(SlipTable(press, T, LAW).utilisation[1] - 1.0) > 0.02, "friction as it is at standstill"
    assert found.energy.relative_residual < 1e-5


def test_the_tangent_of_friction_is_that_of_the_law(kit):
    model = ElasticPress(kit.paper())
    slack_N = np.linspace(300.0, 3000.0, 26).reshape(2, 13)
    limit = friction_limit(model, LAW, slack_N=slack_N)

    def pull_N(at_N):
        contacts = SlipTable(model.press, model.preload_N, LAW).contacts
        return at_N * np.exp(contacts._replace(upstream_N=at_N, downstream_N=at_N).exponent(LAW))

    np.testing.assert_allclose(limit.growth * slack_N + limit.offset_N, pull_N(slack_N), rtol=1e-12)
    h = 1e-4 * slack_N
    np.testing.assert_allclose(
        limit.growth, (pull_N(slack_N + h) - pull_N(slack_N - h)) / (2.0 * h), rtol=1e-3
    )
    for side in (np.exp(limit.width), np.exp(-limit.width)):
        off = limit.growth * slack_N * side + limit.offset_N
        assert np.abs(off / pull_N(slack_N * side) - 1.0).max() < 1e-3


def test_a_law_that_looks_at_no_tension_has_nothing_to_follow(kit):
    question = {"speed": kit.run_up("ramp", 1.0, 0.3), "time_s": np.linspace(0.0, 0.5, 26), "friction": 0.2}
    one, other = (start_up(kit.small(), follows=follows, **question) for follows in (True, False))
    np.testing.assert_array_equal(one.tension_N, other.tension_N)


def test_where_a_press_settles_needs_neither_its_start_up_nor_its_masses(kit, press):
    found = settling(kit, press, 1.2)
    bare = tuple(
        replace(one, inertia_kg_m2=None, tensioner=one.tensioner and replace(one.tensioner, mass_kg=None))
        for one in press.rollers
    )
    ends = settled_press(replace(press, rollers=bare), kit.speed_m_s)
    np.testing.assert_allclose(ends.tension_N, found.tension_N[-1], rtol=1e-6)
    np.testing.assert_allclose(ends.relative_way_m / press.radius_m, found.relative_angle_rad[-1], atol=1e-8)
    np.testing.assert_allclose(ends.travel_m, found.travel_m[-1], atol=1e-8)
    # By hand: what every span is longer by is its part of the turning and the travels.
    stretch_m = -press.incidence.T @ ends.relative_way_m - press.pull.T @ (ends.travel_m - 0.03)
    model = ElasticPress(press)
    np.testing.assert_allclose(ends.tension_N - model.preload_N, model.stiffness_N_m * stretch_m, rtol=1e-9)


def test_the_factor_of_eq_37_over_a_start_up(kit, press):
    """By hand from the tensions, and with the acceleration of the smooth run-up: (37), and (38) at its end."""
    mu, times = 1.2, np.linspace(0.0, 40.0, 4001)
    found = start_up(press, speed=kit.run_up("s-curve", duration_s=2.0), time_s=times, friction=mu)
    density = density_on_rollers(press)
    rims = found.roller_speed_rad_s * press.radius_m
    momentum_N = rims[:, :1] ** 2 * press.density_kg_m
    sides_N = [(found.tension_N - momentum_N) @ side.T for side in (press.into, press.out_of)]
    added_N = density * press.radius_m * np.gradient(rims, times, axis=0, edge_order=2) / mu
    growth = np.expm1(mu * np.array([one.wrap_angle_rad for one in press.rollers]))
    by_hand = (sides_N[0] + added_N) / ((sides_N[1] + added_N) * growth)
    np.testing.assert_allclose(found.as_printed[5:], by_hand[5:], rtol=2e-3)
    steady = SlipTable(press, found.settled.tension_N - kit.speed_m_s**2 * press.density_kg_m, mu).as_printed
    np.testing.assert_allclose(found.as_printed[-1], steady, rtol=1e-6)
    of_roller, of_span = found.summary()["peak_as_printed"], found.press.spans[0].name
    assert of_roller["2"] == found.as_printed[:, 1].max()
    ends = [found.summary()[name][of_span] for name in ("lowest_tension_N", "peak_tension_N")]
    assert ends == [found.tension_N[:, 0].min(), found.tension_N[:, 0].max()]
