from pathlib import Path

import pytest

from ropefric.files.toml import TomlDocument
from ropefric.scenes.scene import read_scene
from ropefric.scenes.solve import solve_scene

SCENES = Path(__file__).parents[3] / "data" / "scenes"


@pytest.fixture(scope="session")
def line_of():
    """A function: the scene of a line of these elements, with other tables as keywords."""

    def make(*elements, **tables):
        tree = {"system": "line", "element": list(elements)} | tables
        return read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), SCENES)

    return make


@pytest.fixture(scope="session")
def answer_of(line_of):
    """A function: the JSON shape of the answer of such a line."""
    return lambda *elements, **tables: solve_scene(line_of(*elements, **tables)).to_dict()
