"""What a fit's covariance does to a press and to a saw, against drawing the parameters at random."""

from dataclasses import replace

import numpy as np
import pytest

from ropefric.scenes.draws import draw_scene
from ropefric.scenes.scene import load_scene
from ropefric.scenes.solve import solve_scene
from ropefric.scenes.sweep import parse_axis, sweep_scene

DRAWS = 300


@pytest.fixture(scope="module")
def saw(scenes_folder):
    """The fast saw with a law of the rope laboratory on its wheel."""
    friction = {"fit": "../../fits/prth-coupled.json"}
    return load_scene(scenes_folder / "fast-band-saw.toml", {"friction": friction})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "names"),
    [("press", ["slip.2.utilisation", "slip.5.utilisation", "slip.10.utilisation"]),
     ("saw", ["wheel.utilisation"])],
)  # fmt: skip
def test_grip_is_as_uncertain_as_drawn_parameters_make_it(loaded, saw, machine, names):
    """A std from N draws scatters by 1/√(2N); 4 of these, and a tenth for what is not linear."""
    scene = loaded("fast-belt-press") if machine == "press" else saw
    # A blade's stiffness takes its time and has no part in friction.
    plain = tuple(set(solve_scene(scene).plan.simulated) - {"bending"})
    plain = scene.table.model_copy(update={"effects": plain})
    drawn = draw_scene(replace(scene, table=plain), DRAWS, seed=1)
    assert drawn.answered > 0.98 * DRAWS
    by_name = {one.name: one for one in solve_scene(scene).quantities}
    for name in names:
        one, samples = by_name[name], drawn.columns[name]
        noise = 4.0 / np.sqrt(2 * DRAWS) + 0.1
        assert one.std[0] == pytest.approx(np.nanstd(samples, ddof=1), rel=noise), name
        low, high = one.interval[0]
        assert low < one.value[0] < high
        assert 0.89 < np.mean((samples > low) & (samples < high)) <= 1.0, name


def test_the_uncertainty_stands_beside_the_numbers_that_friction_has_a_part_in(loaded, saw):
    press, blade = solve_scene(loaded("fast-belt-press")), solve_scene(saw)
    for solution, exact in ((press, "effective_tension_N.9"), (blade, "tight.first_frequency_Hz")):
        one = next(one for one in solution.quantities if one.name == exact)
        assert one.std[0] == pytest.approx(0.0, abs=1e-9 * one.value[0])
        assert solution.to_dict()["extrapolated"] is True, "a belt and a blade are not what was tested"
        assert any(warning.startswith("extrapolated: ") for warning in solution.warnings)
    slip = press.to_dict()["slip"]["2"]
    low, high = slip["utilisation_interval"]
    assert low < slip["utilisation"] < high
    assert slip["utilisation_std"] > 0.0
    wheel = blade.to_dict()["wheel"]
    assert {"utilisation", "utilisation_std", "utilisation_interval"} == set(wheel)


def test_a_wheel_that_nothing_presses_on_has_no_grip_for_certain(scene_of):
    """A stiff blade faster than its string: what is used of a grip of nothing is infinite, whatever the friction."""
    scene = scene_of(system="bandsaw", effects="all",
                     blade={"free_span": "0.3 m", "width": "85 mm", "thickness": "0.9 mm",
                            "density": "7800 kg/m^3", "youngs_modulus": "206 GPa",
                            "shear_modulus": "79.4 GPa"},
                     wheel={"radius": "0.35 m", "speed": "128 rad/s"}, tension={"preload": "1000 N"},
                     drive={"tension_difference": "100 N"},
                     friction={"fit": "../../fits/prth-coupled.json"})  # fmt: skip
    solution = solve_scene(scene)
    use = next(one for one in solution.quantities if one.name == "wheel.utilisation")
    assert np.isinf(use.value[0])
    assert use.std[0] == 0.0
    assert solution.to_dict()["wheel"] == {"utilisation": None}
    swept = sweep_scene(scene, (parse_axis(scene, "tension.preload=950N:1000N:3"),))
    assert np.isinf(swept.columns["wheel.utilisation"]).all()
