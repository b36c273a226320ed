"""Loads from sludge data, and what the printed torques stand for."""

import numpy as np
import pytest

from ropefric.errors import InputError
from ropefric.systems.press.machine import GRAVITY_M_S2, gravity_torque_N_m, squeeze_torque_N_m
from ropefric.systems.press.statics import solve_statics, steady_state


def test_the_printed_squeeze_torques_stand_for_one_product(paper_press, paper_data):
    rollers = [roller for roller in paper_press.rollers if roller.squeeze_torque_N_m]
    assert [roller.name for roller in rollers] == ["5", "6", "7", "8", "9"]
    units = [2, 1, 1, 1, 1]
    product = [roller.squeeze_torque_N_m / (n * paper_data["belt_width"] * roller.radius_m)
               for roller, n in zip(rollers, units, strict=True)]  # fmt: skip
    np.testing.assert_allclose(product, 84.000, rtol=1e-12)
    loss_m = paper_data["sludge_height"] - paper_data["cake_height"]
    # K_max = 1.5 σ²/(3 E) = 84 N/m over the compression.
    back = squeeze_torque_N_m(belt_width_m=paper_data["belt_width"],
                              radius_m=[roller.radius_m for roller in rollers], compression_m=loss_m,
                              strength_Pa=168.0 / loss_m, poisson_ratio=0.5,
                              youngs_modulus_Pa=168.0 / loss_m, units=units)  # fmt: skip
    np.testing.assert_allclose(back, [84.0, 33.6, 29.4, 25.2, 16.8], rtol=1e-12)


def test_the_printed_gravity_torques_stand_for_two_zones(paper_press, paper_data):
    for roller, pull_N, drag_kg_m2 in [("2", 349.333, 296.75), ("3", 349.333, 296.75), ("5", 60.000, 50.97),
                                       ("13", 60.000, 50.97)]:  # fmt: skip
        part = next(each for each in paper_press.rollers if each.name == roller)
        assert part.gravity_torque_N_m / part.radius_m == pytest.approx(pull_N, abs=5e-4), roller
        height_m = paper_data["sludge_height"]
        arm_m2 = part.radius_m * paper_data["belt_width"]
        product = part.gravity_torque_N_m / (arm_m2 * height_m * GRAVITY_M_S2)
        assert product == pytest.approx(drag_kg_m2, abs=5e-3), roller
        torque = gravity_torque_N_m(sludge_friction=0.25, belt_width_m=paper_data["belt_width"],
                                    sludge_height_m=height_m, sludge_density_kg_m3=1000.0,
                                    zone_length_m=product / 250.0, radius_m=part.radius_m)  # fmt: skip
        assert float(torque) == pytest.approx(part.gravity_torque_N_m), roller


def test_distortion_energy():
    """K_max = (1 + μ_c) σ_c²/(3 E_c), eq. (7)."""
    of_one = {"belt_width_m": 1.0, "radius_m": 1.0, "compression_m": 1.0}
    energy = squeeze_torque_N_m(**of_one, strength_Pa=[3e4, 6e4], poisson_ratio=0.3, youngs_modulus_Pa=2e5)
    np.testing.assert_allclose(energy, [1.3 * 9e8 / 6e5, 1.3 * 36e8 / 6e5])
    with pytest.raises(InputError, match="poisson_ratio is"):
        squeeze_torque_N_m(**of_one, strength_Pa=1.0, poisson_ratio=-0.3, youngs_modulus_Pa=1.0)


def test_all_loads_together_and_their_power(paper_press):
    pulls_N = [roller.torque_N_m / roller.radius_m for roller in paper_press.rollers]
    assert sum(pulls_N) == pytest.approx(1826.667, abs=5e-4)
    state = steady_state(solve_statics(paper_press))
    assert float(state.drive_power_W) == pytest.approx(1673.8, abs=0.05)
    # The same from the other end: what the motors turn.
    supplied_N = -(paper_press.incidence @ state.effective_tension_N)[~paper_press.is_driven]
    assert supplied_N.sum() == pytest.approx(sum(pulls_N))


def test_power_grows_with_load_and_speed(paper_press):
    statics = solve_statics(paper_press)
    state = steady_state(statics, load_factor=[[0.5], [1.0]], speed_m_s=[0.0, 1.0])
    np.testing.assert_allclose(state.drive_power_W, [[0.0, 913.3333], [0.0, 1826.6667]], rtol=1e-6)
