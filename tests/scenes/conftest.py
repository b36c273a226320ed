from pathlib import Path

import pytest

from ropefric.files.toml import TomlDocument
from ropefric.scenes.scene import load_scene, read_scene

SCENES = Path(__file__).parents[2] / "data" / "scenes"


@pytest.fixture(scope="session")
def scenes_folder():
    return SCENES


@pytest.fixture(scope="session")
def scene_of():
    """A function: the scene of a TOML tree given as keywords."""

    def make(**tree):
        return read_scene(TomlDocument(path="scene.toml", data=tree, lines={}), SCENES)

    return make


@pytest.fixture(scope="session")
def hoist_of(scene_of):
    """A function: a hoist scene, its tables changed by keywords; None takes a table or key out."""

    def make(**changes):
        tree = {"system": "hoist", "accuracy": 0.01, "effects": "auto",
                "wheel": {"radius": "40 mm", "wrap": "540 deg", "speed": "0.3 m/s"},
                "rope": {"diameter": "9.8 mm", "linear_density": "62 g/m"}, "load": {"end_tension": "80 N"},
                "friction": {"fit": "../../fits/prth-coupled.json"}}  # fmt: skip
        for name, value in changes.items():
            if isinstance(value, dict) and name in tree and name != "friction":
                tree[name] = {key: one for key, one in {**tree[name], **value}.items() if one is not None}
            elif value is None:
                del tree[name]
            else:
                tree[name] = value
        return scene_of(**tree)

    return make


@pytest.fixture(scope="session")
def loaded():
    """A function: one of the bundled scenes, by name."""

    def load(name):
        return load_scene(SCENES / f"{name}.toml")

    return load


@pytest.fixture
def scene_file(tmp_path):
    """A function: a scene file with this text."""

    def write(text):
        path = tmp_path / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
