"""The keys of a press scene, table by table."""

from typing import Annotated, Any, Self

from pydantic import Field, PlainValidator, model_validator

from ropefric.files.toml_model import StrictTable, choice, got, reject, whole_number
from ropefric.scenes.schema import FrictionTable, SceneTable, number, optional, positive
from ropefric.systems.press.closures import CLOSURES
from ropefric.systems.press.transient.drives import DRIVE_LAWS
from ropefric.systems.press.transient.integrators import INTEGRATORS

_ROLES = ("driver", "driven", "tensioner")


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(one, str) for one in value):
        reject("RF110", f"expected a list of roller names, got {got(value)}", fix='write ["1", "2", "3"]')
    return tuple(value)


class TensionerTable(StrictTable):
    """`[rollers.NAME.tensioner]`."""

    spring: Annotated[float, optional("N/m", "20 N/mm")] = 0.0
    travel: Annotated[float, optional("m", "30 mm")] = 0.0
    force: Annotated[float | None, optional("N", "2000 N", above=0)] = None
    mass: Annotated[float | None, optional("kg", "121 kg", above=0)] = None
    damping: Annotated[float, optional("N*s/m", "500 N*s/m")] = 0.0
    upstream_angle: Annotated[float, optional("rad", "56.7 deg")] = 0.0
    downstream_angle: Annotated[float, optional("rad", "19.9 deg")] = 0.0


class RollerTable(StrictTable):
    """`[rollers.NAME]`."""

    radius: Annotated[float, optional("m", "75 mm", above=0)]
    wrap: Annotated[float, optional("rad", "163.3 deg", above=0)]
    role: Annotated[str, PlainValidator(choice(lambda: _ROLES))] = "driven"
    inertia: Annotated[float | None, optional("kg*m^2", "2.5 kg*m^2", above=0)] = None
    gravity_torque: Annotated[float, optional("N*m", "26.2 N*m")] = 0.0
    squeeze_torque: Annotated[float, optional("N*m", "33.6 N*m")] = 0.0
    overspeed: Annotated[float | None, PlainValidator(number)] = None
    tensioner: TensionerTable | None = None

    @model_validator(mode="after")
    def _carries_what_its_role_says(self) -> Self:
        if (self.role == "tensioner") != (self.tensioner is not None):
            reject(
                "RF121",
                "a tensioner is a roller of that role with a table of its own",
                fix='write role = "tensioner" and [rollers.NAME.tensioner], or neither',
                key="role",
            )
        return self


class BeltTable(StrictTable):
    """`[belts.NAME]`."""

    loop: Annotated[tuple[str, ...], PlainValidator(_names)]
    width: Annotated[float, optional("m", "2 m", above=0)]
    thickness: Annotated[float, optional("m", "5 mm", above=0)]
    density: Annotated[float | None, optional("kg/m^3", "1500 kg/m^3", above=0)] = None
    linear_density: Annotated[float | None, optional("kg/m", "15 kg/m", above=0)] = None
    axial_stiffness: Annotated[float | None, optional("N", "2000 kN", above=0)] = None
    damping: Annotated[float, optional("s", "1 ms")] = 0.0
    span_lengths: list[Annotated[float, optional("m", "1.2 m", above=0)]] | None = None

    @model_validator(mode="after")
    def _has_one_mass(self) -> Self:
        if (self.density is None) == (self.linear_density is None):
            reject("RF121", "give either density or linear_density", fix='add density = "1500 kg/m^3"')
        return self

    def mass(self) -> float:
        """Return ρA [kg/m]."""
        if self.linear_density is not None:
            return self.linear_density
        return (self.density or 0.0) * self.width * self.thickness


class MachineTable(StrictTable):
    """`[press]`."""

    speed: Annotated[float | None, optional("m/s", "0.92 m/s")] = None
    rotation: Annotated[float | None, optional("rad/s", "50 rpm")] = None
    preload: Annotated[float | None, optional("N", "2000 N", above=0)] = None
    load_factor: Annotated[float, PlainValidator(number)] = 1.0
    closure: Annotated[str, PlainValidator(choice(lambda: CLOSURES))] = "share"

    @model_validator(mode="after")
    def _has_one_speed(self) -> Self:
        if (self.speed is None) == (self.rotation is None):
            reject(
                "RF121",
                "give either speed, of the belts, or rotation, of the first driver",
                fix='add rotation = "50 rpm"',
            )
        for key in ("speed", "rotation", "load_factor"):
            value = getattr(self, key)
            if value is not None and value < 0.0:
                reject("RF110", f"{key} is negative", fix="give it zero or more", key=key)
        return self


def _by_roller(si_unit: str, like: str) -> PlainValidator:
    read: Any = optional(si_unit, like, above=0).func

    def values(value: object) -> dict[str, float]:
        if not isinstance(value, dict):
            reject(
                "RF110",
                f"expected a value for each roller, got {got(value)}",
                fix=f'write {{ "2" = "{like}" }}',
            )
        return {str(name): read(one) for name, one in value.items()}

    return PlainValidator(values)


