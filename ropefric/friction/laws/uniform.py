"""Laws of a coefficient that is the same all along the wrap: constant, with an offset, in a groove, by size.

Eqs. (2) to (4) of the PRTH paper, the V-groove, and a rope of finite thickness.
"""

from collections.abc import Callable, Iterable

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.friction import law
from ropefric.friction.condition import Conditions
from ropefric.friction.law import Columns, FrictionLaw, Parameter, Sheet, Slopes


class Uniform:
    """The physics of a coefficient that depends on the parameters and the size of the wheel alone.

    Local and average coefficient are the same. This one is the first parameter itself, whatever the wheel; others say
    what theirs is.
    """

    why_negative = "friction cannot push the rope forward"

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        return columns[0] + 0.0 * conditions.wrap_angle_rad

    def mu_slopes(self, _columns: Columns, _conditions: Conditions) -> Slopes:
        """Return its derivative by each parameter that it depends on."""
        return (np.array(1.0),)

    def mu_by_radius(self, _columns: Columns, _conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        return np.array(0.0)

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ."""
        return self.mu(columns, conditions) * conditions.wrap_angle_rad

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return μ φ and ∂μ φ by each parameter."""
        slopes = tuple(slope * conditions.wrap_angle_rad for slope in self.mu_slopes(columns, conditions))
        return self.rise(columns, conditions), slopes

    def condition_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂ ln F_A by R_w, φ and ln F_B."""
        by_radius = self.mu_by_radius(columns, conditions) * conditions.wrap_angle_rad
        return by_radius, self.mu(columns, conditions), np.array(1.0)

    def refusals(self, columns: Columns, conditions: Conditions) -> Iterable[law.Refusal]:
        """Yield where μ is negative."""
        what = f"the coefficient is {{value}}, negative: {self.why_negative}"
        fix = "change the parameters, or leave out these conditions"
        yield law.negative(self.mu(columns, conditions), what, fix)


def mu_times_wrap(*lines: tuple[str, ...]) -> Callable[[Sheet], float]:
    """Return what writes the lines that end in mu, and the rise mu makes."""

    def by_hand(sheet: Sheet) -> float:
        for line in lines:
            sheet.line(*line)
        return sheet.line("mu phi", "mu * phi")

    return by_hand


CONSTANT = FrictionLaw(
    name="constant",
    equation="F_A = F_B exp(mu phi)",
    source="Euler's capstan equation; PRTH friction and lift-force model, eq. (2)",
    parameters=(Parameter("mu", "-", 0.2, 0.0, 5.0, "friction coefficient"),),
    coefficient="average",
    effects=frozenset(),
    weakens=True,
    physics=Uniform(),
    candidates=lambda mu, _at, _log_lift: [[mu]],
    arithmetic=mu_times_wrap(),
)


class Offset(Uniform):
    """The physics of ln F_A = ln F_B + μ φ + k: a bearing's friction, a cell's gain error.

    The average coefficient over the wrap is μ + k/φ, which is a wrap effect with exponent −1 to the eye; the
    local one is μ. k may have either sign.
    """

    def rise(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ φ + k."""
        return columns[0] * conditions.wrap_angle_rad + columns[1]

    def rise_and_slopes(self, columns: Columns, conditions: Conditions) -> tuple[FloatArray, Slopes]:
        """Return μ φ + k and ∂ by μ and k."""
        return self.rise(columns, conditions), (conditions.wrap_angle_rad, np.array(1.0))


CONSTANT_OFFSET = FrictionLaw(
    name="constant-offset",
    equation="F_A = F_B exp(mu phi + k)",
    source="eq. (2) with a constant in ln F",
    parameters=(
        Parameter("mu", "-", 0.2, 0.0, 5.0, "friction coefficient; local"),
        Parameter("k", "-", 0.0, -5.0, 5.0,
                  "offset of ln F_A: bearing friction or a gain error, the same at every wrap"),
    ),
    coefficient="local",
    effects=frozenset({"offset"}),
    physics=Offset(),
    candidates=lambda mu, _at, _log_lift: [[mu, 0.0]],
    special_cases=(CONSTANT,),
    arithmetic=lambda sheet: sheet.line("mu phi + k", "mu * phi + k"),
)  # fmt: skip


class PowerSize(Uniform):
    """The physics of μ = μ∞ (R_w/(R_w + R_r))^a + b: it grows with the wheel as a power."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        mu_inf, a, b = columns
        return mu_inf * np.exp(a * _log_share(conditions)) + b

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        mu_inf, a, _b = columns
        share = _log_share(conditions)
        power = np.exp(a * share)
        return power, mu_inf * power * share, np.array(1.0)

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        mu_inf, a, _b = columns
        # d ln(R_w/(R_w + R_r))/dR_w = R_r/(R_w (R_w + R_r)), written so that neither a product of radii nor the
        # power by itself underflows
        by_wheel = np.exp(a * _log_share(conditions) - np.log(conditions.wheel_radius_m))
        return mu_inf * a * by_wheel / (1.0 + conditions.size_ratio)


def _log_share(conditions: Conditions) -> FloatArray:
    """Return ln(R_w/(R_w + R_r)), without loss for very large wheels."""
    return -np.log1p(1.0 / conditions.size_ratio)


SIZE_POWER = FrictionLaw(
    name="size-power",
    equation="mu = mu_inf (R_w/(R_w + R_r))^a + b; F_A = F_B exp(mu phi)",
    source="PRTH friction and lift-force model, eq. (3)",
    parameters=(
        Parameter("mu_inf", "-", 0.2, 0.0, 5.0,
                  "part of μ that grows with the wheel; only mu_inf + b and mu_inf a are seen for large wheels"),
        Parameter("a", "-", 1.0, 0.0, 50.0, "exponent of the size effect"),
        Parameter("b", "-", 0.02, 0.0, 5.0, "part of μ that the wheel leaves alone"),
    ),
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=PowerSize(),
    candidates=lambda mu, _at, _log_lift: law.combinations(
        mu * np.array([0.5, 1.0, 1.5]), [0.3, 1.0, 3.0, 10.0], mu * np.array([0.02, 0.3, 0.8])
    ),
    special_cases=(CONSTANT,),
    arithmetic=mu_times_wrap(("R_w/(R_r + R_w)", "R_w/(R_r + R_w)", "share"), ("mu", "mu_inf * share^a + b")),
)  # fmt: skip


class ExponentialSize(Uniform):
    """The physics of μ_R = μ∞ (1 − e^{a r + b}) of the first three parameters, eq. (4).

    It approaches that of a very large wheel exponentially in r = R_w/R_r.
    """

    why_negative = "a R_w/R_r + b is above 0 there, so e^(a r + b) > 1"

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return μ_R = μ∞ (1 − e^{a r + b}) of the first three columns, eq. (4)."""
        mu_inf, a, b = columns[:3]
        return -mu_inf * np.expm1(a * conditions.size_ratio + b)

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return ∂μ_R by μ∞, a and b."""
        mu_inf, a, b = columns[:3]
        r = conditions.size_ratio
        exponent = a * r + b
        by_b = -mu_inf * np.exp(exponent)
        return -np.expm1(exponent), r * by_b, by_b

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return ∂μ_R/∂R_w [1/m]."""
        mu_inf, a, b = columns[:3]
        return -mu_inf * a * np.exp(a * conditions.size_ratio + b) / conditions.rope_radius_m


def size_candidates(conditions: Conditions) -> tuple[FloatArray, FloatArray]:
    """Return start values of a and b for these wheels."""
    r = float(np.median(conditions.size_ratio))
    return np.array([-4.0, -1.5, -0.5, -0.15]) / r, np.array([-3.0, -1.0, -0.2])


MU_R = "mu_inf * (1 - exp(a * r + b))"

SIZE_EXPONENTIAL = FrictionLaw(
    name="size-exponential",
    equation="mu = mu_inf (1 - exp(a R_w/R_r + b)); F_A = F_B exp(mu phi)",
    source="PRTH friction and lift-force model, eq. (4)",
    parameters=(
        Parameter("mu_inf", "-", 0.2, 0.0, 5.0, "coefficient of a very large wheel"),
        Parameter("a", "-", -0.2, -20.0, 0.0, "rate of the size effect per unit of R_w/R_r"),
        # At b <= 0 no wheel is too small to have a coefficient.
        Parameter("b", "-", -0.3, -20.0, 0.0,
                  "e^b is the share of the friction that a vanishing wheel loses"),
    ),
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=ExponentialSize(),
    candidates=lambda mu, at, _log_lift: law.combinations(mu * np.array([1.0, 1.3, 2.0]), *size_candidates(at)),
    special_cases=(CONSTANT,),
    arithmetic=mu_times_wrap(("r", "R_w/R_r"), ("mu", MU_R)),
)  # fmt: skip


class Thickness(Uniform):
    """The physics of λ, the root of A μ λ² + λ = μ (1 − A), in place of μ, with A = R_r/(R_w + R_r)."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        # λ = [−1 + S]/(2Aμ) rationalised, so that it keeps its digits for thin ropes and small μ
        mu, _A, B, S = _parts(columns, conditions)
        return 2.0 * mu * B / (1.0 + S)

    def mu_slopes(self, columns: Columns, conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        _mu, _A, B, S = _parts(columns, conditions)
        return (2.0 * B / (S * (1.0 + S)),)

    def mu_by_radius(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return its derivative by R_w [1/m]."""
        mu, A, B, S = _parts(columns, conditions)
        by_share = -2.0 * mu / (1.0 + S) * (1.0 + 2.0 * mu**2 * B * (B - A) / (S * (1.0 + S)))
        return -by_share * A / conditions.centreline_radius_m


def _parts(columns: Columns, conditions: Conditions) -> tuple[FloatArray, ...]:
    """Return μ, A = R_r/(R_w + R_r), 1 − A, whose digits a difference would cancel for small wheels, and the root S."""
    (mu,), r = columns, conditions.size_ratio
    A, B = 1.0 / (1.0 + r), 1.0 / (1.0 + 1.0 / r)
    return mu, A, B, np.sqrt(1.0 + 4.0 * A * B * mu**2)


THICKNESS = FrictionLaw(
    name="thickness",
    equation="lambda = (-1 + sqrt(1 + 4 A mu^2 (1 - A)))/(2 A mu), A = R_r/(R_w + R_r); F_A = F_B exp(lambda phi)",
    source="moment balance of a rope of finite thickness about the axle",
    parameters=(
        Parameter("mu", "-", 0.2, 0.0, 5.0,
                  "coefficient at the contact; the exponent per radian lambda is smaller"),
    ),
    coefficient="average",
    effects=frozenset({"size"}),
    weakens=True,
    physics=Thickness(),
    candidates=lambda mu, _at, _log_lift: mu * np.array([[1.0], [1.2], [1.6]]),
    # The rationalised form: (S − 1)/(2 A mu) would lose the digits of the printed S.
    arithmetic=mu_times_wrap(
        ("A", "R_r/(R_w + R_r)"), ("S", "sqrt(1 + 4 * A * mu^2 * (1 - A))"), ("lambda", "2 * mu * (1 - A)/(1 + S)", "mu")
    ),
)  # fmt: skip


class Groove(Uniform):
    """The physics of μ/sin(half angle): a V-groove wedges the rope."""

    def mu(self, columns: Columns, conditions: Conditions) -> FloatArray:
        """Return the coefficient."""
        mu, half_angle = columns
        return mu / np.sin(half_angle) + 0.0 * conditions.wrap_angle_rad

    def mu_slopes(self, columns: Columns, _conditions: Conditions) -> Slopes:
        """Return its derivatives."""
        mu, half_angle = columns
        sine = np.sin(half_angle)
        return 1.0 / sine, -mu * np.cos(half_angle) / sine**2


_HALF_ANGLE_RAD = float(np.radians(20.0))
GROOVE = FrictionLaw(
    name="groove",
    equation="F_A = F_B exp(mu phi/sin(half_angle))",
    source="V-groove form of Euler's equation",
    parameters=(
        Parameter("mu", "-", 0.07, 0.0, 5.0, "coefficient at the flanks of the groove"),
        Parameter("half_angle", "rad", _HALF_ANGLE_RAD, 0.02, float(np.pi / 2),
                  "half the groove's angle; only mu/sin(half_angle) is seen, so measure it and hold it fixed",
                  fixed=True),
    ),
    coefficient="average",
    effects=frozenset({"groove"}),
    weakens=True,
    physics=Groove(),
    candidates=lambda mu, _at, _log_lift: [[mu * np.sin(_HALF_ANGLE_RAD), _HALF_ANGLE_RAD]],
    arithmetic=mu_times_wrap(("mu/sin(half angle)", "mu/sin(half_angle)", "mu")),
)  # fmt: skip
