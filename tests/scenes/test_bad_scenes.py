"""Press and saw scenes with mistakes in them: each is refused with its line, its key and a remedy."""

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
    "climbing-hoist": [('end_tension = "80 N"', "", "[load]", "load.end_tension", "for the payload")]
}  # fmt: skip


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
