"""The bundled press gives the paper's numbers of slip; every answer has the fields of the contract."""

import pytest

from ropefric.errors import DataError
from ropefric.scenes.solve import solve_scene

# Slip at 50 rpm, 2000 N and mu = 1.2: as_printed, as_plotted, utilisation, log, mu_required.
SLIP = {"1": (0.0627, 0.0098, 0.03787, 0.24892, 0.2987), "2": (0.8715, 1.7869, 0.53901, 0.61003, 0.7320),
        "3": (0.0260, 0.0440, 0.01020, 0.07708, 0.0925), "4": (1.2479, 1.2479, 0.0, 0.0, 0.0),
        "5": (0.3904, 0.4932, 0.05439, 0.09840, 0.1181), "6": (0.0645, 0.0707, 0.00316, 0.01657, 0.0199),
        "7": (0.0371, 0.0405, 0.00173, 0.01330, 0.0160), "8": (0.0461, 0.0501, 0.00205, 0.01359, 0.0163),
        "9": (0.1674, 0.1814, 0.00715, 0.02107, 0.0253), "10": (0.3033, 0.1628, 0.08111, 0.18254, 0.2190),
        "11": (0.2327, 0.2327, 0.0, 0.0, 0.0), "12": (0.3535, 0.3535, 0.0, 0.0, 0.0),
        "13": (0.0740, 0.0796, 0.00283, 0.01371, 0.0165)}  # fmt: skip
HALF_DIGIT = {"as_printed": 5e-5, "as_plotted": 5e-5, "utilisation": 5e-6, "log": 5e-6, "mu_required": 5e-5}


@pytest.fixture(scope="module")
def press(loaded):
    return solve_scene(loaded("belt-press")).to_dict()


def test_slip_by_every_measure(press):
    for roller, all_wanted in SLIP.items():
        for (measure, tolerance), wanted in zip(HALF_DIGIT.items(), all_wanted, strict=True):
            found = press["slip"][roller][measure]
            assert found == pytest.approx(wanted, abs=tolerance * 1.001), (roller, measure)


def test_roller_2_is_first_to_slip_and_what_makes_it(press):
    assert press["first_to_slip"] == "2"
    assert press["slips"] == []
    assert press["critical"]["preload"]["roller"] == "2"
    assert press["critical"]["preload"]["value"] == pytest.approx(1276.6, abs=0.05)
    assert press["critical"]["friction"]["value"] == pytest.approx(0.732, abs=5e-4)
    assert press["rank"] == 13
    assert len(press["undetermined"]) == 1
    assert press["power_W"] == pytest.approx(1673.8, abs=0.05)
    assert press["loads"]["total_N"] == pytest.approx(1826.667, abs=5e-4)


# The contract of the JSON shape: fields may be added, not renamed.
SHARED = {"system", "effects", "error_bound", "extrapolated", "method", "accuracy", "warnings", "level"}
CONTRACT = {"hoist": {"lift_force_N", "std_N", "interval_N"},
            "belt-press": {"tension_N", "effective_tension_N", "slip", "first_to_slip"},
            "band-saw": {"tight", "slack", "rest"}}  # fmt: skip


@pytest.mark.parametrize("name", CONTRACT)
def test_the_fields_of_the_contract(loaded, name):
    tree = solve_scene(loaded(name)).to_dict()
    assert SHARED | CONTRACT[name] <= set(tree)
    assert {"simulated", "left_out"} <= set(tree["effects"])
    if name == "belt-press":
        assert {"as_printed", "as_plotted", "utilisation", "log", "mu_required"} <= set(tree["slip"]["2"])
    if name == "band-saw":
        for side in ("tight", "slack", "rest"):
            assert {"frequencies_Hz", "critical_speed_m_s"} <= set(tree[side])


def test_loads_from_the_sludge_are_the_torques_of_its_equations(loaded, scene_of):
    """Eqs. (5)-(9): μ_f ρ g h b L R of the weight, and b R Δh (1 + μ_c) σ_c²/(3 E_c) for each squeeze."""
    tree = dict(loaded("belt-press").document.data)
    rollers = {name: dict(one) for name, one in tree["rollers"].items()}
    for name, key in (("2", "gravity_torque"), ("6", "squeeze_torque")):
        rollers[name].pop(key, None)
    sludge = {"gravity": {"friction": 0.25, "height": "60 mm", "density": "1000 kg/m^3", "width": "2 m",
                          "zones": {"2": "1.2 m"}},
              "squeeze": {"width": "2 m", "compression": "10 mm", "strength": "30 kPa", "poisson_ratio": 0.3,
                          "youngs_modulus": "300 kPa", "units": {"6": 2}}}  # fmt: skip
    press = scene_of(**tree | {"rollers": rollers, "sludge": sludge}).problem.press
    found = {one.name: one for one in press.rollers}
    wanted = 0.25 * 1000.0 * 9.80665 * 0.06 * 2.0 * 1.2 * found["2"].radius_m
    assert found["2"].gravity_torque_N_m == pytest.approx(wanted, rel=1e-3)
    wanted = 2.0 * found["6"].radius_m * 2 * 0.01 * (1.0 + 0.3) * 30e3**2 / (3.0 * 300e3)
    assert found["6"].squeeze_torque_N_m == pytest.approx(wanted, rel=1e-12)
    sludge["squeeze"]["units"] = {"99": 1}
    with pytest.raises(DataError, match="names the unknown roller '99'"):
        scene_of(**tree | {"rollers": rollers, "sludge": sludge})
