"""What every law in the registry promises, and the limits in which laws become each other."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.fit import guess
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS, LAWS
from ropefric.testing import check_law, typical, varied

CONTRACT = ["constant", "constant-offset", "size-power", "size-exponential", "wrap-average",
            "wrap-exponential", "wrap-power", "coupled", "thickness", "bending", "howell", "groove"]  # fmt: skip
EVERY_LAW = pytest.mark.parametrize("law", list(ALL_LAWS.values()), ids=lambda law: law.name)
EULER = Conditions(
    wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[1.0, 5.0, 20.0], end_tension_N=20
)


def test_names_are_the_contract():
    assert list(LAWS) == CONTRACT
    assert LAWS["coupled"].parameter_names == ("mu_inf", "a", "b", "c", "d")
    with pytest.raises(UnknownNameError, match="did you mean 'wrap-power'"):
        LAWS["wrap_power"]


@EVERY_LAW
def test_a_law_keeps_what_is_asked_of_a_plugins(law):
    check_law(law)


def some_sets(law, m, seed=4):
    return typical(law) * np.random.default_rng(seed).uniform(0.7, 1.0, (m, len(law.parameters)))


def test_many_sets_have_many_rows_and_the_same_rise_alone_or_with_slopes_also_at_no_wrap(plan):
    zero = varied(plan, wrap_angle_rad=np.where(plan.wrap_angle_rad > 10.0, 0.0, plan.wrap_angle_rad))
    for law in ALL_LAWS.values():
        sets, p = some_sets(law, 6), len(law.parameters)
        if law.admissible(sets, zero).all():
            together, alone = law.log_lift_and_jacobian(sets, zero)[0], law.log_lift(sets, zero)
            assert np.array_equal(together, alone), law.name
        assert law.log_lift(sets[0], plan).shape == (216,)
        assert law.jacobian(sets, plan).shape == (6, 216, p)
        coefficients = law.log_lift_gradient_conditions(sets, plan)[..., 1], law.average_mu(sets, plan)
        assert [one.shape for one in coefficients] == [(6, 216)] * 2
        assert law.admissible(sets, plan).all()
        assert law.validity(sets, plan) == ()


def test_the_local_coefficient_is_the_slope_of_ln_f_and_the_average_one_its_mean(plan):
    h = 1e-5
    for law in ALL_LAWS.values():
        theta = typical(law)
        local = law.log_lift_gradient_conditions(theta, plan)[:, 1]
        beyond, before = (
            law.log_lift(theta, varied(plan, wrap_angle_rad=(1 + sign * h) * plan.wrap_angle_rad))
            for sign in (1, -1)
        )
        slope = (beyond - before) / (2 * h * plan.wrap_angle_rad)
        np.testing.assert_allclose(local, slope, rtol=1e-7, atol=1e-8, err_msg=law.name)
        rise = law.log_lift(theta, plan) - plan.log_end_tension
        average = law.average_mu(theta, plan) * plan.wrap_angle_rad
        np.testing.assert_allclose(average, rise, rtol=1e-12, atol=1e-14, err_msg=law.name)
        with pytest.raises(InputError, match="no average coefficient over a wrap of zero"):
            law.average_mu(theta, varied(plan, wrap_angle_rad=0.0))


def test_start_values_are_within_the_bounds_and_near_also_of_poor_data(plan):
    """Of one pull or four alike, of whatever force; and those of clean or noisy data find the truth."""
    some = plan.select(np.arange(0, len(plan), 5))
    for law in ALL_LAWS.values():
        for wraps, rise in (([3.0], 0.5), ([3.0], 40.0), ([3.0] * 4, 0.0), ([3.0] * 4, -0.5)):
            pulls = varied(EULER.select([0] * len(wraps)), wrap_angle_rad=wraps)
            found = guess(law, pulls, pulls.log_end_tension + rise)
            assert (np.isfinite(found) & (law.lower <= found) & (found <= law.upper)).all(), law.name
        fixed = [parameter.fixed for parameter in law.parameters]
        truth = law.log_lift(np.where(fixed, typical(law), some_sets(law, 1)[0]), some)
        rough = guess(law, some, truth + np.random.default_rng(4).normal(0, 0.017, len(some)))
        assert np.abs(law.log_lift(rough, some) - truth).max() < 0.1, law.name


def test_together_is_refused_where_only_the_slope_has_no_answer():
    law, pull = LAWS["wrap-power"], varied(EULER, wrap_angle_rad=300.0)
    theta = [5e-12, -0.999, 0.0]
    assert np.isfinite(law.log_lift(theta, pull)).all()
    with pytest.raises(InputError, match="wrap-power: no finite value at condition 0"):
        law.log_lift_and_jacobian(theta, pull)


def test_guess_stays_where_the_law_has_slopes():
    """Frictionless data over hundreds of radians draw it into the corner of the bounds where a slope overflows."""
    law = LAWS["wrap-power"]
    pulls = varied(EULER.select([0, 1]), wrap_angle_rad=[60.0, 300.0], end_tension_N=[300.0, 1.0])
    found = guess(law, pulls, pulls.log_end_tension - np.array([0.0, 1.0]))
    assert np.isfinite(law.jacobian(found, pulls)).all()


def test_bad_theta_is_refused(plan):
    for law in ALL_LAWS.values():
        p = len(law.parameters)
        for question in (law.log_lift, law.log_lift_and_jacobian):
            with pytest.raises(InputError, match=r"theta has shape"):
                question(np.zeros(p + 1), plan)
        with pytest.raises(InputError, match="not finite"):
            law.log_lift(np.full(p, np.nan), plan)
        with pytest.raises(InputError, match="not an array of numbers"):
            law.log_lift(["a"] * p, plan)
        with pytest.raises(UnknownNameError, match="no parameter 'nu'"):
            law.theta_from({"nu": 1.0})
        with pytest.raises(InputError, match="no value for"):
            law.theta_from({})
        assert law.theta_from(law.as_mapping(typical(law))).tolist() == typical(law).tolist()


A_LAW = st.sampled_from(list(ALL_LAWS.values()))


@settings(deadline=None, max_examples=60)
@given(law=A_LAW, data=st.data())
def test_anything_gives_a_number_or_a_reason(law, data):
    """Inside and outside the bounds: finite answers or InputError, and no warning, anywhere."""
    wild = st.floats(-1e3, 1e3) | st.sampled_from([0.0, 1e308, -1e308])
    wide = [data.draw(st.floats(p.lower, p.upper) | wild) for p in law.parameters]
    pulls = Conditions(wheel_radius_m=data.draw(st.floats(1e-6, 1e6)),
                       rope_radius_m=data.draw(st.floats(1e-6, 1e6)),
                       wrap_angle_rad=data.draw(st.just(0.0) | st.floats(1e-300, 1e4)),
                       end_tension_N=data.draw(st.just(1.0) | st.floats(1e-3, 1e9)))  # fmt: skip
    reasons = law.validity(wide, pulls)
    assert bool(law.admissible(wide, pulls)) == (not reasons)
    for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions):
        try:
            assert np.isfinite(question(wide, pulls)).all()
            assert not reasons
        except InputError:
            pass


@settings(deadline=None, max_examples=60)
@given(law=A_LAW.filter(lambda law: law.name != "bending"), data=st.data())  # a stiff rope may not touch
def test_inside_the_bounds_every_ordinary_pull_has_an_answer(law, data):
    # A coefficient of 5e-324 is no ordinary one: see the test after this.
    theta = [data.draw(st.floats(p.lower, p.upper, allow_subnormal=False)) for p in law.parameters]
    if law.name != "constant-offset":
        assume(max(theta) > 1e-3)
    pulls = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[0.5, 9.0], end_tension_N=20)
    if law.validity(theta, pulls):
        assert "μ is zero everywhere" in law.validity(theta, pulls)[0]
    else:
        assert np.isfinite(law.log_lift(theta, pulls)).all()


def test_a_coefficient_too_small_for_any_end_tension_is_refused():
    """Without the size effect only d is left, and F_B = 20 N stands for a wrap of ln(20)/5e-324: no float."""
    pulls = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[0.5, 9.0], end_tension_N=20)
    with pytest.raises(InputError, match="a parameter is so large or small"):
        ALL_LAWS["coupled"].log_lift([5.0, 0.0, 0.0, -0.999, 5e-324], pulls)


def test_refusals_name_the_condition(plan):
    light = varied(plan, end_tension_N=np.where(np.arange(216) == 7, 0.5, 20.0))
    for name in ("wrap-power", "wrap-exponential", "coupled"):
        law = LAWS[name]
        with pytest.raises(
            InputError, match=r"F_B = 0.5 N is below F_0 = 1 N.*at condition 7 .*ends in -from-zero"
        ):
            law.log_lift(typical(law), light)
        assert np.isfinite(law.variant.log_lift(typical(law), light)).all()
        assert law.admissible(np.stack([typical(law)] * 2), light).tolist() == [False, False]
    with pytest.raises(InputError, match=r"negative: a R_w/R_r \+ b is above 0 there.*at condition 0"):
        LAWS["coupled"].log_lift([0.2, -0.1, 1.0, -0.4, 0.1], plan)
    with pytest.raises(InputError, match=r"e\^\(a r \+ b\) > 1"):
        LAWS["size-exponential"].log_lift([0.2, -0.1, 1.0], plan)
    with pytest.raises(InputError, match=r"diverges for k <= -1"):
        LAWS["wrap-power"].log_lift([0.2, -1.0, 0.1], plan)
    with pytest.raises(InputError, match=r"parameter set 1"):
        LAWS["wrap-power"].log_lift([[0.2, -0.5, 0.1], [0.2, -1.2, 0.1]], plan)
    with pytest.raises(InputError, match="keep it at zero or below"):
        LAWS["wrap-exponential"].log_lift([0.2, 0.5, 0.1], plan)
    with pytest.raises(InputError, match="never reaches"):
        LAWS["wrap-exponential"].log_lift([0.1, -0.5, 0.0], plan)
    with pytest.raises(InputError, match=r"cannot bend the rope round the wheel at condition 0"):
        LAWS["bending"].log_lift([0.2, 1.0], plan)
    with pytest.raises(InputError, match="too stiff to touch"):
        LAWS["bending"].log_lift([0.2, 1e-3], plan)
    with pytest.raises(InputError, match=r"n > 1 the tension is infinite"):
        LAWS["howell"].log_lift([0.5, 1.5], plan)
    with pytest.raises(InputError, match="infinite where the wrap starts from nothing"):
        LAWS["wrap-power"].log_lift_gradient_conditions(
            [0.2, -0.5, 0.1], varied(EULER, wrap_angle_rad=0.0, end_tension_N=1.0)
        )
