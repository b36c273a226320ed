"""What to know before reading a ranking of laws: what was counted, what is not told apart, what was not judged."""

import math
from collections.abc import Sequence

from ropefric.fitting.comparison import ComparisonEntry, Unit
from ropefric.fitting.criteria import ConditionMeans, FTest
from ropefric.fitting.measured import Measured
from ropefric.friction.laws import ALL_LAWS
from ropefric.glossary import counted

_CHANCE = 0.05


def comparison_notes(
    ranking: Sequence[ComparisonEntry],
    tests: Sequence[FTest],
    means: ConditionMeans,
    unit: Unit,
    measured: Measured,
) -> tuple[str, ...]:
    """Return what to know before reading a ranking; first what an observation is."""
    in_all = counted(len(means), unit[:-1])
    notes = [f"AICc counts {in_all}, not repeats" if unit == "conditions" else "AICc counts every trial"]
    if not means.repeated and unit == "conditions":
        notes.append("no condition was repeated, so every trial is a condition of its own")
    if measured == "end-tension":
        notes.append("the load was set and the end tension measured, so the residuals are those of ln F_B")
    ranked = [entry for entry in ranking if entry.counted]
    if any(math.isnan(entry.weight) for entry in ranked) or not ranked:
        notes += _unjudged(ranking, tests, in_all)
    rivals = [e.law for e in ranked if e.delta_aicc <= 2.0]
    if len(rivals) > 1:
        notes.append(f"within 2 of the best AICc, so not told apart: {', '.join(rivals)}")
    wraps = [law for law in rivals if "wrap-dependence" in ALL_LAWS[law].effects]
    if wraps and "constant-offset" in rivals:
        notes.append(
            f"a constant μ with an offset looks like a wrap effect, and these data do not tell constant-offset from "
            f"{', '.join(wraps)}: measure the offset at a wrap near zero"
        )
    return tuple(notes)


def _unjudged(ranking: Sequence[ComparisonEntry], tests: Sequence[FTest], in_all: str) -> list[str]:
    """Return that the ranking decides nothing, and which tests speak against what it holds."""
    ranked = [entry.law for entry in ranking if entry.counted]
    named = f"only {' and '.join(ranked)} could be" if ranked else "no law could be"
    notes = [
        f"{named} ranked on {in_all}, so weights would say nothing and no law is chosen: measure more conditions"
    ]
    against = [test for test in tests if test.simpler in ranked and test.fuller not in ranked]
    against = sorted((test for test in against if test.p_value < _CHANCE), key=lambda test: test.p_value)
    notes += [
        f"an F-test speaks against {test.simpler}: {test.fuller}, which is not ranked, follows the trials better "
        f"(p = {test.p_value:.2g})"
        for test in against[:1]
    ]
    return notes
