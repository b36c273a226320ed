"""A belt drive: the pull that friction carries, the tensions at work, and how far the belt creeps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ropefric.arrays import BoolArray, FloatArray
from ropefric.errors import SolverError
from ropefric.systems.checks import AnyNumber, Cases, Positive, ZeroOrMore, refuse
from ropefric.systems.effect import Model
from ropefric.systems.fixed_centres import excess_of_length
from ropefric.systems.friction import WrapFriction, refuse_no_ratio, regressors_of
from ropefric.systems.roots import roots_of_cases

CLOSURES = ("limit", "tensioner", "fixed", "lever")
_MAX_STEPS = 200


@dataclass(frozen=True, kw_only=True, eq=False)
class DriveProblem(Cases):
    """A belt drive, n cases side by side. Without a driven pulley it is a drum or a brake."""

    friction: WrapFriction
    closure: str
    wheel_radius_m: Positive
    wrap_angle_rad: Positive
    tension_N: Positive
    rope_radius_m: Positive
    belt_count: Positive
    speed_rad_s: ZeroOrMore | None = None
    driven_radius_m: Positive | None = None
    driven_wrap_rad: Positive | None = None
    span_m: Positive | None = None
    centre_distance_m: Positive | None = None
    crossed: bool = False
    lever_m: Positive | None = None
    tight_arm_m: AnyNumber | None = None
    slack_arm_m: AnyNumber | None = None
    brake_torque_N_m: Positive | None = None
    stress_Pa: Positive | None = None
    density_kg_m3: Positive | None = None
    linear_density_kg_m: ZeroOrMore | None = None
    groove_angle_rad: Positive | None = None
    axial_stiffness_N: Positive | None = None
    power_W: ZeroOrMore | None = None

    def __post_init__(self) -> None:
        Cases.__post_init__(self)
        groove = np.ones(1) if self.groove_angle_rad is None else self.groove_angle_rad
        refuse(
            (groove < 1e-3) | (groove > np.pi),
            "a groove of {degrees:.4g} deg from flank to flank is no wedge; it opens by 0.06 to 180 deg",
            key="groove_angle_rad",
            fix="give the angle between the flanks, or leave it out for a flat belt",
            degrees=np.degrees(groove),
        )
        if self.centre_distance_m is not None and self.driven_radius_m is not None:
            self._lay(self.centre_distance_m, self.driven_radius_m)

    def _lay(self, apart_m: FloatArray, driven_m: FloatArray) -> None:
        """Set the wraps and the span that follow from the distance of the centres, of an open or a crossed belt."""
        across_m = self.wheel_radius_m + driven_m
        refuse(
            apart_m <= across_m,
            "a centre distance of {apart_m:.6g} m lets the pulleys touch: their radii come to {across_m:.6g} m",
            key="centre_distance_m",
            fix="raise the distance",
            apart_m=apart_m,
            across_m=across_m,
        )
        step_m = across_m if self.crossed else self.wheel_radius_m - driven_m
        lean_rad = 2.0 * np.arcsin(step_m / apart_m)
        object.__setattr__(self, "wrap_angle_rad", np.pi + lean_rad)
        object.__setattr__(self, "driven_wrap_rad", np.pi + (lean_rad if self.crossed else -lean_rad))
        object.__setattr__(self, "span_m", np.sqrt((apart_m - step_m) * (apart_m + step_m)))

    @property
    def belt_speed_m_s(self) -> FloatArray:
        """Return the rim speed of the driving pulley [m/s], shape (n,)."""
        return self.product("speed_rad_s", "wheel_radius_m")

    @property
    def circling_N(self) -> FloatArray:
        """Return m v2, the centripetal part of the tension [N]; zero for the band of a brake."""
        if self.closure == "lever":
            return np.zeros(self.n)
        return self.product("linear_density_kg_m", "belt_speed_m_s", "belt_speed_m_s")

    @property
    def belt_length_m(self) -> FloatArray | None:
        """Return the length of the belt as it is laid, 2 spans and the arcs [m]; None where no span is known."""
        if self.span_m is None:
            return None
        arcs_m = [radius_m * wrap_rad for radius_m, wrap_rad in self.pulleys]
        return np.asarray(2.0 * self.span_m + sum(arcs_m))

    @property
    def pulleys(self) -> list[tuple[FloatArray, FloatArray]]:
        """Return radius [m] and wrap [rad] of the driving pulley, and of the driven one where there is one."""
        found = [(self.wheel_radius_m, self.wrap_angle_rad)]
        if self.driven_radius_m is not None and self.driven_wrap_rad is not None:
            found.append((self.driven_radius_m, self.driven_wrap_rad))
        return found


DriveModel = Model[DriveProblem]
"""A belt drive with the effects that are simulated."""


class DriveAnswer(NamedTuple):
    """Capacity and running state of a belt drive; arrays of shape (n,), forces per belt.

    Attributes
    ----------
    circling_N : ndarray
        m v2, what keeps the belt on its circle [N].
    coefficients, exponents : ndarray, shape (2, n)
        mu', with what the groove makes of it, and mu' times the wrap, of driving and driven pulley; NaN without one.
    full_tight_N, full_slack_N : ndarray
        T1 and T2 at the largest pull [N].
    tight_N, slack_N : ndarray
        T1 and T2 at work [N]: at the power asked for, at the largest pull where none is.
    strain : ndarray, shape (2, n)
        Of the tight and the slack side at work; 0 where creep is left out.
    """

    model: DriveModel
    circling_N: FloatArray
    coefficients: FloatArray
    exponents: FloatArray
    full_tight_N: FloatArray
    full_slack_N: FloatArray
    tight_N: FloatArray
    slack_N: FloatArray
    strain: FloatArray

    @property
    def full_pull_N(self) -> FloatArray:
        """Return the largest pull of all belts [N]: of the exponent, as a difference of near tensions has no digits."""
        held = -np.expm1(-np.nanmin(self.exponents, axis=0))
        return np.asarray(self.model.problem.belt_count * (self.full_tight_N - self.circling_N) * held)

    @property
    def full_power_W(self) -> FloatArray:
        """Return the largest power of all belts at the speed of the driving pulley [W]."""
        return np.asarray(self.full_pull_N * self.model.problem.belt_speed_m_s)

    @property
    def pull_N(self) -> FloatArray:
        """Return the pull of all belts at work [N]."""
        problem = self.model.problem
        return self.full_pull_N if problem.power_W is None else problem.power_W / problem.belt_speed_m_s

    @property
    def utilisation(self) -> FloatArray:
        """Return the pull at work over the largest one; above 1 the belts slip, however small the largest is."""
        pull_N, full_N = self.pull_N, self.full_pull_N
        beyond = np.where(pull_N > 0.0, np.inf, 0.0)
        return np.divide(pull_N, full_N, out=beyond, where=full_N > 0.0)

    @property
    def speed_ratio(self) -> FloatArray:
        """Return the rim speed of the driven pulley over that of the driving one, (1 + T2/EA)/(1 + T1/EA).

        NaN where the belt slips wholly: creep does not set its speed then.
        """
        tight, slack = self.strain
        return np.where(self.slips_wholly, np.nan, (1.0 + slack) / (1.0 + tight))

    @property
    def slips_wholly(self) -> BoolArray:
        """Return where the belt does not carry its pull, or a side of it presses no more, shape (n,)."""
        pressing_N = np.minimum(self.tight_N, self.slack_N) - self.circling_N
        return np.asarray((pressing_N <= 0.0) | (self.utilisation > 1.0 + 1e-9))

    @property
    def slip_arc_rad(self) -> FloatArray:
        """Return the arcs of both pulleys over which the belt slips at work, shape (2, n); NaN where it slips wholly."""
        whole = self.slips_wholly
        pull_N = self.pull_N / self.model.problem.belt_count
        low_N = np.where(whole, 1.0, self.slack_N - self.circling_N)
        arcs = np.full_like(self.coefficients, np.nan)
        np.divide(np.log1p(pull_N / low_N), self.coefficients, out=arcs, where=self.coefficients > 0.0)
        wraps = [one[1] for one in self.model.problem.pulleys]
        arcs[: len(wraps)] = np.minimum(arcs[: len(wraps)], np.stack(wraps))  # rounding is no arc
        return np.where(whole, np.nan, arcs)

    @property
    def logs(self) -> FloatArray:
        """Return the logarithms of all numbers, shape (k, n); of the power that creep loses its share of all power."""
        with np.errstate(divide="ignore", invalid="ignore"):
            forces = (self.full_tight_N, self.full_slack_N, self.full_pull_N, self.tight_N, self.slack_N)
            found = np.log(
                [*forces, self.utilisation, self.speed_ratio, *self.coefficients, *self.slip_arc_rad]
            )
        return np.asarray(found)


def solve_drive(model: DriveModel) -> DriveAnswer:
    """Return what a belt drive carries, and how it runs at the power asked for."""
    problem = model.problem
    circling_N = model.part("centrifugal", problem.circling_N)
    refuse(
        problem.tension_N <= circling_N,
        "m v^2 = {circling_N:.6g} N is not below the tension of {tension_N:.6g} N: the belt lifts off the pulley",
        code="RF510",
        key="speed_rad_s",
        fix="raise the tension or lower the speed",
        circling_N=circling_N,
        tension_N=problem.tension_N,
    )
    pressing_N, law = problem.tension_N - circling_N, problem.friction.law
    coefficients = _coefficients(model, pressing_N)
    if "wrap-dependence" in model.effects and "end-tension" in law.effects and problem.closure != "tensioner":
        # What presses on the slack side depends on the friction, and such a law's friction on it.
        for _ in range(_MAX_STEPS):
            slack_N = _full_N(model, pressing_N, _exponents(problem, coefficients))[1]
            better = _coefficients(model, slack_N)
            moving = np.nanmax(np.abs(better / coefficients - 1.0), axis=0) > 1e-13
            coefficients = better
            if not moving.any():
                break
        else:
            why, fix = "friction and slack tension do not settle", "use a law without tension"
            raise SolverError(why, code="RF500", fix=fix, cases=moving)
    exponents = _exponents(problem, coefficients)
    full_tight_N, full_slack_N = (one + circling_N for one in _full_N(model, pressing_N, exponents))
    tight_N, slack_N = full_tight_N, full_slack_N
    if problem.power_W is not None:
        refuse(
            problem.belt_speed_m_s <= 0.0,
            "a belt at rest carries no power",
            key="speed_rad_s",
            fix="give a speed, or leave out the power",
        )
        pull_N = problem.power_W / problem.belt_speed_m_s / problem.belt_count
        behind = {"limit": 0.0, "tensioner": 1.0, "fixed": 0.5}[problem.closure]
        tight_N = problem.tension_N + behind * pull_N
        if problem.closure == "fixed" and problem.span_m is not None:
            pressed_N = _kept_length_N(model, exponents, lambda slack_N: slack_N + pull_N)
            tight_N = circling_N + pressed_N + pull_N
        slack_N = tight_N - pull_N
    strain = np.zeros((2, problem.n))
    if "creep" in model.effects and problem.axial_stiffness_N is not None:
        strain = np.stack([tight_N, slack_N]) / problem.axial_stiffness_N
    full, work = (full_tight_N, full_slack_N), (tight_N, slack_N)
    return DriveAnswer(model, circling_N, coefficients, exponents, *full, *work, strain)


def _coefficients(model: DriveModel, slack_N: FloatArray) -> FloatArray:
    """Return mu' of driving and driven pulley, shape (2, n); NaN where there is no driven one."""
    problem = model.problem
    thin_m, regressors = problem.rope_radius_m, regressors_of(model.effects)
    found = [
        problem.friction.exponent(radius_m, thin_m, wrap_rad, slack_N, regressors=regressors) / wrap_rad
        for radius_m, wrap_rad in problem.pulleys
    ]
    wedge = np.ones(problem.n)
    if "wedge" in model.effects and problem.groove_angle_rad is not None:
        wedge = 1.0 / np.sin(0.5 * problem.groove_angle_rad)
    return np.stack([*found, np.full(problem.n, np.nan)][:2]) * wedge


