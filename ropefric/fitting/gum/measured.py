"""The conditions of a campaign or a trial table as inputs of a budget: what each force is made up of."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ropefric.errors import InputError
from ropefric.fitting.gum.forces import ForceSide
from ropefric.fitting.gum.quantity import normal

_RECTANGULAR = math.sqrt(3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredCondition:
    """One condition with both its forces and what is known of them."""

    number: int
    wheel_radius_m: float
    rope_radius_m: float
    wrap_angle_rad: float
    wrap_std_rad: float
    lift: ForceSide
    end: ForceSide
    measures_slack: bool
    n: int
    has_scatter: bool
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> ForceSide:
        """Return the side that was measured."""
        return self.end if self.measures_slack else self.lift

    def describe(self) -> str:
        """Return the condition in words."""
        return (
            f"condition {self.number}: R_w = {1e3 * self.wheel_radius_m:.4g} mm, wrap "
            f"{math.degrees(self.wrap_angle_rad):.4g} deg, F_A = {self.lift.force_N:.4g} N, F_B = "
            f"{self.end.force_N:.4g} N"
        )


def with_measured_end(condition: MeasuredCondition, std_N: float | None = None) -> MeasuredCondition:
    """Return a condition whose F_B is the reading of a second channel and does not hang from weights."""
    if condition.measures_slack:
        raise InputError(
            "here F_B was measured against a known F_A: it is a reading already", key="end_tension_measured"
        )
    known_N, mass = condition.end.force_N, condition.end.quantities[0]
    std_N = known_N * mass.std / mass.estimate if std_N is None else std_N
    if not std_N > 0.0:
        raise InputError(
            "nothing is known of how well the slack side is measured",
            key="u_end_tension",
            fix='give it, such as --u-end-tension "0.3 N"',
        )
    reading = normal("reading of the slack side", "F̂_B", "N", std_N, estimate=known_N)
    return replace(condition, end=ForceSide(symbol="F_B", quantities=(reading,)))


def condition_numbered(conditions: Sequence[MeasuredCondition], number: int) -> MeasuredCondition:
    """Return the condition of that number."""
    for condition in conditions:
        if condition.number == number:
            return condition
    numbers = [condition.number for condition in conditions]
    raise InputError(
        f"there is no condition {number} with a force",
        key="condition",
        fix=f"there are {len(numbers)}, numbered {min(numbers, default=0)} to {max(numbers, default=0)}",
    )
