"""Numbers as people read them in an answer: their digits, their units, and the columns there is room for."""

import math
import re
from pathlib import Path

import pytest

from ropefric.section import shorthand, to_error

SCENES = Path(__file__).parents[2] / "data" / "scenes"


def test_a_wide_sweep_shows_what_changes_and_says_where_the_rest_is(call):
    words = ("solve", f"{SCENES}/belt-press.toml", "--sweep", "press.preload=1000N:3000N:4", "--quiet")
    out = call(*words).out
    assert "the same at every point: Power [W] = 1673.8" in " ".join(out.split())
    left = int(re.search(r"(\d+) columns more: --out FOLDER", out)[1])
    row = next(line for line in out.splitlines() if line.split()[:1] == ["1000"])
    # The preload, and the numbers of the answer, nine of them the same at every point but for the last bits.
    assert len(row.split()) + left == 1 + len(call(*words, "--json").json()["columns"]) - 9
    shown = call("solve", f"{SCENES}/hoist.toml", "--sweep", "rope.diameter=5mm:10mm:3", "--quiet")
    assert "  rope.diameter [mm]  Lift force [N]" in shown.out


def test_angles_are_in_degrees_for_people_and_in_radians_for_programs(call):
    words = ("solve", f"{SCENES}/traction.toml", "--quiet")
    wrap_rad = call(*words, "--json").json()["needed_wrap_rad"]
    shown = next(line for line in call(*words).out.splitlines() if "Least wrap" in line)
    assert "[deg]" in shown
    assert float(shown.split()[-1]) == pytest.approx(math.degrees(wrap_rad), rel=1e-4)


def test_digits_end_with_the_error():
    for value, std, told, short in ((319.30908, 0.6392, "319.31", "319.31(64)"),
            (0.1468611, 0.000212, "0.14686", "0.14686(21)"), (12345.6, 99.96, "12350", "12350(100)"),
            (12345.6, 12.3, "12346", "12346(12)"), (3.1415926, 0.0, "3.14159", "3.1416"),
            (3.1415926, float("nan"), "3.14159", "3.1416"), (2.0, 0.0999, "2.00", "2.00(10)"),
            (1.03e154, 8.8e153, "1.03e+154", "1.03e+154(8.8e+153)"), (4.3e291, 3.3, "4.3e+291", None),
            (0.2, 3e-17, "0.2", None), (0.0, 12.0, "0", "0(12)")):  # fmt: skip
        assert to_error(value, std) == told
        assert short in {None, shorthand(value, std)}
