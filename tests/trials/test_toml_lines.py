"""The line locator against independent knowledge of where things stand."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import DataError
from ropefric.files.toml import read_toml, toml_lines

TEXT = '''# comment [not.a.table]
title = "a # no comment = [x]"   # a comment = "with" quotes
long = """
[fake]
key = 1 \\"""
still inside"""
literal = \'\'\'
[also.fake]'\'\'\'
a.b."c.d" = 1
inline = { x = 1, y = { z = [10, 20] }, "q\\u0041" = \'}\' }
array = [
  "one", # , ]
  [ "two",
    3.5 ],
  { k = 1 },
]
[rope]
diameter = "9.8 mm"
when = 2026-01-15 10:00:00
  [ wheels . "W 40" ]
radius="40 mm"
[[runs]]
n = 1
[runs.sub]
m = 2
[[runs]]
n = 3
[[runs.deep]]
o = 4
[[runs.deep]]
o = 5
'''

EXPECTED = {
    ("title",): 2, ("long",): 3, ("literal",): 7, ("a",): 9, ("a", "b"): 9, ("a", "b", "c.d"): 9,
    ("inline", "x"): 10, ("inline", "y", "z", 1): 10, ("inline", "qA"): 10, ("array",): 11, ("array", 0): 12,
    ("array", 1): 13, ("array", 1, 0): 13, ("array", 1, 1): 14, ("array", 2, "k"): 15, ("rope",): 17,
    ("rope", "diameter"): 18, ("rope", "when"): 19, ("wheels", "W 40"): 20, ("wheels", "W 40", "radius"): 21,
    ("runs",): 22, ("runs", 0, "n"): 23, ("runs", 0, "sub", "m"): 25, ("runs", 1): 26, ("runs", 1, "n"): 27,
    ("runs", 1, "deep", 0, "o"): 29, ("runs", 1, "deep", 1, "o"): 31,
}  # fmt: skip


def leaves(tree, path=()):
    """Every key path of a parsed tree, tables and array elements included."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from leaves(value, (*path, key))


def test_every_kind_of_key_has_its_line():
    found = toml_lines(TEXT)
    assert {path: found[path] for path in EXPECTED} == EXPECTED
    assert (set(leaves(tomllib.loads(TEXT))), toml_lines(TEXT.replace("\n", "\r\n"))) == (set(found), found)


@given(st.text("a=[]{}\"'#.,\n\\ 1", max_size=60) | st.text(max_size=80))
def test_any_text_has_its_lines_and_what_tomllib_accepts_is_located_completely(text):
    assert all(1 <= line <= text.count("\n") + 1 for line in toml_lines(text).values())
    try:
        tree = tomllib.loads(text)
    except ValueError:
        return
    assert set(leaves(tree)) == set(toml_lines(text))


@pytest.mark.parametrize(("text", "words"), [("a = " + "[" * 3000 + "]" * 3000, "nested too deeply"),
    ("a = " + "{a=" * 3000 + "1" + "}" * 3000, "nested too deeply"),
    ("a = " + "9" * 5000, "number or date that cannot be read"),
    ("a = [" + "1," * 600_000 + "]", "more than 1000000 are not read")],
    ids=["arrays", "tables", "number", "size"])  # fmt: skip
def test_what_would_take_for_ever_is_refused_before(tmp_path, text, words):
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(DataError, match=words):
        read_toml(path)
