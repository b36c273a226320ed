"""What every law in the registry promises, and the limits in which laws become each other."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ropefric.errors import InputError, UnknownNameError
from ropefric.fitting.fit import guess
from ropefric.friction.condition import Conditions
from ropefric.friction.laws import ALL_LAWS, LAWS

CONTRACT = [
    "constant", "constant-offset", "size-power", "size-exponential", "wrap-exponential", "wrap-power", "coupled",
    "thickness", "bending", "howell", "groove",
]  # fmt: skip
EVERY_LAW = pytest.mark.parametrize("law", list(ALL_LAWS.values()), ids=lambda law: law.name)
EULER = Conditions(
    wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[1.0, 5.0, 20.0], end_tension_N=20
)


def typical(law):
    return np.array([parameter.start for parameter in law.parameters])


def some_sets(law, rng, m=6):
    return typical(law) * rng.uniform(0.7, 1.0, (m, len(law.parameters)))


def varied(conditions, **changes):
    names = ("wheel_radius_m", "rope_radius_m", "wrap_angle_rad", "end_tension_N")
    return Conditions(**{name: getattr(conditions, name) for name in names} | changes)


def derivative(function, step):
    """Fourth-order central difference."""
    near, far = function(step) - function(-step), function(2 * step) - function(-2 * step)
    return (8 * near - far) / (12 * step)


def test_names_are_the_contract():
    assert list(LAWS) == CONTRACT
    assert LAWS["coupled"].parameter_names == ("mu_inf", "a", "b", "c", "d")
    with pytest.raises(UnknownNameError, match="did you mean 'wrap-power'"):
        LAWS["wrap_power"]


@EVERY_LAW
def test_declaration_is_whole(law):
    assert law.equation
    assert law.source
    assert law.coefficient in {"local", "average"}
    for parameter in law.parameters:
        assert parameter.lower <= parameter.start <= parameter.upper
        assert parameter.meaning
        assert parameter.unit
    mapping = law.as_mapping(typical(law))
    assert law.theta_from(mapping).tolist() == typical(law).tolist()
    assert ("end-tension" in law.effects) <= (law.coefficient == "local")


@EVERY_LAW
def test_many_sets_are_a_loop_over_one(law, plan):
    sets = some_sets(law, np.random.default_rng(1))
    for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions, law.average_mu):
        together = question(sets, plan)
        one_by_one = np.stack([question(theta, plan) for theta in sets])
        assert together.shape == one_by_one.shape
        assert np.allclose(together, one_by_one, rtol=1e-13, atol=1e-15)
    assert law.log_lift(sets, plan).shape == (6, 216)
    assert law.jacobian(sets, plan).shape == (6, 216, len(law.parameters))
    assert law.local_mu(sets, plan.wrap_angle_rad, plan).shape == (6, 216)
    assert law.admissible(sets, plan).tolist() == [True] * 6
    assert law.admissible(sets[0], plan)
    assert law.validity(sets, plan) == ()


@EVERY_LAW
def test_lift_and_jacobian_together_are_the_two_alone(law, plan):
    """To the last bit: a fit must not depend on which of them it asked. Bending alone refuses a wrap of zero."""
    zero = varied(plan, wrap_angle_rad=np.where(plan.wrap_angle_rad > 10.0, 0.0, plan.wrap_angle_rad))
    sets = some_sets(law, np.random.default_rng(5))
    for conditions in (plan, zero) if law.admissible(sets, zero).all() else (plan,):
        for theta in (sets, sets[0]):
            log_lift, jacobian = law.log_lift_and_jacobian(theta, conditions)
            assert np.array_equal(log_lift, law.log_lift(theta, conditions))
            assert np.array_equal(jacobian, law.jacobian(theta, conditions))
    with pytest.raises(InputError, match="theta has shape"):
        law.log_lift_and_jacobian(sets[:, 1:], plan)


def test_together_is_refused_where_only_the_slope_has_no_answer():
    law, pull = LAWS["wrap-power"], varied(EULER, wrap_angle_rad=300.0)
    theta = [5e-12, -0.999, 0.0]
    assert np.isfinite(law.log_lift(theta, pull)).all()
    with pytest.raises(InputError, match="wrap-power: no finite value at condition 0"):
        law.log_lift_and_jacobian(theta, pull)


@EVERY_LAW
def test_jacobian_is_the_derivative(law, plan):
    for theta in some_sets(law, np.random.default_rng(2)):
        found = law.jacobian(theta, plan)
        for i in range(len(theta)):
            unit = np.eye(len(theta))[i]
            step = 3e-4 * (abs(theta[i]) or 1e-2)
            truth = derivative(lambda h, unit=unit, theta=theta: law.log_lift(theta + h * unit, plan), step)
            assert np.allclose(found[:, i], truth, rtol=1e-7, atol=1e-8 * np.abs(truth).max())


@EVERY_LAW
def test_gradient_by_conditions_is_the_derivative(law, plan):
    for theta in some_sets(law, np.random.default_rng(3), m=2):
        found = law.log_lift_gradient_conditions(theta, plan)
        for column, name in enumerate(["wheel_radius_m", "wrap_angle_rad", "end_tension_N"]):
            base = getattr(plan, name)

            def lift(h, name=name, base=base, theta=theta):
                return law.log_lift(theta, varied(plan, **{name: base * np.exp(h)}))

            by_log = derivative(lift, 1e-3)
            truth = by_log if name == "end_tension_N" else by_log / base
            assert np.allclose(found[:, column], truth, rtol=1e-7, atol=1e-8 * max(np.abs(truth).max(), 1e-3))


@EVERY_LAW
def test_more_wrap_or_load_lifts_more(law, plan):
    theta = typical(law)
    base = law.log_lift(theta, plan)
    assert (law.log_lift(theta, varied(plan, wrap_angle_rad=plan.wrap_angle_rad * 1.1)) > base).all()
    assert (law.log_lift(theta, varied(plan, end_tension_N=plan.end_tension_N * 1.1)) > base).all()
    assert (base >= plan.log_end_tension).all()


@EVERY_LAW
def test_local_and_average_coefficient_belong_together(law, plan):
    """The local one is the slope of ln F along the wrap, whatever the wrap of the conditions it is asked for."""
    theta, h = typical(law), 1e-5
    local = law.local_mu(theta, plan.wrap_angle_rad, varied(plan, wrap_angle_rad=1.0))
    beyond, before = (
        law.log_lift(theta, varied(plan, wrap_angle_rad=(1 + sign * h) * plan.wrap_angle_rad))
        for sign in (1, -1)
    )
    assert np.allclose(local, (beyond - before) / (2 * h * plan.wrap_angle_rad), rtol=1e-7)
    rise = law.log_lift(theta, plan) - plan.log_end_tension
    assert np.allclose(law.average_mu(theta, plan) * plan.wrap_angle_rad, rise, rtol=1e-12, atol=1e-14)
    with pytest.raises(InputError, match="no average coefficient over a wrap of zero at condition 0"):
        law.average_mu(theta, varied(plan, wrap_angle_rad=0.0))


@EVERY_LAW
def test_guess_is_inside_the_bounds_and_finds_clean_truth(law, plan):
    rng = np.random.default_rng(4)
    fixed = [parameter.fixed for parameter in law.parameters]
    for theta in np.where(fixed, typical(law), some_sets(law, rng, m=3)):
        found = guess(law, plan, law.log_lift(theta, plan))
        assert (law.lower <= found).all()
        assert (found <= law.upper).all()
        assert np.allclose(found, theta, rtol=0.02, atol=1e-3)
        noisy = guess(law, plan, law.log_lift(theta, plan) + rng.normal(0, 0.017, len(plan)))
        assert np.abs(law.log_lift(noisy, plan) - law.log_lift(theta, plan)).max() < 0.1


@EVERY_LAW
def test_guess_survives_poor_data(law):
    one = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=3.0, end_tension_N=20)
    same = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=[3.0] * 4, end_tension_N=20)
    for pulls in (one, same):
        for rise in (0.5, 0.0, -0.5, 40.0):
            found = guess(law, pulls, pulls.log_end_tension + rise)
            assert np.isfinite(found).all()
            assert (law.lower <= found).all()
            assert (found <= law.upper).all()


def test_guess_stays_where_the_law_has_slopes():
    """Frictionless data over hundreds of radians draw it into the corner of the bounds where a slope overflows."""
    law = LAWS["wrap-power"]
    pulls = varied(EULER.select([0, 1]), wrap_angle_rad=[60.0, 300.0], end_tension_N=[300.0, 1.0])
    found = guess(law, pulls, pulls.log_end_tension - np.array([0.0, 1.0]))
    assert np.isfinite(law.jacobian(found, pulls)).all()


@EVERY_LAW
def test_bad_theta_is_refused(law, plan):
    p = len(law.parameters)
    with pytest.raises(InputError, match=r"theta has shape"):
        law.log_lift(np.zeros(p + 1), plan)
    with pytest.raises(InputError, match="not finite"):
        law.log_lift(np.full(p, np.nan), plan)
    with pytest.raises(InputError, match="not an array of numbers"):
        law.log_lift(["a"] * p, plan)
    with pytest.raises(UnknownNameError, match="no parameter 'nu'"):
        law.theta_from({"nu": 1.0})
    with pytest.raises(InputError, match="no value for"):
        law.theta_from({})


@pytest.mark.parametrize("name", ALL_LAWS)
@settings(deadline=None, max_examples=40)
@given(data=st.data())
def test_anything_gives_a_number_or_a_reason(name, data):
    """Inside and outside the bounds: finite answers or InputError, and no warning, anywhere."""
    law = ALL_LAWS[name]
    wide = [
        data.draw(
            st.one_of(
                st.floats(p.lower, p.upper), st.floats(-1e3, 1e3), st.sampled_from([0.0, 1e308, -1e308])
            )
        )
        for p in law.parameters
    ]
    pulls = Conditions(
        wheel_radius_m=data.draw(st.floats(1e-6, 1e6)),
        rope_radius_m=data.draw(st.floats(1e-6, 1e6)),
        wrap_angle_rad=data.draw(st.one_of(st.just(0.0), st.floats(1e-300, 1e4))),
        end_tension_N=data.draw(st.one_of(st.just(1.0), st.floats(1e-3, 1e9))),
    )
    reasons = law.validity(wide, pulls)
    assert bool(law.admissible(wide, pulls)) == (not reasons)
    for question in (law.log_lift, law.jacobian, law.log_lift_gradient_conditions):
        try:
            assert np.isfinite(question(wide, pulls)).all()
            assert not reasons
        except InputError:
            pass


@pytest.mark.parametrize(
    "name", [name for name in ALL_LAWS if name != "bending"]
)  # a stiff rope may not touch
@settings(deadline=None, max_examples=25)
@given(data=st.data())
def test_inside_the_bounds_every_ordinary_pull_has_an_answer(name, data):
    law = ALL_LAWS[name]
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
            InputError, match=r"F_B = 0.5 N is below F_0 = 1 N.*at condition 7 .*without_end_tension"
        ):
            law.log_lift(typical(law), light)
        assert np.isfinite(law.without_end_tension().log_lift(typical(law), light)).all()
        assert law.admissible(np.stack([typical(law)] * 2), light).tolist() == [False, False]
    with pytest.raises(InputError, match=r"negative: a R_w/R_r \+ b is above 0 there.*at condition 0"):
        LAWS["coupled"].log_lift([0.2, -0.1, 1.0, -0.4, 0.1], plan)
    with pytest.raises(InputError, match=r"e\^\(a r \+ b\) > 1"):
        LAWS["size-exponential"].log_lift([0.2, -0.1, 1.0], plan)
    with pytest.raises(InputError, match=r"diverges for k <= -1"):
        LAWS["wrap-power"].log_lift([0.2, -1.0, 0.1], plan)
    with pytest.raises(InputError, match=r"parameter set 1"):
        LAWS["wrap-power"].log_lift([[0.2, -0.5, 0.1], [0.2, -1.2, 0.1]], plan)
    with pytest.raises(InputError, match="never reaches"):
        LAWS["wrap-exponential"].log_lift([0.1, -0.5, 0.0], plan)
    with pytest.raises(InputError, match=r"cannot bend the rope round the wheel at condition 0"):
        LAWS["bending"].log_lift([0.2, 1.0], plan)
    with pytest.raises(InputError, match="too stiff to touch"):
        LAWS["bending"].log_lift([0.2, 1e-3], plan)
    with pytest.raises(InputError, match=r"n > 1 the tension is infinite"):
        LAWS["howell"].log_lift([0.5, 1.5], plan)
    with pytest.raises(InputError, match="does not count an end tension"):
        LAWS["constant"].without_end_tension()
    with pytest.raises(InputError, match="infinite where the wrap starts from nothing"):
        LAWS["wrap-power"].log_lift_gradient_conditions(
            [0.2, -0.5, 0.1], varied(EULER, wrap_angle_rad=0.0, end_tension_N=1.0)
        )
