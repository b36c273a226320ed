"""A stiff rope in a scene: next to no stiffness, as much as it can follow, and a wrap it hardly touches."""

import math

import mpmath as mp
import pytest
from hard_hoist import DENSITY, SPEED, lifted, rope, true_log_lift
from hard_regime import Regime, once, relative

from ropefric.friction.laws.bending import lifted_arc_rad

REGIME = Regime(
    name="stiff rope",
    statement="a hoist with EI/(2R²) of 1e-3 … 1e-300 F_B and 1e-3 … 1e-16 below F_B, and a wrap 1e-3 … 1e-14 above "
    "the arcs that stand off, μ = 0.1 … 3, at rest and running: ln F_A",
    accuracy=1e-12,
)
TENSION, WRAP = 64.0, 9.0
LEFT = {False: TENSION, True: TENSION - DENSITY * SPEED**2}  # what presses and bends, by whether it runs


def cases():
    """Yield the keywords of a rope."""
    for moving, pulling in LEFT.items():
        for mu in (0.1, 3.0):
            for ratio in (1e-3, 1e-12, 1e-100, 1e-300):
                yield {"mu": mu, "wrap": WRAP, "stiffness_N": pulling * ratio, "moving": moving}
            for below in (2.0**-10, 2.0**-30, 2.0**-53):
                yield {"mu": mu, "wrap": WRAP, "stiffness_N": pulling * (1.0 - below), "moving": moving}
            for share in (2.0**-20, 0.375, 1.0 - 2.0**-10):
                for above in (1e-3, 1e-8, 1e-14):
                    arcs = 2.0 * float(lifted_arc_rad(share))
                    yield {
                        "mu": mu,
                        "wrap": arcs * (1 + above),
                        "stiffness_N": pulling * share,
                        "moving": moving,
                    }


@once(REGIME)
def measured():
    return max(
        relative(lifted(rope(tension=TENSION, **case)).log_lift[0], true_log_lift(tension=TENSION, **case))
        for case in cases()
    )


def test_nothing_is_lost():
    assert measured() <= REGIME.accuracy


def test_a_rope_without_stiffness_is_left_with_the_root_of_it():
    """Two arcs of √(2E/F) each lose their friction, and nothing else does to this order."""
    mu, limp = 0.3, math.log(TENSION) + 0.3 * WRAP
    for ratio in (1e-12, 1e-16):
        found = lifted(rope(mu=mu, wrap=WRAP, tension=TENSION, stiffness_N=TENSION * ratio))
        arcs = math.sqrt(2.0 * ratio) * (1.0 + math.exp(-0.5 * mu * WRAP))
        assert WRAP - found.contact_rad[0] == pytest.approx(arcs, abs=4e-15, rel=1e-5)
        assert limp - found.log_lift[0] == pytest.approx(mu * arcs, abs=4e-15, rel=1e-5)
    assert lifted(rope(mu=mu, wrap=WRAP, tension=TENSION, stiffness_N=5e-324)).log_lift[0] == limp


def test_a_rope_that_hardly_touches_lifts_what_pulls_it():
    share = 0.375
    arcs = 2.0 * float(lifted_arc_rad(share))
    found = lifted(rope(wrap=arcs * (1.0 + 1e-14), tension=TENSION, stiffness_N=share * TENSION))
    assert 0.0 <= found.contact_rad[0] < 1e-13
    assert found.log_lift[0] == pytest.approx(math.log(TENSION), rel=1e-14)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("more", [0.0, 2.0**-52, 1.0, 1e20])
def test_a_rope_that_cannot_follow_the_wheel_is_refused(moving, more, refused):
    stiff = rope(wrap=WRAP, tension=TENSION, stiffness_N=LEFT[moving] * (1.0 + more), moving=moving)
    refused(
        lambda: lifted(stiff),
        rf"EI/\(2 R\^2\) = .* N is not below the {LEFT[moving]:g} N that pull the rope round the wheel",
    )


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("less", [1e-12, 1e-3, 1.0 - 1e-12])
def test_a_rope_that_never_touches_is_refused(moving, less, refused):
    arcs = 2.0 * float(lifted_arc_rad(0.375))
    stiff = rope(wrap=arcs * (1.0 - less), tension=TENSION, stiffness_N=LEFT[moving] * 0.375, moving=moving)
    refused(lambda: lifted(stiff), f"is less than the {arcs:.6g} rad by which this stiff rope stands off")


def test_the_first_of_several_arcs_is_taken_and_where_it_ends_none(refused):
    """Above μ = 3.33 the wrap that an arc needs may fall with it in between; the rope slips at the first."""
    share, mu = 0.99, 30.0

    def first_arc(wrap):
        problem = rope(mu=mu, wrap=wrap, tension=TENSION, stiffness_N=share * TENSION)
        return lifted(problem).contact_rad[0]

    def needed(contact):
        e = mp.mpf(share)
        return contact + mp.acos(1 - e) + mp.acos(1 - e / (e + (1 - e) * mp.exp(mu * contact)))

    with mp.workdps(30):
        top = mp.findroot(lambda contact: mp.diff(needed, contact), 0.04)
        wrap, top = float(needed(top)), float(top)
    assert 0.2 * top < first_arc(wrap * (1.0 - 1e-3)) < top
    assert first_arc(wrap * 1.01) > 2.0 * top
    refused(lambda: first_arc(wrap * (1.0 + 1e-9)), "does not settle: the friction is too high")
