"""Makes the helper modules of this folder importable under importmode=importlib, and shares what refusals are."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from ropefric.errors import RopefricError


@pytest.fixture
def refused():
    """Assert that a call is refused by name: what it says, and that it says more than a type."""

    def refused(call, said):
        with pytest.raises(RopefricError, match=said) as caught:
            call()
        assert len(caught.value.problem.message) > 15
        return caught.value

    return refused


@pytest.fixture
def finite_or_refused():
    """Assert that a call gives finite numbers or is refused with words; return the numbers, or None."""

    def finite_or_refused(call):
        try:
            answer = call()
        except RopefricError as error:
            refusal = error
        else:
            refusal = None
        if refusal is not None:
            assert len(refusal.problem.message) > 15
            return None
        for part in answer if isinstance(answer, tuple) else (answer,):
            assert np.isfinite(np.asarray(part, dtype=np.float64)).all()
        return answer

    return finite_or_refused
