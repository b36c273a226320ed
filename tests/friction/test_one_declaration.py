"""A law is one file: what one declaration says is fitted, compared, tested, calculated by hand and reported."""

import numpy as np
import pytest

import ropefric as rf
from ropefric.friction import laws
from ropefric.friction.condition import Conditions
from ropefric.friction.law import FrictionLaw, Parameter, Refusal, with_variant
from ropefric.friction.laws.uniform import CONSTANT


class Logarithmic:
    """ln F_A = ln F_B + μ φ (1 + s ln F_B)."""

    def rise(self, columns, conditions):
        return self.rise_and_slopes(columns, conditions)[0]

    def rise_and_slopes(self, columns, conditions):
        (mu, s), phi, y = columns, conditions.wrap_angle_rad, conditions.log_end_tension
        return mu * phi * (1 + s * y), (phi * (1 + s * y), mu * phi * y)

    def condition_slopes(self, columns, conditions):
        (mu, s), phi, y = columns, conditions.wrap_angle_rad, conditions.log_end_tension
        return np.array(0.0), mu * (1 + s * y), 1 + mu * phi * s

    def refusals(self, columns, _conditions):
        mu, _ = columns
        yield Refusal(mu < 0.0, mu, "the coefficient is {value}, negative", "keep it at zero or more")


def by_hand(sheet):
    sheet.line("mu_F", "mu * (1 + s * y)")
    return sheet.line("mu_F phi", "mu_F * phi")


TOY = FrictionLaw(name="toy", equation="F_A = F_B exp(mu (1 + s ln F_B) phi)", source="nobody",
                  parameters=(Parameter("mu", "-", start=0.2, lower=0.0, upper=5.0,
                                        meaning="coefficient at 1 N"),
                              Parameter("s", "-", start=0.0, lower=-1.0, upper=1.0,
                                        meaning="how it grows with the end tension")),
                  coefficient="average", effects=frozenset({"end-tension"}), physics=Logarithmic(),
                  candidates=lambda mu, _conditions, _log_lift: [[mu, 0.0], [mu, 0.1]],
                  special_cases=(CONSTANT,), arithmetic=by_hand)  # fmt: skip
TRUTH = np.array([0.15, 0.06])


@pytest.fixture
def frame(monkeypatch):
    pd = pytest.importorskip("pandas")
    for registry in (laws.LAWS, laws.ALL_LAWS):
        monkeypatch.setitem(registry._members, "toy", TOY)
    wrap_rad, tension_N = (
        np.repeat(x.ravel(), 3) for x in np.meshgrid([3.0, 6.0, 9.0, 12.0], [5.0, 20.0, 80.0])
    )
    at = Conditions(
        wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=wrap_rad, end_tension_N=tension_N
    )
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(at))
    return pd.DataFrame({"wheel_radius_mm": 40, "rope_diameter_mm": 10, "wrap_angle_rad": wrap_rad,
                         "end_tension_N": tension_N, "peak_N": np.exp(TOY.log_lift(TRUTH, at) + noise)})  # fmt: skip


def test_a_new_law_is_fitted_compared_and_tested_against_its_special_case(frame):
    found = rf.fit(frame, "toy")
    assert found.status.value == "ok"
    assert np.allclose(found.theta, TRUTH, atol=4 * np.sqrt(np.diag(found.covariance)))
    comparison = rf.compare(frame, ["constant", "coupled", "toy"])
    assert comparison.best.law == "toy"
    (test,) = [test for test in comparison.tests if test.fuller == "toy"]
    assert test.simpler == "constant"
    assert test.p_value < 1e-6


def test_a_new_law_is_calculated_by_hand_and_reported(frame, tmp_path, capsys):
    from ropefric.cli.app import main

    table, fit = tmp_path / "trials.csv", tmp_path / "fit.json"
    frame.to_csv(table, index=False)
    assert main(["fit", str(table), "--law", "toy", "--out", str(fit)]) == 0
    assert "toy" in capsys.readouterr().out
    wheel = ["--wheel-radius", "40 mm", "--wrap", "7 rad", "--end-tension", "30 N"]
    assert main(["predict", "--fit", str(fit), *wheel, "--hand"]) == 0
    shown = capsys.readouterr().out
    assert TOY.equation in shown
    assert "mu_F phi = " in shown
    exact, by_hand_N = shown.split("at full precision F_A is ")[1].split()[:5:4]
    assert float(by_hand_N) == pytest.approx(float(exact), rel=1e-7)


def test_a_law_without_arithmetic_says_so():
    from dataclasses import replace

    at = Conditions(wheel_radius_m=0.04, rope_radius_m=0.005, wrap_angle_rad=7.0, end_tension_N=30.0)
    with pytest.raises(ValueError, match="no hand calculation for law toy"):
        replace(TOY, arithmetic=None).calculation(TRUTH, at)


def test_a_variant_is_tested_against_the_variants_of_its_special_cases():
    coupled = laws.LAWS["coupled"]
    names = [case.name for case in coupled.variant.special_cases]
    assert names == ["constant", "size-exponential", "wrap-power-from-zero"]
    with pytest.raises(TypeError):
        with_variant(TOY)
