"""Many alike cases of one test: some of them are run by default, all of them in the long run."""

import pytest


def thinned(cases, every=3):
    """Return the cases of a test, all but each so-manieth marked as slow."""
    return [case if i % every == 0 else slow(case) for i, case in enumerate(cases)]


def slow(case):
    """Return a case for the long run."""
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)
