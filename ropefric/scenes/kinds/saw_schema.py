"""The keys of a band-saw scene, table by table."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from ropefric.files.toml_model import StrictTable, choice, got, reject, whole_number
from ropefric.scenes.schema import SceneTable, number, optional
from ropefric.systems.bandsaw.drive import tension_difference_N, torque_N_m
from ropefric.systems.bandsaw.ends import ENDS
from ropefric.systems.bandsaw.resonance import Excitation, fixed_frequency, tooth_passing, wheel_rotation
from ropefric.systems.bandsaw.saw import Side
from ropefric.systems.bandsaw.section import Section

_SIDES = tuple(side.value for side in Side)


class BladeTable(StrictTable):
    """`[blade]`."""

    free_span: Annotated[float, optional("m", "1.6 m", above=0)]
    linear_density: Annotated[float | None, optional("kg/m", "0.6 kg/m", above=0)] = None
    width: Annotated[float | None, optional("m", "85 mm", above=0)] = None
    thickness: Annotated[float | None, optional("m", "0.9 mm", above=0)] = None
    density: Annotated[float | None, optional("kg/m^3", "7800 kg/m^3", above=0)] = None
    youngs_modulus: Annotated[float | None, optional("Pa", "206 GPa", above=0)] = None
    shear_modulus: Annotated[float | None, optional("Pa", "79 GPa", above=0)] = None
    bending_stiffness: Annotated[float | None, optional("N*m^2", "1.06 N*m^2", above=0)] = None
    ends: Annotated[str, PlainValidator(choice(lambda: ENDS))] = "clamped"
    modes: Annotated[int, PlainValidator(whole_number(1, 40))] = 6

    @model_validator(mode="after")
    def _has_a_mass(self) -> Self:
        section = (self.width, self.thickness, self.density)
        if self.linear_density is None and None in section:
            reject(
                "RF121",
                "the blade's mass is not known",
                fix='add linear_density = "0.6 kg/m", or width, thickness and density',
            )
        if self.linear_density is not None and None not in section:
            reject(
                "RF111",
                "linear_density and density with the section are both given",
                fix="keep one of them",
                key="linear_density",
            )
        return self

    def mass(self) -> float:
        """Return ρA [kg/m]."""
        if self.linear_density is not None:
            return self.linear_density
        return (self.width or 0.0) * (self.thickness or 0.0) * (self.density or 0.0)

    def stiffness(self) -> float | None:
        """Return EI [N m2] where it is given or follows."""
        if self.bending_stiffness is not None:
            return self.bending_stiffness
        if self.width is None or self.thickness is None or self.youngs_modulus is None:
            return None
        return self.youngs_modulus * self.width * self.thickness**3 / 12.0

    def section(self) -> Section | None:
        """Return the cross-section where all of it is given."""
        if self.width is None or self.thickness is None or self.shear_modulus is None:
            return None
        return Section(
            width_m=self.width,
            thickness_m=self.thickness,
            density_kg_m3=self.mass() / (self.width * self.thickness),
            shear_modulus_Pa=self.shear_modulus,
        )


class WheelTable(StrictTable):
    """`[wheel]`."""

    radius: Annotated[float | None, optional("m", "0.35 m", above=0)] = None
    diameter: Annotated[float | None, optional("m", "0.7 m", above=0)] = None
    speed: Annotated[float, optional("rad/s", "970 rpm")] = 0.0
    wrap: Annotated[float, optional("rad", "180 deg", above=0)] = np.pi

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        if (self.radius is None) == (self.diameter is None):
            reject("RF121", "give either radius or diameter of the wheels", fix='write diameter = "0.7 m"')
        if self.speed < 0.0:
            reject("RF110", "a wheel's speed is counted without sign", fix="remove the minus", key="speed")
        return self

    def radius_m(self) -> float:
        """Return R [m]."""
        return self.radius if self.radius is not None else 0.5 * (self.diameter or 0.0)


def _share(value: object) -> float:
    found = number(value)
    if not 0.0 <= found <= 1.0:
        reject(
            "RF110",
            f"a mounting factor of {got(value)} is not from 0 to 1",
            fix="give 0 for fixed wheel axles, 1 for a constant-force mounting",
        )
    return found


class TensionTable(StrictTable):
    """`[tension]`."""

    preload: Annotated[float, optional("N", "3412 N", above=0)]
    mounting_factor: Annotated[float | None, PlainValidator(_share)] = None


class DriveTable(StrictTable):
    """`[drive]`."""

    power: Annotated[float | None, optional("W", "7.5 kW")] = None
    torque: Annotated[float | None, optional("N*m", "73.8 N*m")] = None
    tension_difference: Annotated[float | None, optional("N", "211 N")] = None
    printed_factor: bool = False

    @model_validator(mode="after")
    def _says_one_thing(self) -> Self:
        given = [
            name for name in ("power", "torque", "tension_difference") if getattr(self, name) is not None
        ]
        if len(given) != 1:
            reject(
                "RF111" if given else "RF121",
                f"{' and '.join(given)} are given" if given else "the drive gives nothing",
                fix="give one of power, torque, tension_difference",
            )
        if getattr(self, given[0]) < 0.0:
            reject("RF110", f"{given[0]} is negative", fix="give it zero or more", key=given[0])
        return self


def _margin(value: object) -> float:
    found = number(value)
    if not 0.0 < found < 1.0:
        reject("RF110", f"a margin of {got(value)} is not between 0 and 1", fix="write 0.1 for 10 %")
    return found


class ExcitationTable(StrictTable):
    """`[excitation]`."""

    wheel_harmonics: Annotated[int, PlainValidator(whole_number(0, 50))] = 3
    tooth_pitch: Annotated[float | None, optional("m", "22 mm", above=0)] = None
    frequencies: list[Annotated[float, optional("Hz", "50 Hz", above=0)]] = Field(default_factory=list)
    margin: Annotated[float | None, PlainValidator(_margin)] = None
    preload_range: list[Annotated[float, optional("N", "3000 N", above=0)]] | None = None

    @model_validator(mode="after")
    def _wants_a_margin_over_a_range(self) -> Self:
        if (self.margin is None) != (self.preload_range is None):
            reject(
                "RF121",
                "a recommended preload needs both the margin wanted and the range of preloads",
                fix='add margin = 0.1 and preload_range = ["2000 N", "6000 N"]',
            )
        if self.preload_range is not None and (
            len(self.preload_range) != 2 or not self.preload_range[0] < self.preload_range[1]
        ):
            reject("RF110", "a range is two preloads, the lower first", key="preload_range")
        return self


class MeasuredTable(StrictTable):
    """`[[measured]]`."""

    side: Annotated[str, PlainValidator(choice(lambda: _SIDES))]
    frequency: Annotated[float, optional("Hz", "24.9 Hz", above=0)]
    mode: Annotated[int, PlainValidator(whole_number(1, 40))] = 1
    uncertainty: Annotated[float | None, optional("Hz", "0.1 Hz", above=0)] = None


class SawScene(SceneTable):
    """A scene with `system = "bandsaw"`."""

    blade: BladeTable
    tension: TensionTable
    wheel: WheelTable | None = None
    drive: DriveTable | None = None
    excitation: ExcitationTable | None = None
    measured: list[MeasuredTable] = Field(default_factory=list)

    @model_validator(mode="after")
    def _drives_a_wheel(self) -> Self:
        if self.drive is not None and self.wheel is None:
            reject("RF121", "a drive needs a wheel", fix="add [wheel] with diameter and speed", key="drive")
        needs_speed = self.drive is not None and self.drive.power is not None
        if needs_speed and (self.wheel is None or not self.wheel.speed):
            reject(
                "RF121",
                "a power says nothing about the tensions without the wheel's speed",
                fix='add speed = "970 rpm" to [wheel]',
                key="wheel.speed",
            )
        return self

    def pull_N(self) -> float | None:
        """Return ΔF [N] where the scene gives it."""
        if self.drive is None or self.wheel is None:
            return None
        if self.drive.tension_difference is not None:
            return self.drive.tension_difference
        torque = self.drive.torque
        if torque is None:
            torque = float(
                torque_N_m(self.drive.power or 0.0, self.wheel.speed, printed=self.drive.printed_factor)
            )
        return float(tension_difference_N(torque, self.wheel.radius_m()))

    def excitations(self) -> tuple[Excitation, ...]:
        """Return what may shake the blade."""
        if self.excitation is None:
            return ()
        found = [fixed_frequency(f"{one:g} Hz", one) for one in self.excitation.frequencies]
        if self.excitation.tooth_pitch is not None:
            found.insert(0, tooth_passing(self.excitation.tooth_pitch))
        if self.wheel is not None and self.excitation.wheel_harmonics:
            harmonics = tuple(range(1, self.excitation.wheel_harmonics + 1))
            found.insert(0, wheel_rotation(self.wheel.radius_m(), harmonics))
        return tuple(found)
