"""The line locator against independent knowledge of where things stand."""

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
    ("inline",): 10, ("array",): 11, ("rope",): 17,
    ("rope", "diameter"): 18, ("rope", "when"): 19, ("wheels", "W 40"): 20, ("wheels", "W 40", "radius"): 21,
    ("runs",): 22, ("runs", 0, "n"): 23, ("runs", 0, "sub", "m"): 25, ("runs", 1): 26, ("runs", 1, "n"): 27,
    ("runs", 1, "deep", 0, "o"): 29, ("runs", 1, "deep", 1, "o"): 31,
}  # fmt: skip


def test_every_key_that_begins_a_line_has_it_and_what_stands_within_a_value_that_of_its_key(tmp_path):
    found = toml_lines(TEXT)
    assert {path: found[path] for path in EXPECTED} == EXPECTED
    assert toml_lines(TEXT.replace("\n", "\r\n")) == found
    (tmp_path / "a.toml").write_text(TEXT, encoding="utf-8")
    document = read_toml(tmp_path / "a.toml")
    assert document.line_of(("inline", "y", "z", 1)) == 10
    assert document.line_of(("array", 1, 0)) == 11


@given(st.text("a=[]{}\"'#.,\n\\ 1", max_size=60) | st.text(max_size=80))
def test_any_text_has_lines_within_it(text):
    assert all(1 <= line <= text.count("\n") + 1 for line in toml_lines(text).values())


@pytest.mark.parametrize(("text", "words"), [("x = 1\na" + ".a" * 20_000 + " = 1",
    ":2: a key has more than 32 parts"), ("[" + "a." * 20_000 + "b]", ":1: a key has more than 32 parts"),
    ("a = { b" + " . b" * 20_000 + " = 1 }", ":1: a key has more than 32 parts"),
    ("a = " + "[" * 3000 + "]" * 3000, "nested too deeply"),
    ("a = " + "{a=" * 3000 + "1" + "}" * 3000, "nested too deeply"),
    ("a = " + "9" * 5000, "number or date that cannot be read"),
    ("a = [" + "1," * 600_000 + "]", "more than 1000000 are not read")],
    ids=["dotted key", "table", "inline", "arrays", "tables", "number", "size"])  # fmt: skip
def test_what_would_take_for_ever_is_refused_before(tmp_path, text, words):
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(DataError, match=words):
        read_toml(path)


def test_text_with_dots_is_no_long_key(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(f'a = "{"x." * 100}"\nb = [{"1.5," * 100}]\n# {"c." * 100}\n')
    assert len(read_toml(path).data["b"]) == 100
