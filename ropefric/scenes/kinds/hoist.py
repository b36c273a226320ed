"""Scenes of a rope on a wheel that lifts."""

from typing import Annotated, Any

from ropefric.arrays import FloatArray
from ropefric.files.toml_model import reject
from ropefric.scenes import kind
from ropefric.systems.hoist.contact import GRAVITY_M_S2, HoistProblem, Lift, answerable
from ropefric.systems.hoist.effects import SYSTEM


class WheelTable(kind.Table):
    """`[wheel]`.

    Keys
    ----
    radius : R_w, of the wheel where the rope lies on it.
    wrap : φ, over which the rope lies on the wheel.
    speed : Of the rope, as it climbs.
    """

    radius: Annotated[float, kind.key("m", "40 mm", "wheel_radius_m")]
    wrap: Annotated[float, kind.key("rad", "540 deg", "wrap_angle_rad")]
    speed: Annotated[float | None, kind.key("m/s", "0.3 m/s", "speed_m_s", above=None)] = None


class RopeTable(kind.Table):
    """`[rope]`.

    Keys
    ----
    diameter : 2 R_r.
    linear_density : Mass per length; for the centrifugal force and the rope's own weight.
    hanging_length : Of the free end below the hoist, whose weight pulls on the slack side.
    bending_stiffness : EI, which keeps the rope from lying down on the whole wrap.
    """

    diameter: Annotated[float, kind.key("m", "9.8 mm", "rope_radius_m", factor=0.5)]
    linear_density: Annotated[float | None, kind.key("kg/m", "62 g/m", "linear_density_kg_m")] = None
    hanging_length: Annotated[float | None, kind.key("m", "5 m", "hanging_length_m")] = None
    bending_stiffness: Annotated[float | None, kind.key("N*m^2", "2e-3 N*m^2", "bending_stiffness_N_m2")] = (
        None
    )


class LoadTable(kind.Table):
    """`[load]`.

    Keys
    ----
    end_tension : F_B, what pulls on the slack side.
    payload : Mass that is to be lifted; with it the answer has the lift margin.
    """

    end_tension: Annotated[float | None, kind.key("N", "80 N", "end_tension_N")] = None
    payload: Annotated[float | None, kind.key("kg", "120 kg", "payload_kg")] = None

    def _check(self) -> None:
        if self.end_tension is None:
            also = " for the payload" if self.payload is not None else ""
            reject(
                "RF121",
                f"no end tension is given{also}: a rope that nothing pulls on its slack side lifts nothing",
                fix='add end_tension = "80 N"',
                key="end_tension",
            )


class HoistScene(kind.SceneTable):
    """A scene with `system = "hoist"`."""

    wheel: WheelTable
    rope: RopeTable
    load: LoadTable
    friction: kind.FrictionTable


def _weight_N(problem: HoistProblem) -> FloatArray | None:
    return None if problem.payload_kg is None else problem.payload_kg * GRAVITY_M_S2


def _quantities(lift: Lift, problem: HoistProblem) -> tuple[kind.Quantity, ...]:
    force_N, weight_N = lift.lift_force_N, _weight_N(problem)
    found = (
        kind.Quantity("lift_force_N", force_N, positive=True, is_main=True),
        kind.Quantity("mu_average", lift.average_mu, positive=True),
    )
    if weight_N is None:
        return found
    margin = kind.Quantity("lift_margin", force_N / weight_N, positive=True)
    return (*found, margin, kind.Quantity("margin_N", force_N - weight_N, scale=force_N))


def _failures(lift: Lift, problem: HoistProblem) -> tuple[kind.Failure, ...]:
    margins = [one.value for one in _quantities(lift, problem) if one.name == "lift_margin"]
    words = "the hoist does not lift its payload"
    return tuple(kind.Failure(words, "lift margin", margin, margin < 1.0) for margin in margins)


def _tree(lift: Lift, problem: HoistProblem) -> dict[str, Any]:
    tree, weight_N = kind.first(lift, "contact_rad", "log_lift", "end_tension_N"), _weight_N(problem)
    if weight_N is not None:
        tree |= {"payload_N": float(weight_N[0]), "lifts_payload": bool(lift.lift_force_N[0] >= weight_N[0])}
    return tree


KIND = kind.Kind(
    name="hoist",
    schema=HoistScene,
    system=SYSTEM,
    own_wheel=lambda table: (table.wheel.radius, 0.5 * table.rope.diameter),
    problem=lambda table, friction: HoistProblem(friction=friction, **kind.arrays(table)),
    quantities=_quantities,
    tree=_tree,
    contacts=lambda problem: kind.at_contact(problem, problem.end_tension_N),
    answerable=answerable,
    failures=_failures,
)
