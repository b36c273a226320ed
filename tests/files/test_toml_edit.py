"""Values of a TOML file are changed in its text; whatever else a person wrote stays, byte for byte."""

import difflib
import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric.errors import DataError
from ropefric.files.toml_edit import toml_value, with_values

MINE = """# my notes
name = 'Mine'   # a name
rope.diameter = "9 mm"
data = "."

[wheels."R 30"]     # turned
radius = "30 mm"    # measured

[import]
format = "delimited"
[import.channels]
force = { column = "Zug [mV]", unit = "mV" }   # cell 2
time = "t"
[import.channels.end_tension]
column = "Gegen"
unit = "mV"

[own]
text = \"\"\"
[tare]
radius = "1 mm"
\"\"\"
"""


def changed_lines(before, after):
    """The lines that went, and those that came."""
    lines = [*difflib.ndiff(before.splitlines(), after.splitlines())]
    return [one[2:] for one in lines if one[0] == "-"], [one[2:] for one in lines if one[0] == "+"]


@pytest.mark.parametrize(
    ("path", "value", "went", "came"),
    [
        (("name",), 'A "b"', ["name = 'Mine'   # a name"], ['name = "A \\"b\\""   # a name']),
        (("rope", "diameter"), "8 mm", ['rope.diameter = "9 mm"'], ['rope.diameter = "8 mm"']),
        (("wheels", "R 30", "radius"), "31 mm", ['radius = "30 mm"    # measured'], ['radius = "31 mm"    # measured']),
        (("wheels", "R 30", "tolerance"), "1 mm", [], ['tolerance = "1 mm"']),
        (("wheels", "W 40"), {"radius": "1 mm"}, [], ["", "[wheels]", '"W 40" = { radius = "1 mm" }']),
        (("wheels", "W40", "radius"), "1 mm", [], ["", "[wheels.W40]", 'radius = "1 mm"']),
        (("wheels", "R 30", "radius"), None, ['[wheels."R 30"]     # turned', 'radius = "30 mm"    # measured'], []),
        (
            ("import", "channels", "force"),
            {"column": "Zug"},
            ['force = { column = "Zug [mV]", unit = "mV" }   # cell 2'],
            ['force = { column = "Zug" }   # cell 2'],
        ),
        (("import", "channels", "end_tension", "unit"), "N", ['unit = "mV"'], ['unit = "N"']),
        (("import", "channels", "time"), None, ['time = "t"'], []),
        (("tare", "interval"), ["0 s", "1 s"], [], ["", "[tare]", 'interval = ["0 s", "1 s"]']),
        (("question",), "why", [], ['question = "why"']),
    ],
)  # fmt: skip
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_one_value_changes_and_nothing_else(path, value, went, came, end):
    before = MINE.replace("\n", end)
    after = with_values(before, {path: value})
    assert changed_lines(before, after) == (went, came)
    assert after.count("\n") == after.count(end)


def test_a_table_that_is_emptied_is_removed_with_its_heading():
    text = '[design]\nwheel_radius = "1 mm"\nwrap_angle = "90 deg"\n'
    assert with_values(text, {("design", "wheel_radius"): None, ("design", "wrap_angle"): None}) == ""


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ('rope = { diameter = "1 mm", material = "x" }\n', ("rope", "diameter"), None),
        ('rope.diameter = "1 mm"\n', ("rope", "material"), "x"),
        ('rope = { diameter = "1 mm" }\n', ("rope", "material"), "x"),
        ("a = [\n 1]\n", ("a",), [2]),
    ],
)
def test_what_would_change_other_keys_is_refused(text, path, value):
    with pytest.raises(DataError, match="shares its line or table") as refused:
        with_values(text, {path: value})
    assert (refused.value.code, refused.value.problem.key) == ("RF105", ".".join(path))


WORDS = st.text(max_size=12)


@settings(max_examples=30)
@given(
    WORDS
    | st.integers(-(2**63), 2**63 - 1)
    | st.lists(WORDS, max_size=3)
    | st.dictionaries(WORDS, WORDS, max_size=3)
)
def test_any_value_comes_back(value):
    assert tomllib.loads(f"key = {toml_value(value)}")["key"] == value
    assert tomllib.loads(with_values(MINE, {("own", "new"): value}))["own"]["new"] == value
