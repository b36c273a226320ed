"""Scenes with mistakes in them: each is refused with its line, its key and a remedy."""

import pytest

from ropefric.errors import DataError
from ropefric.scenes.scene import check_scene, load_scene
from ropefric.scenes.solve import solve_scene


@pytest.fixture(scope="module")
def texts(scenes_folder):
    """The bundled scenes as text, with their fits wherever they are read from."""
    fits = (scenes_folder.parents[1] / "fits").as_posix()
    return {path.stem: path.read_text(encoding="utf-8").replace("../../fits", fits)
            for path in scenes_folder.glob("*.toml")}  # fmt: skip


def line_of(text, words):
    return next(i for i, line in enumerate(text.splitlines(), start=1) if words in line)


def refused(path):
    """Everything that is wrong with a scene, found on reading or on solving it."""
    with pytest.raises(DataError) as caught:
        solve_scene(load_scene(path))
    assert caught.value.problem.path is not None
    return caught.value.problems


# by scene: what stands there, what is put there, text of the line that is named, key, words of message or remedy
MISTAKES = {
    "belt-press": [
        ('"1", "2", "3", "4"', '"1", "2x", "3", "4"', "2x", "belts.upper.loop", "did you mean '2'"),
        ('"200 mm"', '"-200 mm"', "-200", "rollers.6.radius", "not more than 0"),
        ('"131.8 deg"', '"361 deg"', "361 deg", "rollers.6.wrap", "after 360 deg"),
        ('preload  = "2000 N"', 'preload  = "20 N"', "20 N", "press.preload", "goes slack"),
        ('preload  = "2000 N"', "", "[rollers.3.tensioner]", "rollers.3.tensioner", "has no force"),
        ('density = "1500 kg/m^3"', 'density = "1500 kg/m^3"\nlinear_density = "15 kg/m"', "linear_density",
         "belts.upper.linear_density", "density and linear_density are both given"),
        ('"share"', '"shares"', '"shares"', "press.closure", "did you mean 'share'"),
        ('"share" ', '"speed-ratio" ', "[belts.upper]", "belts.upper.axial_stiffness", "speed-ratio"),
        ('"gravity-load"', '"gravity-lode"', "gravity-lode", "effects[0]", "did you mean 'gravity-load'"),
        ('"belt-inertia"', '"belt-elasticity"', "effects  =", "effects", "belts.upper.axial_stiffness"),
        ('"belt-inertia"', '"transient"', "effects  =", "effects", "without start_up"),
        ('"50 rpm"', '"50 rpm"\nspeed = "1 m/s"', "1 m/s", "press.speed", "keep one"),
        ('"50 rpm"', '"-50 rpm"', "-50 rpm", "press.rotation", "not zero or more"),
        ('role = "driver"', 'role = "drivn"', "drivn", "rollers.1.role", "did you mean"),
        ('role = "tensioner"', "", "[rollers.3]", "rollers.3.role", "table of its own"),
        ('"2 m"', '"2 kg"', "2 kg", "belts.upper.width", "not a unit of length"),
        ("mu = 1.2", 'mu = 1.2\nfit = "x.json"', "x.json", "friction.fit", "keep one")
    ],
    "press-start-up": [('inertia = "0.852 kg*m^2"', "", "effects  =", "effects", "rollers.9.inertia"),
                       ('duration = "4 s"', "", 'law = "s-curve"', "start_up.law", "needs duration"),
                       ('duration = "4 s"', 'duration = "4 s"\nintegrator = "rk4"', "rk4", "start_up.integrator",
                        "solved by matrix exponentials")],
    "band-saw-fixed-axles": [('"970 rpm"', '"2100 rpm"', "2100", "wheel.speed", "critical speed")],
    "band-saw": [
        ("mounting_factor = 1.0", "mounting_factor = 1.2", "1.2", "tension.mounting_factor", "0 to 1"),
        ("mounting_factor = 1.0", "mounting_factor = -0.1", "-0.1", "tension.mounting_factor", "0 to 1"),
        ('power = "7.5 kW"', 'tension_difference = "7000 N"', "preload", "tension.preload",
         "raise the preload above 3500 N"),
        ('speed = "970 rpm"', "", "[wheel]", "wheel.speed", 'add speed = "970 rpm"'),
        ('"7.5 kW"', '"7.5 kW"\ntorque = "3 N*m"', "3 N*m", "drive.torque", "power and torque are both given"),
        ('linear_density = "0.5967 kg/m"', "", "[blade]", "blade", 'add linear_density = "0.6 kg/m"'),
        ('linear_density = "0.5967 kg/m"', 'linear_density = "0.5967 kg/m"\ndensity = "7800 kg/m^3"',
         "7800", "blade.density", "keep one of them"),
        ('"1.6 m"', '"1.6 s"', "1.6 s", "blade.free_span", "not a unit of length"),
        ('"clamped"', '"glued"', "glued", "blade.ends", "known: clamped, pinned"),
        ('"22 mm"', '"0 mm"', '"0 mm"', "excitation.tooth_pitch", "not more than 0"),
        ("margin = 0.1", "margin = 2", "margin = 2", "excitation.margin", "not between 0 and 1"),
        ('"2500 N", "6', '"7500 N", "6', "7500 N", "excitation.preload_range", "the lower first"),
        ("[excitation]", '[[measured]]\nside = "rest"\nfrequency = "23.6 Hz"\n\n[excitation]',
         "[[measured]]", "measured", "remove it; compare the frequencies of the answer"),
        ("modes = 6", "modes = 0", "modes", "blade.modes", "from 1 to 40"),
        ('"travel"', '"bendin"', "bendin", "effects[2]", "did you mean 'bending'")
    ],
    "traction": [
        ('groove       = "undercut"', 'groove = "undercutt"', 'groove = "undercutt"',
         "sheave.groove", "did you mean 'undercut'"),
        ('undercut     = "90 deg"', "", 'groove       = "undercut"',
         "sheave.groove", "undercut does not fit the groove undercut"),
        ('groove       = "undercut"', 'groove = "v-hardened"', 'groove = "v-hardened"',
         "sheave.groove", "undercut does not fit the groove v-hardened"),
        ('"700 kg"', "700", "car           = 700", "lift.car", '"700 kg"'),
        ("count          = 4", "count = 0", "count = 0", "ropes.count", "whole number from 1 to 100"),
        ("above_car ", "abov_car ", 'abov_car           = "2 m"', "ropes.abov_car", "did you mean 'above_car'"),
        ('"90 deg"', '"150 deg"', 'undercut     = "150 deg"', "sheave.undercut", "nothing is left to carry the rope"),
        ('"35 deg"', '"181 deg"', 'groove_angle = "181 deg"', "sheave.groove_angle", "no angle of a groove"),
        ('"0.5 m/s^2"', '"9.9 m/s^2"', 'deceleration  = "9.9 m/s', "lift.deceleration", "without tension"),
        ('"auto"', '["wrap-dependence"]', 'effects  = ["wrap-depend',
         "effects", "cannot be simulated without friction"),
        ('"auto"', '["sped"]', 'effects  = ["sped"]', "effects[0]", "did you mean 'speed'")
    ],
    "belt-drive": [
        ('closure = "limit"', 'closure = "limt"', 'closure = "limt"', "tension.closure", "did you mean 'limit'"),
        ('speed    = "1500 rpm"', "", 'power = "120 kW"', "load.power", "load.power needs driving.speed"),
        ('"5250 N"', "5250", "force   = 5250", "tension.force", '"5250 N"'),
        ("count           = 2", "count = 2.5", "count = 2.5", "belt.count", "whole number from 1 to 1000"),
        ("groove_angle ", "grove_angle ", 'grove_angle    = "30 deg"',
         "belt.grove_angle", "did you mean 'groove_angle'"),
        ('"30 deg"', '"200 deg"', 'groove_angle    = "200 d',
         "belt.groove_angle", "of 200 deg from flank to flank is no wedge"),
        ('"1500 rpm"', '"9000 rpm"', 'speed    = "9000 rpm"', "driving.speed", "lifts off the pulley"),
        ('"1500 rpm"', '"1500 1/min"', 'speed    = "1500 1/min"', "driving.speed", "use a unit such as 'rpm'"),
        ('"auto"', '["crep"]', 'effects  = ["crep"]', "effects[0]", "did you mean 'creep'"),
        ('"auto"', '["bending"]', 'effects  = ["bending"]', "effects[0]", "unknown effect of a belt drive"),
        ("mu = 0.12", "mu = 90", 'wrap     = "180 deg"', "driving.wrap", "no ratio of tensions")
    ],
    "cable-pull": [
        ('kind = "bend"', 'kind = "bent"', 'kind = "bent"', "element[1].kind", "did you mean 'bend'?"),
        ('length = "45 m"', "", "[[element]]", "element[0]", "a run needs its length"),
        ('length = "45 m"', 'length = "45 m"\nangle = "1 rad"', 'angle = "1 rad"',
         "element[0].angle", "a run has no angle"),
        ('angle = "90 deg"', "angle = 90", "angle = 90", "element[1].angle", '"90 deg"'),
        ('radius = "0.9 m"', 'radus = "0.9 m"', 'radus = "0.9 m"', "element[1].radus", "did you mean 'radius'?"),
        ('"run"\nname = "manhole to street"\nlength = "45 m"',
         '"bend"\nangle = "1 rad"\nnormal_limit = "1 kN/m"', "[[element]]", "element[0]", 'add radius = "300'),
        ('start_tension = "50 lbf"', "", "[line]", "line.start_tension", "known at neither end"),
        ('start_tension = "50 lbf"', 'start_tension = "50 lbf"\nend_tension = "9 N"', 'end_tension = "9 N"',
         "line.end_tension", "both given"),
        ('start_tension = "50 lbf"', 'start_tension = "-50 lbf"', 'start_tension = "-50 lbf"',
         "line.start_tension", "not zero or more"),
        ('start_tension = "50 lbf"', 'start_tension = "50 lbf"\npull = "9 N"', 'pull = "9 N"',
         "line.pull", "drums with a share"),
        ('tension_limit = "4 kN"', 'anchorage_slip = "1 mm"', 'anchorage_slip = "1 mm"',
         "line.anchorage_slip", "needs rope.axial_stiffness"),
        ("[friction]\nmu = 0.3", "", "[[element]]", "element.0", "no friction is given for"),
        ("mu = 0.3", "mu = -0.3", "mu = -0.3", "friction.mu", "not zero or more")
    ],
    "climbing-hoist": [('end_tension = "80 N"', "", "[load]", "load.end_tension", "for the payload")]
}  # fmt: skip


