"""`[feed]` of a saw: its limit in the answer, a blade that buckles is said, a blade without a section is refused."""

import tomllib
from pathlib import Path

import pytest

from ropefric.errors import DataError
from ropefric.scenes.scene_templates import bundled_scenes
from ropefric.scenes.solve import solve_scene
from ropefric.systems.bandsaw.answer import feed_limit_N
from ropefric.systems.bandsaw.saw import Section
from ropefric.systems.bandsaw.span import CLAMPED


@pytest.fixture
def saw(scene_of):
    def make(force="100 N", **more):
        tree = tomllib.loads(bundled_scenes()["band-saw"])
        tree.pop("excitation")
        return scene_of(**tree | {"feed": {"force": force, **more.pop("feed", {})}} | more)

    return make


def test_the_limit_of_both_sides_and_the_smaller_of_them(saw):
    solution = solve_scene(saw())
    tree = solution.to_dict()
    section = Section(width_m=0.085, thickness_m=0.0009, density_kg_m3=0.5967 / 7.65e-5,
                      young_modulus_Pa=206e9, shear_modulus_Pa=79.4e9)  # fmt: skip
    for side, sign in (("tight", 1.0), ("slack", -1.0)):
        # kappa = 1: the inertia tension drops out.
        net_N = 3412.0 + sign * float(solution.scene.problem.pull_N[0])
        wanted_N = feed_limit_N([net_N], section, CLAMPED, 1.6)[0]
        assert tree[side]["feed_limit_N"] == pytest.approx(wanted_N, rel=1e-9)
    assert "feed_limit_N" not in tree["rest"]
    assert tree["feed"] == {"force_N": 100.0, "limit_N": tree["slack"]["feed_limit_N"]}
    assert not solution.failures


def test_guides_nearer_than_the_free_span_raise_it(saw):
    wide, near = (
        solve_scene(saw(feed=one)).to_dict()["feed"]["limit_N"] for one in ({}, {"guide_distance": "0.4 m"})
    )
    assert near > 3.0 * wide


def test_a_blade_that_buckles_does_not_stand(saw):
    solution = solve_scene(saw("160 N"))
    assert not solution.stands
    assert solution.failures == ("the blade buckles under the feed: share of its limit 1.1",)


def test_what_a_left_out_effect_changes_is_inside_the_bound(saw):
    """On fixed axles the inertia tension is lost: the bound of leaving travel out covers what the limit gains."""
    base = {"tension": {"preload": "3412 N", "mounting_factor": 0.0}, "accuracy": 1.0}
    whole = solve_scene(saw(**base, effects=["tension-difference", "wheel-inertia-tension", "travel"]))
    still = solve_scene(saw(**base, effects=["tension-difference", "wheel-inertia-tension"]))
    ratio = still.to_dict()["feed"]["limit_N"] / whole.to_dict()["feed"]["limit_N"]
    assert 0.01 < ratio - 1.0 <= still.plan.error_bound


def test_a_blade_without_its_section_is_refused(scene_of):
    tree = tomllib.loads(bundled_scenes()["band-saw"])
    del tree["blade"]["width"], tree["blade"]["thickness"]
    with pytest.raises(DataError, match=r"feed needs blade\.width"):
        scene_of(**tree | {"feed": {"force": "100 N"}})


def test_the_bundled_scene_shows_how_it_is_asked_for():
    text = (Path(__file__).parents[2] / "data" / "scenes" / "band-saw.toml").read_text(encoding="utf-8")
    shown = text
    for key in ("[feed]", "force", "guide_distance"):
        shown = shown.replace(f"# {key}", key)
    assert tomllib.loads(shown)["feed"]["force"] == "100 N"