def _exponents(problem: DriveProblem, coefficients: FloatArray) -> FloatArray:
    driven = problem.wrap_angle_rad if problem.driven_wrap_rad is None else problem.driven_wrap_rad
    exponents = coefficients * np.stack([problem.wrap_angle_rad, driven])
    refuse_no_ratio(np.nanmin(exponents, axis=0))  # of the pulley that slips first
    return np.asarray(exponents)


def _full_N(
    model: DriveModel, pressing_N: FloatArray, exponents: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what presses on the tight and on the slack side at the largest pull [N]."""
    problem = model.problem
    exponent = np.nanmin(exponents, axis=0)
    if problem.closure == "limit":
        return pressing_N, pressing_N * np.exp(-exponent)
    if problem.closure == "tensioner":
        return pressing_N * np.exp(exponent), pressing_N
    if problem.closure == "lever":
        lever_m, tight_arm_m, slack_arm_m = _lever_m(problem)
        arm_m = slack_arm_m + tight_arm_m * np.exp(exponent)
        refuse(
            arm_m <= 0.0,
            "the brake locks by itself: its tight end pulls the lever on by more than its slack end holds it",
            code="RF510",
            key="tight_arm_m",
            fix="lengthen the arm of the slack end, or shorten that of the tight one",
        )
        slack_N = pressing_N * lever_m / arm_m
        return slack_N * np.exp(exponent), slack_N
    if problem.span_m is not None:
        slack_N = _kept_length_N(model, exponents, lambda slack_N: slack_N * np.exp(exponent))
        return slack_N * np.exp(exponent), slack_N
    share = np.tanh(0.5 * exponent)
    return pressing_N * (1.0 + share), pressing_N * 2.0 / (1.0 + np.exp(exponent))


def _lever_m(problem: DriveProblem) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the arms of effort, tight end and slack end about the fulcrum [m], as the drum turns."""
    return tuple(problem.product(name) for name in ("lever_m", "tight_arm_m", "slack_arm_m"))  # type: ignore[return-value]


class Brake(NamedTuple):
    """A band brake turning the other way, and the efforts that hold a torque, shape (n,); NaN where it locks by itself.

    Turning the other way the ends of the band change their parts. An effort of zero or less holds by itself.
    """

    reversed_torque_N_m: FloatArray
    needed_effort_N: FloatArray | None
    reversed_effort_N: FloatArray | None


def brake_of(answer: DriveAnswer) -> Brake | None:
    """Return what a lever does beside the torque of the given effort; None without one."""
    problem = answer.model.problem
    if problem.closure != "lever":
        return None
    lever_m, *arms_m = _lever_m(problem)
    exponent = answer.exponents[0]
    arm_m = arms_m[0] + arms_m[1] * np.exp(exponent)
    moment_N_m = problem.tension_N * lever_m * problem.wheel_radius_m * np.expm1(exponent)
    torque_N_m = np.divide(moment_N_m, arm_m, out=np.full_like(arm_m, np.nan), where=arm_m > 0.0)
    if problem.brake_torque_N_m is None:
        return Brake(torque_N_m, None, None)
    with np.errstate(divide="ignore"):
        slack_N = problem.brake_torque_N_m / problem.wheel_radius_m / np.expm1(exponent)
    tight_N = slack_N + problem.brake_torque_N_m / problem.wheel_radius_m
    efforts = [(tight_N * one + slack_N * other) / lever_m for one, other in (arms_m, arms_m[::-1])]
    return Brake(torque_N_m, *efforts)


def needed_width_m(answer: DriveAnswer) -> FloatArray | None:
    """Return the width of each belt that carries the power without exceeding its stress, shape (n,) [m].

    σ b h = F/(1 − e^−M) + c, where c is ρ v² b h of a density, m v² of a mass per length; inf where the centrifugal
    stress alone is too much. None without a stress or a power.
    """
    problem = answer.model.problem
    if problem.stress_Pa is None or problem.power_W is None:
        return None
    held = -np.expm1(-np.nanmin(answer.exponents, axis=0))
    pull_N, thickness_m = answer.pull_N / problem.belt_count, 2.0 * problem.rope_radius_m
    spent_Pa = np.zeros(problem.n)
    if problem.density_kg_m3 is not None and "centrifugal" in answer.model.effects:
        spent_Pa = problem.density_kg_m3 * problem.belt_speed_m_s**2
    circling_N = answer.circling_N if problem.density_kg_m3 is None else np.zeros(problem.n)
    pressing_N = np.divide(pull_N, held, out=np.full_like(pull_N, np.inf), where=held > 0.0)
    left_Pa = problem.stress_Pa - spent_Pa
    width_m = np.divide(
        pressing_N + circling_N, left_Pa * thickness_m, out=np.full_like(pull_N, np.inf), where=left_Pa > 0.0
    )
    return np.asarray(width_m)


def _kept_length_N(
    model: DriveModel, exponents: FloatArray, tight_of: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Return what presses on the slack side where the belt keeps its length between fixed centres, shape (n,) [N].

    0 where the belt would have to push. The excess of length falls as the tensions grow, so the root is bracketed.
    """
    problem = model.problem
    circling_N = model.part("centrifugal", problem.circling_N)
    stretches = "creep" in model.effects and problem.axial_stiffness_N is not None
    stiffness_N = problem.axial_stiffness_N if stretches and problem.axial_stiffness_N is not None else np.inf
    arcs_m = np.stack([radius_m * wrap_rad for radius_m, wrap_rad in problem.pulleys], axis=-1)

    def excess(slack_N: FloatArray) -> FloatArray:
        """Return the excess of length round the belt: tight side, driving pulley, slack side, driven pulley."""
        ends = np.stack([tight_of(slack_N), slack_N], axis=-1)
        falls = np.log(ends[..., 1] / ends[..., 0])
        return excess_of_length(
            problem.tension_N,
            stiffness_N,
            span_m=np.asarray(problem.span_m)[:, np.newaxis],
            arc_m=arcs_m,
            arriving_N=ends + circling_N[:, np.newaxis],
            leaving_N=ends[..., ::-1] + circling_N[:, np.newaxis],
            growth=np.stack([falls, -falls], axis=-1),
            exponent=exponents.T,
        )

    high_N = problem.tension_N - circling_N
    return np.nan_to_num(roots_of_cases(excess, 1e-12 * high_N, high_N))


def best_speed_m_s(problem: DriveProblem) -> FloatArray | None:
    """Return the belt speed of the largest power, √(T/3m) [m/s], with the coefficient as it is; None without a mass.

    The pull is proportional to T − m v2 of the tension that is given; not with a kept length or a band at rest.
    """
    kept = problem.closure == "lever" or (problem.closure == "fixed" and problem.span_m is not None)
    if kept or problem.linear_density_kg_m is None or not problem.linear_density_kg_m.all():
        return None
    return np.asarray(np.sqrt(problem.tension_N / (3.0 * problem.linear_density_kg_m)))


def answerable(problem: DriveProblem) -> BoolArray:
    """Return for which of n cases the belt stays on its pulleys, shape (n,)."""
    return np.asarray(problem.tension_N > problem.circling_N)