def _units(value: object) -> dict[str, float]:
    if not isinstance(value, dict):
        reject(
            "RF110", f"expected a number for each roller, got {got(value)}", fix='write { "5" = 2, "6" = 1 }'
        )
    return {str(name): positive(one) for name, one in value.items()}


class GravityTable(StrictTable):
    """`[sludge.gravity]`, eqs. (5), (6)."""

    friction: Annotated[float, PlainValidator(positive)]
    height: Annotated[float, optional("m", "60 mm", above=0)]
    density: Annotated[float, optional("kg/m^3", "1000 kg/m^3", above=0)]
    width: Annotated[float, optional("m", "2 m", above=0)]
    zones: Annotated[dict[str, float], _by_roller("m", "1.2 m")]


class SqueezeTable(StrictTable):
    """`[sludge.squeeze]`, eqs. (7)-(9)."""

    width: Annotated[float, optional("m", "2 m", above=0)]
    compression: Annotated[float, optional("m", "10 mm", above=0)]
    strength: Annotated[float, optional("Pa", "30 kPa", above=0)]
    poisson_ratio: Annotated[float, PlainValidator(number)]
    youngs_modulus: Annotated[float, optional("Pa", "300 kPa", above=0)]
    units: Annotated[dict[str, float], PlainValidator(_units)]


class SludgeTable(StrictTable):
    """`[sludge]`: loads from the sludge, in place of torques."""

    gravity: GravityTable | None = None
    squeeze: SqueezeTable | None = None


class StartUpTable(StrictTable):
    """`[start_up]`."""

    law: Annotated[str, PlainValidator(choice(lambda: DRIVE_LAWS))] = "s-curve"
    duration: Annotated[float | None, optional("s", "5 s", above=0)] = None
    times: list[Annotated[float, optional("s", "1 s")]] | None = None
    speeds: list[Annotated[float, optional("m/s", "0.5 m/s")]] | None = None
    simulate: Annotated[float, optional("s", "20 s", above=0)]
    points: Annotated[int, PlainValidator(whole_number(2, 200_000))] = 2001
    slip: bool = True
    loads: Annotated[str, PlainValidator(choice(lambda: ("with-speed", "constant")))] = "with-speed"
    integrator: Annotated[str, PlainValidator(choice(lambda: INTEGRATORS))] = "exact"
    step: Annotated[float | None, optional("s", "1 ms", above=0)] = None
    tolerance: Annotated[float, PlainValidator(positive)] = 1e-6

    @model_validator(mode="after")
    def _integrates_what_it_can(self) -> Self:
        if self.slip and self.integrator != "exact":
            reject(
                "RF111",
                f"{self.integrator} solves a start-up without slip only",
                fix='write slip = false, or integrator = "exact"',
                key="integrator",
            )
        return self

    @model_validator(mode="after")
    def _gives_what_its_law_takes(self) -> Self:
        if self.law == "table" and (self.times is None or self.speeds is None):
            reject(
                "RF121", "a drive law from a table needs times and speeds", fix="add both lists", key="law"
            )
        if self.law in {"ramp", "s-curve"} and self.duration is None:
            reject(
                "RF121", f"the drive law {self.law} needs a duration", fix='add duration = "5 s"', key="law"
            )
        return self


class PressScene(SceneTable):
    """A scene with `system = "press"`."""

    press: MachineTable
    rollers: dict[str, RollerTable]
    belts: dict[str, BeltTable]
    friction: FrictionTable
    sludge: SludgeTable = Field(default_factory=SludgeTable)
    start_up: StartUpTable | None = None

    @model_validator(mode="after")
    def _preloads_its_tensioners(self) -> Self:
        for name, roller in self.rollers.items():
            if roller.tensioner is not None and roller.tensioner.force is None and self.press.preload is None:
                reject(
                    "RF121",
                    f"tensioner {name} has no force",
                    fix='add force = "2000 N" to it, or preload = "2000 N" to [press] for all',
                    key=f"rollers.{name}.tensioner",
                )
        for part, torque, loaded in (
            ("gravity", "gravity_torque", {} if self.sludge.gravity is None else self.sludge.gravity.zones),
            ("squeeze", "squeeze_torque", {} if self.sludge.squeeze is None else self.sludge.squeeze.units),
        ):
            for name in loaded:
                if name not in self.rollers:
                    reject("RF120", f"sludge.{part} names the unknown roller {name!r}", key=f"sludge.{part}")
                if getattr(self.rollers[name], torque):
                    reject(
                        "RF111",
                        f"roller {name} has a {torque} and a share of sludge.{part}",
                        fix="keep one of them",
                        key=f"rollers.{name}.{torque}",
                    )
        return self
