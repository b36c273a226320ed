"""The effects a line may be simulated with."""

from collections.abc import Callable

from ropefric.registry import Registry
from ropefric.systems.effect import Effect, System, closed_form_system, law_effects, missing, stiff_law
from ropefric.systems.line.element import LineProblem
from ropefric.systems.line.line import distance, solve_line


def _needs(effect: str, element: str, **keys: str) -> Callable[[LineProblem], tuple[str, ...]]:
    """Return what of the rope is missing for an effect, and the key of an element where no element has its data."""

    def needs(problem: LineProblem) -> tuple[str, ...]:
        found = missing(keys)(problem) + (stiff_law(problem) if effect == "bending-stiffness" else ())
        return (
            found
            if any(effect in one.effects for one in problem.elements)
            else (*found, f"element.{element}")
        )

    return needs


EFFECTS: Registry[Effect] = Registry(
    "effect of a line",
    (
        Effect(
            name="weight",
            adds="the weight of the rope in straight runs, and its friction on the floor",
            instead="a rope without weight",
            needs=_needs("weight", "length of a run", linear_density_kg_m="rope.linear_density"),
        ),
        Effect(
            name="wobble",
            adds="the unintended bends of a duct, k per metre",
            instead="a duct without unintended bends",
            needs=_needs("wobble", "wobble"),
        ),
        Effect(
            name="bending-stiffness",
            adds="the tension EI/(2 R^2) that bends the rope, and the arcs at both ends where it lifts off",
            instead="a limp rope",
            needs=_needs("bending-stiffness", "radius", bending_stiffness_N_m2="rope.bending_stiffness"),
        ),
        Effect(
            name="bearing",
            adds="the efficiency or drag of wheels",
            instead="wheels that turn freely",
            needs=_needs("bearing", "efficiency"),
        ),
        *law_effects("bend", "rope", tension="the slack side's tension"),
        Effect(
            name="stretch",
            adds="the elongation of the rope, and the stroke that it takes",
            instead="a rope that does not stretch",
            needs=lambda problem: () if problem.axial_stiffness_N is not None else ("rope.axial_stiffness",),
        ),
    ),
)
"""In the order in which they are applied."""

SYSTEM: System = closed_form_system(
    "line",
    EFFECTS,
    solve_line,
    error=1e-11,
    why="each element has a closed form; a law with wrap or tension takes a root or a rule of 24 points",
)._replace(distance=distance)
"""A rope through elements."""
