"""A prediction as a hand calculation: every line can be checked with a pocket calculator.

Each line is worked out from the rounded numbers printed above it, as a person would, so every line is right to
its last digits; the last line compares the end with the full-precision answer.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ropefric.errors import InputError
from ropefric.fitting.result import FitResult
from ropefric.friction.condition import Conditions
from ropefric.friction.end_tension import exponential_start_rad, power_log_start
from ropefric.friction.exponential_wrap import ExponentialWrap
from ropefric.friction.laws import ALL_LAWS
from ropefric.friction.power_wrap import PowerWrap

Settings = tuple[float, float, float, float]
"""R_w, R_r, φ and ln F_B as printed."""

_DIGITS = 9
# Below this φ0 is left out: its power is ln F_B/(…) only, and a calculator shows zero.
_TINY = 1e-90


@dataclass(slots=True)
class _Sheet:
    """Lines written so far."""

    lines: list[str] = field(default_factory=list)

    def line(self, name: str, arithmetic: str, value: float) -> float:
        """Write `name = arithmetic = value` and return the value as printed."""
        self.lines.append(f"{name} = {arithmetic} = {_text(value)}")
        return _printed(value)

    def say(self, text: str) -> None:
        """Write a line without arithmetic."""
        self.lines.append(text)


def hand_calculation(fit: FitResult, conditions: Conditions, index: int = 0) -> tuple[str, ...]:
    """Return the lift force of one condition as lines of arithmetic.

    Lines `name = arithmetic = value` use `ln`, `exp`, `sqrt`, `sin`, `acos`, `^` and the numbers above them; the
    others are words.
    """
    law = ALL_LAWS[fit.law]
    at = conditions.select([index])
    exact = float(law.log_lift(fit.theta, at)[0])
    sheet = _Sheet()
    sheet.say(f"law {law.name}: {law.equation}")
    p = {name: _given(sheet, name, value) for name, value in law.as_mapping(fit.theta).items()}
    R_w = _given(sheet, "R_w [m]", float(at.wheel_radius_m[0]))
    R_r = _given(sheet, "R_r [m]", float(at.rope_radius_m[0]))
    phi = _given(sheet, "phi [rad]", float(at.wrap_angle_rad[0]))
    F_B = _given(sheet, "F_B [N]", float(at.end_tension_N[0]))
    y = sheet.line("ln F_B", f"ln({_text(F_B)})", math.log(F_B))
    if isinstance(law.physics, PowerWrap):
        integral = _power(sheet, p, (R_w, R_r, phi, y), equivalence=law.physics.equivalence)
    elif isinstance(law.physics, ExponentialWrap):
        integral = _exponential(sheet, p, phi, y, equivalence=law.physics.equivalence)
    elif law.name in _UNIFORM:
        integral = _UNIFORM[law.name](sheet, p, (R_w, R_r, phi, y))
    else:
        raise InputError(
            f"there is no hand calculation for law {law.name}",
            fix=f"there is one for {', '.join(sorted([*_UNIFORM, 'wrap-power', 'wrap-exponential', 'coupled']))}",
        )
    log_lift = sheet.line("ln F_A", f"{_text(y)} + {_text(integral)}", y + integral)
    if log_lift > 700.0:
        raise InputError(f"ln F_A = {log_lift:g}: the force overflows a calculator", code="RF420")
    lift = sheet.line("F_A [N]", f"exp({_text(log_lift)})", math.exp(log_lift))
    sheet.say(f"at full precision F_A is {math.exp(exact):.10g} N; by hand {lift:.10g} N")
    return tuple(sheet.lines)


def _text(value: float) -> str:
    """Return a number for the sheet; a negative one in brackets."""
    text = f"{value:.{_DIGITS}g}"
    return f"({text})" if value < 0.0 else text


def _printed(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _given(sheet: _Sheet, name: str, value: float) -> float:
    sheet.say(f"{name}: {_text(value)}")
    return _printed(value)


def _power(sheet: _Sheet, p: dict[str, float], at: Settings, *, equivalence: bool) -> float:
    R_w, R_r, phi, y = at
    if "mu_inf" in p:
        r = sheet.line("r", f"{_text(R_w)}/{_text(R_r)}", R_w / R_r)
        m = sheet.line(
            "mu_R",
            f"{_text(p['mu_inf'])} * (1 - exp({_text(p['a'])} * {_text(r)} + {_text(p['b'])}))",
            -p["mu_inf"] * math.expm1(p["a"] * r + p["b"]),
        )
        k, d = p["c"], p["d"]
    else:
        m, k, d = p["a"], p["b"], p["c"]
    s = sheet.line("s", f"1 + {_text(k)}", 1.0 + k)

    def G(angle: float) -> tuple[str, float]:
        text = f"{_text(m)}/{_text(s)} * {_text(angle)}^{_text(s)} + {_text(d)} * {_text(angle)}"
        return text, m / s * angle**s + d * angle

    if not equivalence or y == 0.0:
        return sheet.line("integral of mu from 0", *G(phi))
    start = _printed(float(np.exp(power_log_start(y, m, k, d))))
    sheet.say("phi_0, the wrap that F_B stands for, solves m/s phi_0^s + d phi_0 = ln F_B:")
    if start < _TINY:
        sheet.say("phi_0 is too small for a calculator, so the integral up to it is ln F_B itself")
        far = sheet.line("integral up to phi_0 + phi", *G(phi))
        return sheet.line("integral of mu", f"{_text(far)} - {_text(y)}", far - y)
    sheet.say(f"phi_0 [rad]: {_text(start)}")
    near = sheet.line("integral up to phi_0", *G(start))
    end = sheet.line("phi_0 + phi", f"{_text(start)} + {_text(phi)}", start + phi)
    far = sheet.line("integral up to phi_0 + phi", *G(end))
    return sheet.line("integral of mu", f"{_text(far)} - {_text(near)}", far - near)


def _exponential(sheet: _Sheet, p: dict[str, float], phi: float, y: float, *, equivalence: bool) -> float:
    a, b, c = p["a"], p["b"], p["c"]
    start = 0.0
    if equivalence and y > 0.0:
        start = _printed(float(exponential_start_rad(y, a, b, c)))
        sheet.say("phi_0, the wrap that F_B stands for, solves a/b (exp(b phi_0) - 1) + c phi_0 = ln F_B:")
        sheet.say(f"phi_0 [rad]: {_text(start)}")
    if b == 0.0:
        return sheet.line("integral of mu", f"({_text(a)} + {_text(c)}) * {_text(phi)}", (a + c) * phi)

    def G(angle: float) -> tuple[str, float]:
        text = f"{_text(a)}/{_text(b)} * (exp({_text(b)} * {_text(angle)}) - 1) + {_text(c)} * {_text(angle)}"
        return text, a / b * math.expm1(b * angle) + c * angle

    if start == 0.0:
        return sheet.line("integral of mu from 0", *G(phi))
    near = sheet.line("integral up to phi_0", *G(start))
    end = sheet.line("phi_0 + phi", f"{_text(start)} + {_text(phi)}", start + phi)
    far = sheet.line("integral up to phi_0 + phi", *G(end))
    return sheet.line("integral of mu", f"{_text(far)} - {_text(near)}", far - near)


def _times_wrap(sheet: _Sheet, mu: float, phi: float) -> float:
    return sheet.line("mu phi", f"{_text(mu)} * {_text(phi)}", mu * phi)


def _constant(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    return _times_wrap(sheet, p["mu"], at[2])


def _offset(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    mu, k, phi = p["mu"], p["k"], at[2]
    return sheet.line("mu phi + k", f"{_text(mu)} * {_text(phi)} + {_text(k)}", mu * phi + k)


def _groove(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    mu, half = p["mu"], p["half_angle"]
    acts = sheet.line("mu/sin(half angle)", f"{_text(mu)}/sin({_text(half)})", mu / math.sin(half))
    return _times_wrap(sheet, acts, at[2])


def _thickness(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    R_w, R_r, phi, _ = at
    mu = p["mu"]
    if mu == 0.0:
        return _times_wrap(sheet, 0.0, phi)
    A = sheet.line("A", f"{_text(R_r)}/({_text(R_w)} + {_text(R_r)})", R_r / (R_w + R_r))
    S = sheet.line(
        "S",
        f"sqrt(1 + 4 * {_text(A)} * {_text(mu)}^2 * (1 - {_text(A)}))",
        math.sqrt(1.0 + 4.0 * A * mu**2 * (1.0 - A)),
    )
    # The rationalised form: (S − 1)/(2 A mu) would lose the digits of the printed S.
    acts = sheet.line(
        "lambda", f"2 * {_text(mu)} * (1 - {_text(A)})/(1 + {_text(S)})", 2.0 * mu * (1.0 - A) / (1.0 + S)
    )
    return _times_wrap(sheet, acts, phi)


def _size_exponential(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    R_w, R_r, phi, _ = at
    r = sheet.line("r", f"{_text(R_w)}/{_text(R_r)}", R_w / R_r)
    mu = sheet.line(
        "mu",
        f"{_text(p['mu_inf'])} * (1 - exp({_text(p['a'])} * {_text(r)} + {_text(p['b'])}))",
        -p["mu_inf"] * math.expm1(p["a"] * r + p["b"]),
    )
    return _times_wrap(sheet, mu, phi)


def _size_power(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    R_w, R_r, phi, _ = at
    share = sheet.line("R_w/(R_r + R_w)", f"{_text(R_w)}/({_text(R_r)} + {_text(R_w)})", R_w / (R_r + R_w))
    mu = sheet.line(
        "mu",
        f"{_text(p['mu_inf'])} * {_text(share)}^{_text(p['a'])} + {_text(p['b'])}",
        p["mu_inf"] * share ** p["a"] + p["b"],
    )
    return _times_wrap(sheet, mu, phi)


def _howell(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    R_w, R_r, phi, y = at
    A, n = p["A"], p["n"]
    if n == 1.0:
        return _times_wrap(sheet, A, phi)
    q = sheet.line("q", f"1 - {_text(n)}", 1.0 - n)
    R = sheet.line("R", f"{_text(R_w)} + {_text(R_r)}", R_w + R_r)
    K = sheet.line(
        "K",
        f"{_text(A)} * exp({_text(q)} * (ln({_text(R)}) - {_text(y)}))",
        A * math.exp(q * (math.log(R) - y)),
    )
    return sheet.line(
        "ln(F_A/F_B)",
        f"ln(1 + {_text(q)} * {_text(K)} * {_text(phi)})/{_text(q)}",
        math.log1p(q * K * phi) / q,
    )


def _bending(sheet: _Sheet, p: dict[str, float], at: Settings) -> float:
    """Write the equation for F_A with its solution put in: there is no closed form, but the check is by hand."""
    R_w, R_r, phi, y = at
    mu, rigidity = p["mu"], p["rigidity_N_m2"]
    here = Conditions(
        wheel_radius_m=np.array(R_w), rope_radius_m=np.array(R_r), wrap_angle_rad=np.array(phi),
        end_tension_N=np.array(math.exp(y)),
    )  # fmt: skip
    F_B = sheet.line("F_B [N]", f"exp({_text(y)})", math.exp(y))
    R = sheet.line("R", f"{_text(R_w)} + {_text(R_r)}", R_w + R_r)
    E = sheet.line("E", f"{_text(rigidity)}/(2 * {_text(R)}^2)", rigidity / (2.0 * R**2))
    F = _given(
        sheet,
        "F, the lift force that solves the law [N]",
        float(np.exp(_lift_of_bending(mu, rigidity, here))),
    )
    tight = sheet.line("theta_A", f"acos(1 - {_text(E)}/{_text(F)})", math.acos(1.0 - E / F))
    slack = sheet.line("theta_B", f"acos(1 - {_text(E)}/{_text(F_B)})", math.acos(1.0 - E / F_B))
    contact = sheet.line("phi_c", f"{_text(phi)} - {_text(tight)} - {_text(slack)}", phi - tight - slack)
    lift = sheet.line(
        "F from the law",
        f"{_text(E)} + ({_text(F_B)} - {_text(E)}) * exp({_text(mu)} * {_text(contact)})",
        E + (F_B - E) * math.exp(mu * contact),
    )
    return sheet.line("ln(F/F_B)", f"ln({_text(lift)}/{_text(F_B)})", math.log(lift / F_B))


def _lift_of_bending(mu: float, rigidity: float, here: Conditions) -> float:
    return float(ALL_LAWS["bending"].log_lift([mu, rigidity], here)[0])


_UNIFORM: dict[str, Callable[[_Sheet, dict[str, float], Settings], float]] = {
    "constant": _constant,
    "constant-offset": _offset,
    "groove": _groove,
    "thickness": _thickness,
    "size-exponential": _size_exponential,
    "size-power": _size_power,
    "howell": _howell,
    "bending": _bending,
}
