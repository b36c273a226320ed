"""What all tests share."""

import gc
import os
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# What is imported and collected stays: looking through it for garbage again and again takes a tenth of the run.
gc.disable()

# Two workers on two cores: linear algebra with threads of its own gets in their way. Set before numpy loads.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

# Commands read recordings in processes forked for that, each of which would load these anew: here once.
for _name in ("pandas", "pint"):
    import_module(_name)

# What the tests of several folders share: what is drawn here, `promise` and `thinned` there.
for _folder in (Path(__file__).parent, Path(__file__).parent / "systems"):
    sys.path.insert(0, str(_folder))

# No luck and no clock decides the default run. The long one, `-m slow`, draws afresh each time, and more.
settings.register_profile(
    "same", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.register_profile("drawn", settings.get_profile("same"), derandomize=False, database=None)
# Examples would also be drawn from the numbers that stand in the modules loaded so far, so that they hung on which tests
# ran before in the same process. Old versions of hypothesis do not.
if find_spec("hypothesis.internal.conjecture.providers"):
    import_module("hypothesis.internal.conjecture.providers").is_local_module_file = lambda path: False
MORE, LESS = 5, 0.5
"""How many times as many examples the long run draws, and the default one, where they are the same each time."""

PORTABLE = (
    "ropefric", "tests/friction", "tests/hard", "tests/uncertainty", "tests/traces", "tests/files", "tests/ground",
    "tests/pipeline", "tests/test_public_api.py", "tests/test_plugins.py", "tests/trials/test_parquet.py",
    "tests/trials/test_tables.py", "tests/trials/test_sheets.py", "tests/trials/test_one_pull_many_formats.py",
    "tests/fitting/test_", "tests/systems/bandsaw", "tests/systems/hoist", "tests/systems/press/",
    "tests/systems/beltdrive", "tests/systems/line", "tests/systems/traction", "tests/scenes/test_published.py",
    "tests/cli/test_run.py",
    "tests/cli/test_solve.py", "tests/cli/test_extract.py", "tests/cli/test_fit_commands.py",
    "tests/plotting/test_environment.py", "tests/plotting/test_svg.py", "tests/plotting/test_condition.py",
    "tests/report/test_page.py", "tests/rig/test_campaign.py",
)  # fmt: skip
"""Beginnings of what other Pythons, libraries and processors may break: last bits, formats, commands, pictures."""

ROOT = Path(__file__).parents[1]
REAL_DATA = ROOT.parent / "shared" / "data"


@pytest.fixture
def real_data():
    """The folder of real recordings; tests that need it skip where it is absent."""
    if not REAL_DATA.is_dir():
        pytest.skip("the real recordings are not on this machine")
    return REAL_DATA


@pytest.fixture
def few_laws(monkeypatch):
    """Let a run compare three laws instead of all: for tests that ask for something else."""
    from ropefric import pipeline

    def compare_few(table, laws, compare=pipeline.compare_laws, **more):
        return compare(table, laws or ("constant", "size-exponential", "howell"), **more)

    monkeypatch.setattr(pipeline, "compare_laws", compare_few)


def is_long(config):
    return config.option.markexpr.startswith("slow")


def pytest_configure(config):
    # Before any test file is read: `@settings(…)` takes what it does not say from the profile of that moment.
    settings.load_profile("drawn" if is_long(config) else "same")


def pytest_collection_finish():
    gc.set_threshold(50_000, 20, 50)
    gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark what is portable; let the long run take every test that draws, but those with seeds (`derandomize=True`)."""
    name, long = "_hypothesis_internal_use_settings", is_long(config)
    changed = set()
    for item in items:
        if item.nodeid.startswith(PORTABLE):
            item.add_marker(pytest.mark.portable)
        given = getattr(getattr(item, "obj", None), name, None)
        if given is None or (long and (given.derandomize or item.get_closest_marker("slow"))):
            continue
        if long:
            item.add_marker(pytest.mark.slow)
        # The parameters of one test share its function.
        if item.obj not in changed:
            changed.add(item.obj)
            count = round((MORE if long else LESS) * given.max_examples)
            setattr(item.obj, name, settings(given, max_examples=max(1, count)))
