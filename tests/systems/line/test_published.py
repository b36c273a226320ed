"""Printed numbers of textbooks, standards, handbooks and manuals: a line gives each of them back as it is printed."""

from dataclasses import dataclass, field

import pytest

from ropefric.files.toml import TomlDocument
from ropefric.scenes.kind import value_at
from ropefric.scenes.scene import read_scene
from ropefric.scenes.solve import solve_scene

LB, FT, KSI = 4.4482216152605, 0.3048, 6.894757e6


def solved(elements, *, line, rope=None, friction=None, tmp="."):
    tree = {"system": "line", "line": line, "element": elements}
    tree |= {"rope": rope} if rope else {}
    tree |= {"friction": friction} if friction else {}
    return solve_scene(read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), tmp))


@dataclass
class Printed:
    """A number of others: where it stands, as printed, half a unit of its last place, and the line that gives it."""

    source: str
    value: float
    half: float
    key: str
    elements: list
    line: dict
    rope: dict = field(default_factory=dict)
    friction: dict = field(default_factory=dict)
    unit: float = 1.0


def bend(degrees, **more):
    return {"kind": "bend", "angle": f"{degrees!r} deg", **more}


def drum(degrees, **more):
    return {"kind": "drum", "angle": f"{degrees!r} deg", **more}


def run(length, **more):
    return {"kind": "run", "length": length, **more}


def mu(value):
    return {"mu": value}


def held(source, value, half, load, turns, coefficient, unit=1.0):  # noqa: PLR0917  (a row of the table)
    """What holds a load over some turns."""
    return Printed(source, value, half, "hand_tension_N", [bend(360.0 * turns)],
                   {"direction": "pay-out", "start_tension": load}, friction=mu(coefficient), unit=unit)  # fmt: skip


def grown(source, value, half, start, degrees, coefficient, unit=1.0):  # noqa: PLR0917  (a row of the table)
    """What pulls a rope through bends."""
    return Printed(source, value, half, "hand_tension_N", [bend(one) for one in degrees],
                   {"start_tension": start}, friction=mu(coefficient), unit=unit)  # fmt: skip


def tackle(source, value, half, efficiencies, **more):
    """Advantage of a hauling system whose runs all carry, a wheel between each two."""
    parts = [run("1 m", carries=True)]
    for one in efficiencies:
        parts += [{"kind": "wheel", "efficiency": one}, run("1 m", carries=True)]
    return Printed(
        source, value, half, "advantage", parts, {"end_tension": "100 N"}, friction=mu(0.1), **more
    )


EN = "EN 1992-1-1, 5.10.5.2, P (1 - e^-mu(theta + k x))"
COMMSCOPE = "CommScope, ConQuest Conduit Construction Manual, p. 69"
GIRDER = "Friction and anchor set losses in post-tensioned tendons, 90 ft girder, scribd.com/doc/187603860"
# e^(mu theta) of bends, from the same page of the manual; some are cut off and not rounded.
BENDS = {15: (1.20, 1.17, 1.14, 1.11, 1.08, 1.04), 30: (1.44, 1.37, 1.30, 1.23, 1.17, 1.08),
         45: (1.73, 1.60, 1.48, 1.37, 1.27, 1.13), 60: (2.08, 1.87, 1.68, 1.52, 1.37, 1.17),
         75: (2.50, 2.19, 1.92, 1.69, 1.48, 1.22), 90: (3.00, 2.57, 2.19, 1.87, 1.60, 1.27)}  # fmt: skip
COEFFICIENTS = (0.7, 0.6, 0.5, 0.4, 0.3, 0.15)
TENDON = [{"kind": "bend", "angle": "0.2 rad", "length": "30 ft", "wobble": f"{0.0002 / 0.25!r} 1/ft"}] * 3
# A tendon of one square metre: newtons are pascals.
STRESSED = {"line": {"start_tension": f"{202.5 * KSI!r} N", "direction": "pay-out", "anchorage_slip": "0.375 in"},
            "rope": {"axial_stiffness": f"{28000 * KSI!r} N"}, "friction": mu(0.25), "unit": KSI}  # fmt: skip


