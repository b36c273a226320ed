from pathlib import Path

import pytest

from ropefric.files.toml import TomlDocument
from ropefric.scenes.scene import read_scene


@pytest.fixture(scope="session")
def scene_of():
    """A function: the scene of a TOML tree given as keywords."""
    return lambda **tree: read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), Path())
