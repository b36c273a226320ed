import pytest
from paper import law_of

from ropefric.systems.effect import assemble
from ropefric.systems.hoist.contact import HoistProblem
from ropefric.systems.hoist.effects import SYSTEM

COUPLED = (0.46, -0.22, -0.3, -0.48, 0.055)


@pytest.fixture(scope="session")
def coupled():
    """The law of the bundled campaign, with a reference amid its tests."""
    return law_of("coupled", COUPLED, (0.05, 0.0049, 6.0, 60.0))


@pytest.fixture(scope="session")
def full_problem(coupled):
    """A hoist that has data for every effect."""
    return HoistProblem(friction=coupled, wheel_radius_m=0.04, rope_radius_m=0.0049, wrap_angle_rad=9.42,
                        end_tension_N=80.0, speed_m_s=3.0, linear_density_kg_m=0.062, hanging_length_m=5.0,
                        bending_stiffness_N_m2=1e-3)  # fmt: skip


@pytest.fixture(scope="session")
def solved():
    """A function: solve a problem with the named effects."""

    def solve(problem, effects=None):
        names = list(SYSTEM.effects) if effects is None else effects
        model = assemble(SYSTEM, problem, names)
        return SYSTEM.solve(model, SYSTEM.method(model, 0.01))

    return solve