def conduit(source, value, half, key, unit=LB):
    """A cable of half a pound a foot through 100 ft and round half a turn."""
    return Printed(source, value, half, key, [run("100 ft"), bend(180.0, radius="6 in")],
                   {"start_tension": "20 lbf"}, {"linear_density": "0.5 lb/ft"}, mu(0.35), unit)  # fmt: skip


def duct(source, value, half, key, unit=LB):
    """A cable of three times that through 200 ft and round a quarter of a turn."""
    return Printed(source, value, half, key, [run("200 ft"), bend(90.0, radius="2 ft")],
                   {"start_tension": "0 N"}, {"linear_density": "1.5 lb/ft"}, mu(0.3), unit)  # fmt: skip


def straight(source, value, half, length, linear_density, coefficient, unit=1.0):  # noqa: PLR0917  (a row of the table)
    """What pulls a cable through a straight run."""
    return Printed(source, value, half, "hand_tension_N", [run(length)], {"start_tension": "0 N"},
                   {"linear_density": linear_density}, mu(coefficient), unit)  # fmt: skip


def take_up(source, value, half, degrees, coefficient):
    """Slack tension that one newton of pull needs, the drive factor of a conveyor."""
    return Printed(source, value, half, "needed_end_tension_N", [drum(degrees, share=1.0)], {"pull": "1 N"},
                   friction=mu(coefficient))  # fmt: skip


PRINTED = [
    grown("gera.services, wire pulling tension: 90 lb into 90 deg at 0.3", 144.18, 0.005, "90 lbf", [90.0], 0.3, LB),
    grown(COMMSCOPE + ": QR 715 behind a bend", 79.0, 0.5, "36 lbf", [90.0], 0.5, LB),
    *(grown(f"{COMMSCOPE}: {degrees} deg at {f}", value, 0.01, "1 N", [float(degrees)], f)
      for degrees, row in BENDS.items() for f, value in zip(COEFFICIENTS, row, strict=True)),
    conduit("machinecalcs.com, conduit pull tension: before the bends", 37.5, 0.05, "elements.0.tension_out_N"),
    conduit("machinecalcs.com: final pull", 112.6, 0.05, "hand_tension_N"),
    conduit("machinecalcs.com: side pressure in lb/ft", 225.0, 0.5, "elements.1.normal_N_m", LB / FT),
    duct("gera.services: straight run", 90.0, 0.5, "elements.0.tension_out_N"),
    duct("gera.services: behind the bend", 144.0, 0.5, "hand_tension_N"),
    duct("gera.services: side pressure in lb/ft", 72.0, 0.5, "elements.1.normal_N_m", LB / FT),
    # Its 9.81 m/s2 is 0.034 % more than the standard gravity.
    straight("dev.to, E. Konkin, cable pulling, example 1", 4905.0, 0.5 + 0.00035 * 4905.0, "500 m", "2.5 kg/m", 0.4),
    straight("dev.to, E. Konkin, cable pulling, example 2", 37.5, 0.05, "300 ft", "0.5 lb/ft", 0.25, LB),
    held("pickedshares.com, exercise 27: 100 kg over 270 deg at 0.2", 382.26, 0.005, "981.0 N", 0.75, 0.2),
    held("openknowledgegraph.com, capstan: 2000 N over 2.5 turns at 0.25", 39.4, 0.05, "2000 N", 2.5, 0.25),
    grown("openknowledgegraph.com, bollard: one turn at 0.3", 6.6, 0.05, "1 N", [360.0], 0.3),
    grown("openknowledgegraph.com, bollard: two turns at 0.3", 43.0, 0.5, "1 N", [720.0], 0.3),
    grown("en.wikipedia.org, Capstan equation: three turns at 1", 153552935.0, 0.5, "1 N", [1080.0], 1.0),
    grown("utilitiesbunker.com, capstan winch: three wraps at 0.25", 111.0, 0.5, "1 N", [1080.0], 0.25),
    grown("tooljolt.com, three dead wraps at 0.1", 6.6, 0.05, "1 N", [1080.0], 0.1),
    # Beer & Johnston print mu = 0.329 to three digits: the force comes back as well as these allow.
    grown("Beer & Johnston, Statics, 11th ed., 8.104: hawser, two turns", 5000.0, 35.0, "80 lbf", [720.0], 0.329, LB),
    grown("novacalculator.com, rope drag: 8 pieces of 25 deg at 0.2", 2.01, 0.005, "1 N", [25.0] * 8, 0.2),
    grown("novacalculator.com, rope drag: with slings", 1.42, 0.005, "1 N", [100.0], 0.2),
    grown("novacalculator.com, rope drag: 10 pieces of 5 deg", 1.19, 0.005, "1 N", [5.0] * 10, 0.2),
    Printed("Pipeline Rules of Thumb Handbook, p. 6: four parts, rounded on the way", 3.25, 0.015, "advantage",
            4 * [run("1 m", carries=True), {"kind": "wheel", "efficiency": 0.917}], {"end_tension": "1000 lbf"},
            friction=mu(0.1)),
    take_up("CEMA wrap factor, bare pulley, 180 deg", 0.84, 0.005, 180.0, 0.25),
    take_up("CEMA wrap factor, lagged pulley, 180 deg", 0.50, 0.005, 180.0, 0.35),
    take_up("CEMA wrap factor, lagged dual drive, 420 deg", 0.08, 0.005, 420.0, 0.35),
    Printed(f"{GIRDER}: stress in ksi after 30 ft", 191.5, 0.05, "elements.0.tension_out_N", TENDON, **STRESSED),
]  # fmt: skip

