"""Scene files: what is wrong is said all at once, with line, key and remedy; what is right is read as it stands."""

import math

import pytest

from ropefric.errors import DataError
from ropefric.scenes.scene import check_scene, load_scene
from ropefric.scenes.solve import solve_scene

GOOD = """system   = "hoist"
accuracy = 0.01
effects  = "auto"
[wheel]
radius = "40 mm"
wrap   = "540 deg"
speed  = "0.3 m/s"
[rope]
diameter = "9.8 mm"
linear_density = "62 g/m"
[load]
end_tension = "80 N"
[friction]
mu = 0.2
"""


def test_the_keys_of_the_handbook_are_read_in_si(scene_file):
    scene = load_scene(scene_file(GOOD))
    problem = scene.problem
    assert problem.wheel_radius_m[0] == 0.04
    assert problem.rope_radius_m[0] == 0.0049
    assert problem.wrap_angle_rad[0] == pytest.approx(3.0 * math.pi, rel=1e-15)
    assert problem.linear_density_kg_m[0] == 0.062
    assert (problem.end_tension_N[0], problem.speed_m_s[0]) == (80.0, 0.3)


def test_accuracy_and_effects_have_defaults(scene_file):
    text = GOOD.replace("accuracy = 0.01\n", "").replace('effects  = "auto"\n', "")
    scene = load_scene(scene_file(text))
    assert (scene.accuracy, scene.effects) == (0.01, "auto")


def test_what_is_wrong_has_its_line_its_code_and_its_remedy(scene_file):
    for old, new, line, code, words in [
        ('"hoist"', '"hosit"', 1, "RF120", "did you mean 'hoist'?"),
        ("0.01", "0", 2, "RF501", "above 0 and at most 1"),
        ("0.01", "-0.5", 2, "RF501", "above 0 and at most 1"),
        ("0.01", "1.5", 2, "RF501", "above 0 and at most 1"),
        ("0.01", "nan", 2, "RF110", "expected a number"),
        ('"auto"', '["centrifugla"]', 3, "RF120", "did you mean 'centrifugal'?"),
        ('"auto"', '"centrifugal"', 3, "RF110", "a list"),
        ('"auto"', '["size", "size"]', 3, "RF111", "twice"), ('"40 mm"', "40", 5, "RF130", '"40 mm"'),
        ('"40 mm"', '"40 N"', 5, "RF130", "length"), ('"40 mm"', '"-40 mm"', 5, "RF110", "not more than 0"),
        ("wrap   =", "warp   =", 6, "RF120", "did you mean 'wrap'?"),
        ('end_tension = "80 N"', 'payload = "120 kg"', 11, "RF121", "end_tension"),
        ("mu = 0.2", "mu = -0.2", 14, "RF110", "not zero or more"),
        ("mu = 0.2", "", 13, "RF121", "none of mu, law, fit is given"),
        ("mu = 0.2", 'mu = 0.2\nlaw = "constant"', 15, "RF111", "both given"),
        ("mu = 0.2", 'law = "wrap-powr"', 14, "RF120", "did you mean 'wrap-power'?"),
        ("mu = 0.2", 'law = "wrap-power"', 13, "RF121", "a = …, b = …, c = …"),
        ("mu = 0.2", 'law = "wrap-power"\nparameters = { a = 0.2, b = -0.5, d = 1 }', None, "", "d"),
        ("mu = 0.2", 'fit = "nowhere.json"', 14, "RF101", "no fit 'nowhere.json'"),
        ("mu = 0.2", 'mu = 0.2\nscale_to = { mu = 1, wrap = "1 turn" }', 15, "RF111", "mu and scale_to are both given")
    ]:  # fmt: skip
        path = scene_file(GOOD.replace(old, new, 1))
        problems = check_scene(path)
        told = next(problem for problem in problems if words in str(problem))
        if line is not None:
            assert (told.line, told.code) == (line, code), old


def test_a_file_without_system_says_which_there_are(scene_file):
    with pytest.raises(DataError, match="hoist"):
        load_scene(scene_file("accuracy = 0.01\n"))


def test_a_rope_that_lifts_off_is_refused_with_the_file(scene_file):
    scene = load_scene(scene_file(GOOD.replace('"0.3 m/s"', '"40 m/s"').replace('"auto"', '["centrifugal"]')))
    with pytest.raises(DataError, match=r"scene\.toml.*lifts off"):
        solve_scene(scene)
