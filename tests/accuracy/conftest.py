"""What the accuracy tests share: the settings of a case by name, and observed orders."""

import sys
from pathlib import Path

import numpy as np
import pytest

from ropefric.accuracy.measure import error_table
from ropefric.accuracy.studies import picks

sys.path.insert(0, str(Path(__file__).parent))  # for small_campaigns


def _errors(study, case, method):
    """Errors of one method, by the number its setting starts or ends with."""
    rows = error_table(study, case, method=method)

    def number(text):
        words = [word for word in text.replace(",", " ").split() if word[0].isdigit()]
        return float(words[0])

    return {number(row.setting): row.error for row in rows}


@pytest.fixture(scope="session")
def errors():
    return _errors


@pytest.fixture(scope="session")
def order():
    """The slope of log error over log work between two settings, with its sign turned."""

    def order(found, coarse, fine):
        return -np.log(found[fine] / found[coarse]) / np.log(fine / coarse)

    return order


@pytest.fixture(autouse=True)
def _few_recordings(monkeypatch):
    """One recording of each family in the study of pickers: more take seconds."""
    monkeypatch.setattr(picks, "PER_FAMILY", 1)