CODES = {"did you mean": "RF120 RF520", "has no angle": "RF120", "unknown": "RF120", "both given": "RF111",
         "known at": "RF121", "needs": "RF121", "add ": "RF121", "not zero or more": "RF110",
         "not a unit": "RF130"}  # fmt: skip


def test_a_mistake_is_refused_with_line_key_and_remedy(texts, scene_file):
    mistakes = [(scene, *one) for scene, several in MISTAKES.items() for one in several]
    for mistake in mistakes:
        scene, old, new, there, key, words = mistake
        assert old in texts[scene], mistake
        text = texts[scene].replace(old, new, 1)
        if scene == "press-start-up":
            text = text.replace('effects  = "auto"', 'effects  = ["belt-elasticity", "transient"]')
        told = next((one for one in refused(scene_file(text)) if one.key == key), None)
        assert told is not None, mistake
        assert words in f"{told.message} {told.fix}", mistake
        assert told.line == line_of(text, there), mistake
        assert all(told.code in codes for said, codes in CODES.items() if said in words), mistake


@pytest.mark.parametrize(
    ("scene", "changes"),
    [("belt-press", {'"175 mm"': "175", '"28.1 deg"': '"28.1 N"', "mu = 1.2": "mu = -1", "width": "widht"}),
     ("band-saw",
      {'"1.6 m"': "1.6", '"0.7 m"': '"0.7 rpm"', "modes = 6": "modes = 60", '"clamped"': '"glued"'})]
)  # fmt: skip
def test_everything_is_said_at_once(texts, scene_file, scene, changes):
    text = texts[scene]
    lines = set()
    for old, new in changes.items():
        text = text.replace(old, new, 1)
        lines.add(line_of(text, new))
    problems = check_scene(scene_file(text))
    assert lines <= {one.line for one in problems}
    assert [one.line for one in problems] == sorted(one.line for one in problems)


def test_all_data_that_a_closure_lacks_are_named_together(texts, scene_file):
    text = texts["belt-press"].replace('"share"', '"speed-ratio"', 1)
    keys = {one.key for one in refused(scene_file(text))}
    assert keys == {"belts.upper.axial_stiffness", "belts.lower.axial_stiffness", "rollers.1.overspeed",
                    "rollers.10.overspeed"}  # fmt: skip


def test_all_data_that_a_start_up_lacks_are_named_together(texts, scene_file):
    text = texts["press-start-up"].replace('effects  = "auto"', 'effects  = ["transient"]')
    for gone in ('inertia = "14.455 kg*m^2"', 'mass = "121 kg"', 'axial_stiffness = "2000 kN"'):
        text = text.replace(gone, "", 1)
    (told,) = refused(scene_file(text))
    for key in ("rollers.5.inertia", "rollers.3.tensioner.mass", "belts.upper.axial_stiffness"):
        assert key in told.message
