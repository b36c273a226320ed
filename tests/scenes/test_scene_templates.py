"""Scenes to start from: the bundled ones, whole, wherever they are written."""

import pytest

from ropefric.errors import InputError, UnknownNameError
from ropefric.scenes.scene import load_scene
from ropefric.scenes.scene_templates import bundled_scenes, scene_text, write_scenes
from ropefric.scenes.solve import solve_scene


def files_below(folder, pattern):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob(pattern)}


def test_the_package_holds_the_bundled_scenes_and_their_fits_byte_by_byte(scenes_folder):
    """After a change in data/scenes or fits/, copy it into the machine's folder, or into ropefric/scenes/fits."""
    root = scenes_folder.parents[1]
    package = root / "ropefric" / "scenes"
    bundled = {f"{name}.toml": text.encode() for name, text in bundled_scenes().items()}
    assert bundled == files_below(scenes_folder, "*.toml")
    fits = files_below(package, "*.json")
    assert fits == {name: (root / name).read_bytes() for name in fits}


def test_written_scenes_need_nothing_but_their_folder(tmp_path, monkeypatch, loaded):
    monkeypatch.chdir(tmp_path)
    written = write_scenes("my")
    scenes = {path.stem: load_scene(path) for path in written if path.suffix == ".toml"}
    assert solve_scene(scenes["hoist"]).to_dict() == solve_scene(loaded("hoist")).to_dict()
    assert scenes.keys() == bundled_scenes().keys()
    assert all("../" not in scene_text(name) for name in bundled_scenes())


def test_scenes_can_be_added_one_by_one_but_none_is_written_over(tmp_path):
    assert [path.name for path in write_scenes(tmp_path, ["hoist"])] == ["hoist.toml", "prth-coupled.json"]
    assert [path.name for path in write_scenes(tmp_path, ["climbing-hoist"])] == ["climbing-hoist.toml"]
    (tmp_path / "hoist.toml").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="there already"):
        write_scenes(tmp_path, ["many-turns", "hoist"])
    assert not (tmp_path / "many-turns.toml").exists()
    assert (tmp_path / "hoist.toml").read_text(encoding="utf-8") == "mine"


def test_another_fit_in_the_folder_is_not_replaced(tmp_path):
    fit = tmp_path / "fits" / "prth-coupled.json"
    fit.parent.mkdir()
    fit.write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="there already") as caught:
        write_scenes(tmp_path, ["hoist"])
    assert caught.value.where.endswith("prth-coupled.json")
    write_scenes(tmp_path, ["hoist"], overwrite=True)
    assert fit.stat().st_size > 1000


def test_a_scene_is_found_by_its_name_only():
    with pytest.raises(UnknownNameError, match="did you mean 'climbing-hoist'"):
        scene_text("climbing-hiost")
    with pytest.raises(UnknownNameError):
        scene_text("../templates/hoist")
