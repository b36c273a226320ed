"""Elastic creep in the closures of a press: belts that never meet, and belts that meet twice."""

import pytest

from ropefric.errors import InputError
from ropefric.systems.press.machine import Belt, Press, Roller, Tensioner
from ropefric.systems.press.statics import solve_statics, steady_state


def machine_of(**loops):
    """Belts by their loops of one-letter rollers: a and d drive, c and t tighten, b and e are loaded."""
    carrier = Tensioner(spring_N_m=1e4, travel_m=0.01, force_N=900.0)
    roles = {"a": "driver", "d": "driver", "c": "tensioner", "t": "tensioner"}
    rollers = [Roller(name=name, radius_m=0.1, wrap_angle_rad=2.0, role=roles.get(name, "driven"),
                      squeeze_torque_N_m=20.0 * (name in "be"), tensioner=carrier if name in "ct" else None,
                      overspeed={"a": 0.0, "d": 3e-4}.get(name))
               for name in sorted(set("".join(loops.values())))]  # fmt: skip
    belts = [Belt(name=name, loop=tuple(loop), linear_density_kg_m=1.0, thickness_m=0.005, width_m=1.0,
                  axial_stiffness_N=1e6 * place)
             for place, (name, loop) in enumerate(loops.items(), start=1)]  # fmt: skip
    return Press(rollers=tuple(rollers), belts=tuple(belts), speed_m_s=1.0)


def test_creep_says_nothing_of_belts_that_never_meet():
    for closure in ["share", "speed-ratio"]:
        with pytest.raises(InputError, match=f"'{closure}' does not settle"):
            solve_statics(machine_of(one="abc", other="def"), closure=closure)


def test_belts_that_meet_and_part_twice_creep_alike_at_both_places():
    press = machine_of(one="abefc", other="dehft")
    state = steady_state(solve_statics(press, closure="speed-ratio"), speed_m_s=0.0)
    spans = {
        (span.start, span.end): tension for span, tension in zip(press.spans, state.tension_N, strict=True)
    }
    behind_e, behind_f = ([(spans[driver, way] - spans[place, by]) / (1e6 * EA)
                           for driver, way, place, by, EA in two]
                          for two in ((("c", "a", "b", "e", 1), ("t", "d", "d", "e", 2)),
                                      (("c", "a", "e", "f", 1), ("t", "d", "h", "f", 2))))  # fmt: skip
    for one, other in (behind_e, behind_f):
        assert one - other == pytest.approx(-3e-4, rel=1e-9)