WORKED = [
    Printed(EN + ": lost of 1000 over 50 m, 0.1 rad, mu 0.2, k 0.01", 1000.0 - 113.0796, 5e-5, "start_tension_N",
            [{"kind": "bend", "angle": "0.1 rad", "length": "50 m", "wobble": "0.01 rad/m"}], {"end_tension": "1000 N"},
            friction=mu(0.2)),
    held("a rope on a drum: 9000 N over 2.5 turns at 0.25", 177.33, 0.005, "9000 N", 2.5, 0.25),
    tackle("n wheels of 0.9: (1 - 0.9^3)/(1 - 0.9)", 2.71, 0.005, [0.9] * 2),
    take_up("1/(e^mu alpha - 1) of DIN 22101: 180 deg at 0.25", 0.838, 0.0005, 180.0, 0.25),
    take_up("1/(e^mu alpha - 1) of DIN 22101: 180 deg at 0.35", 0.499, 0.0005, 180.0, 0.35),
]  # fmt: skip
"""Numbers that nobody printed: a formula of others with values of our own."""


@pytest.mark.parametrize("one", PRINTED + WORKED, ids=lambda one: one.source)
def test_printed(one):
    tree = solved(one.elements, line=one.line, rope=one.rope, friction=one.friction).to_dict()
    found = value_at(tree, one.key) / one.unit
    assert found == pytest.approx(one.value, abs=one.half), f"{one.source}: {found}"


def test_an_anchorage_slip_against_the_square_root_of_the_textbooks():
    """The girder's sheet takes the fall of stress for linear: L = sqrt(w E/p), 0.3677 ksi/ft; here it is exponential."""
    known = {name: STRESSED[name] for name in ("line", "rope", "friction")}
    one = solved(TENDON, **known).to_dict()["anchored"][0]
    assert one["affected_m"] / FT == pytest.approx(48.79, rel=0.035)
    assert one["largest_N"] / KSI == pytest.approx(184.6, rel=0.005)
    assert one["anchor_N"] / KSI == pytest.approx(166.6, rel=0.008)
    assert one["tension_N"][1] / KSI == pytest.approx(177.7, rel=0.008)


def test_sixty_numbers_are_printed_by_others():
    """A manual's table of e^(mu theta) has 36 of them."""
    others = [one.source for one in PRINTED if not one.source.startswith(f"{COMMSCOPE}: ")]
    assert len(PRINTED) >= 60
    assert len(others) >= 25
    assert len({source.partition(",")[0].partition(":")[0] for source in others}) >= 12
