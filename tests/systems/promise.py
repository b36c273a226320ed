"""What a plan promises: an answer within the accuracy asked for, and within the error bound that the plan states."""

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ropefric.errors import RopefricError
from ropefric.registry import Registry
from ropefric.scenes.plan import make_plan

ACCURACIES = [0.05, 0.05, 0.05, 0.3, 0.01, 1e-3, 1e-6]


def costly(system):
    """The system as if every effect took so long that it may be left out: what is quick is planned all the same."""
    effects = [one._replace(cost=1.0) for one in system.effects.values()]
    return system._replace(effects=Registry("effect", effects))


def check_promise(system, problems, examples, *, may_refuse=False, rounding=0.0):
    """Return how many problems were planned, did without an effect, and without one that does change something.

    Where `may_refuse`, problems that have no answer with every effect in are no cases of the promise.
    """
    system = costly(system)
    counts = {"planned": 0, "spared": 0, "spared with a worth": 0}

    @settings(deadline=None, max_examples=examples, derandomize=True)
    @given(problem=problems, accuracy=st.sampled_from(ACCURACIES))
    def run(problem, accuracy):
        plan, model = make_plan(system, problem, accuracy=accuracy, effects="auto")
        _, full = make_plan(system, problem, accuracy=accuracy, effects="all")
        try:
            everything = system.solve(full, system.method(full, 1e-9))
        except RopefricError:
            if not may_refuse:
                raise
            assume(condition=False)
        difference = system.distance(system.solve(model, plan.method), everything, everything)
        assert difference <= min(accuracy, plan.error_bound) + rounding, (difference, plan.error_bound, plan)
        assert plan.keeps_accuracy
        if accuracy == 0.05:
            counts["planned"] += 1
            left_out = [one for one in plan.decisions if one.fate == "left out"]
            counts["spared"] += bool(left_out)
            counts["spared with a worth"] += any(one.bound > 0.0 for one in left_out)

    run()
    return counts
