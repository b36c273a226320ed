"""Spans follow from loops; what does not make a machine is refused, everything at once and by name."""

from dataclasses import replace

import numpy as np
import pytest
from paper import with_roller

from ropefric.errors import DataError
from ropefric.systems.press.machine import Press, Roller


def with_belt(press, which, **changes):
    return replace(press, belts=tuple(replace(b, **changes) if b.name == which else b for b in press.belts))


def test_spans_are_numbered_as_in_the_paper(paper_press):
    ends = {span.name: (span.start, span.end) for span in paper_press.spans}
    wanted = {str(i): (str(i), str(i + 1)) for i in range(1, 9)}
    wanted |= {"9": ("9", "1"), "10": ("9", "10"), "11": ("10", "11"), "12": ("11", "12")}
    assert ends == wanted | {"13": ("12", "13"), "14": ("13", "5")}
    assert [span.name for span in paper_press.spans if len(span.belts) == 2] == ["5", "6", "7", "8"]


def test_the_graph_writes_the_balances_of_the_paper(paper_press, paper_data):
    rng = np.random.default_rng(1)
    T = dict(zip(range(1, 15), rng.uniform(500, 4000, 14), strict=True))
    net = dict(zip(range(1, 14), paper_press.incidence @ np.array(list(T.values())), strict=True))
    for i in (2, 3, 4, 6, 7, 8):
        assert net[i] == pytest.approx(T[i] - T[i - 1])  # (10), (11), (13)-(15), (19)
    assert net[5] == pytest.approx(T[5] - T[4] - T[14])  # (12)
    assert net[9] == pytest.approx(T[9] + T[10] - T[8])  # (16)
    for i in (11, 12, 13):
        assert net[i] == pytest.approx(T[i + 1] - T[i])  # (17), (18), (20)
    assert (net[1], net[10]) == pytest.approx((T[1] - T[9], T[11] - T[10]))
    pulls = paper_press.pull @ np.array(list(T.values()))
    upper = T[2] + T[3] * np.cos(paper_data["beta"])
    assert pulls == pytest.approx([upper, T[14] + T[13] * np.cos(paper_data["gamma"])])  # (21), (22)


def test_belts_weigh_in_every_span_they_run_in(paper_press):
    np.testing.assert_allclose(paper_press.density_kg_m, [15.0] * 4 + [30.0] * 4 + [15.0] * 6)
    np.testing.assert_array_equal(paper_press.carried.sum(axis=1), [9, 9])


WRONG = {
    "negative radius": (lambda p: with_roller(p, "4", radius_m=-0.1),
                        "rollers.4.radius_m is -0.1; it must be finite and positive"),
    "radius not a number": (lambda p: with_roller(p, "4", radius_m=float("nan")),
                            "rollers.4.radius_m is nan"),
    "wrap above a turn": (lambda p: with_roller(p, "6", wrap_angle_rad=6.5),
                          "roller '6' is wrapped 372.423 deg"),
    "overspeed of a driven roller": (lambda p: with_roller(p, "4", overspeed=0.1),
                                     "roller '4' is no driver"),
    "inertia of zero": (lambda p: with_roller(p, "4", inertia_kg_m2=0.0), "rollers.4.inertia_kg_m2 is 0"),
    "empty name": (lambda p: with_roller(p, "4", name=""), "one of the rollers has an empty name"),
    "name with a point": (lambda p: with_roller(p, "4", name="4.5"), "the name '4.5' of one of the rollers has a point"),
    "unknown roller": (lambda p: with_belt(p, "upper", loop=("1", "22", "3")), "unknown roller '22'"),
    "not closed": (lambda p: with_belt(p, "upper", loop=("1",)), "belt 'upper' is not closed"),
    "first roller again": (lambda p: with_belt(p, "upper", loop=(*p.belts[0].loop, "1")),
                           "belt 'upper' names roller '1' 2 times"),
    "roller on no belt": (lambda p: replace(p, rollers=(*p.rollers, replace(p.rollers[3], name="spare"))),
                          "no belt runs over roller 'spare'"),
    "shared driver": (lambda p: with_roller(p, "7", role="driver"),
                      "driver '7' is shared by the belts upper, lower"),
    "shared tensioner between spans": (lambda p: with_roller(
                                           p, "5", role="tensioner", tensioner=p.tensioners["3"]
                                       ),
                                       "2 spans meet tensioner '5' on one side"),
    "nothing drives": (lambda p: replace(p,
                                         rollers=(*p.rollers,
                                                  Roller(name="a", radius_m=1, wrap_angle_rad=3),
                                                  Roller(name="b", radius_m=1, wrap_angle_rad=3)),
                                         belts=(*p.belts,
                                                replace(p.belts[0], name="idle", loop=("a", "b")))),
                       "nothing drives belt 'idle'"),
    "density": (lambda p: with_belt(p, "upper", linear_density_kg_m=-1.0),
                "belts.upper.linear_density_kg_m is -1"),
    "stiffness": (lambda p: with_belt(p, "upper", axial_stiffness_N=0.0),
                  "belts.upper.axial_stiffness_N is 0"),
    "lengths": (lambda p: with_belt(p, "upper", span_lengths_m=(1.0, 2.0)),
                "belt 'upper' has 9 spans and 2 lengths"),
    "lengths disagree": (lambda p: replace(
                             p,
                             belts=(replace(p.belts[0], span_lengths_m=(1.0,) * 9),
                                    replace(p.belts[1], span_lengths_m=(1.0,) * 5 + (2.0,) * 4))
                         ),
                         "run together from roller '5' to '6', but their lengths there are 1 m and 2 m"),
    "speed": (lambda p: replace(p, speed_m_s=float("inf")), "speed_m_s is inf"),
    "no belts": (lambda p: replace(p, belts=()), "a press without belts moves nothing"),
    "slack geometry": (lambda p: with_roller(
                           p, "3", tensioner=replace(p.tensioners["3"], downstream_angle_rad=np.pi)
                       ),
                       "do not pull along the travel"),
    "negative preload": (lambda p: with_roller(p, "3", tensioner=replace(p.tensioners["3"], force_N=-1.0)),
                         "rollers.3.tensioner.force_N is -1")
}  # fmt: skip


def test_what_is_wrong_is_named(paper_press):
    for name, (breaks, message) in WRONG.items():
        with pytest.raises(DataError) as refused:
            breaks(paper_press)
        problems = refused.value.problems
        assert any(message in problem.message for problem in problems), (name, problems)
        assert all(problem.code == "RF520" and problem.key for problem in problems), name


def test_everything_wrong_is_found_at_once(paper_press):
    with pytest.raises(DataError) as refused:
        Press(rollers=(replace(paper_press.rollers[0], radius_m=-1.0),
                       replace(paper_press.rollers[1], wrap_angle_rad=0.0)),
              belts=(replace(paper_press.belts[0], loop=("1", "2", "33"), width_m=0.0),), speed_m_s=-1.0)  # fmt: skip
    keys = {problem.key for problem in refused.value.problems}
    assert keys == {
        "speed_m_s", "rollers.1.radius_m", "rollers.2.wrap_angle_rad", "belts.upper.loop", "belts.upper.width_m",
    }  # fmt: skip
