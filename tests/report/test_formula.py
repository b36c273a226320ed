"""Equations as MathML: well formed, with every symbol of the law, and read as they are written."""

import math
import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest

from ropefric.friction.laws import ALL_LAWS
from ropefric.report.page import _Statement, formulas, symbol

ELEMENTS = {*("math", "mrow", "mi", "mn", "mo", "msub", "msup", "msubsup", "mfrac", "msqrt"),
    *("munderover", "mspace", "mtext")}  # fmt: skip


def value(node, names):
    """Work a tree of MathML out, independently of the text it was made from."""
    if node.tag == "mn":
        return float(node.text)
    if node.tag in {"mi", "msub"}:
        return names["".join(node.itertext())]
    if node.tag == "mfrac":
        return value(node[0], names) / value(node[1], names)
    if node.tag == "msup":
        return value(node[0], names) ** value(node[1], names)
    if node.tag == "msubsup":
        return names["".join((*node[0].itertext(), *node[1].itertext()))] ** value(node[2], names)
    return row([*node], names) ** (0.5 if node.tag == "msqrt" else 1.0)


def row(nodes, names):
    """Sum the products of a row; brackets are rows of their own, a function and its bracket too."""
    nodes = [node for node in nodes if node.tag != "mspace"]
    if len(nodes) == 3 and nodes[1].tag == "mo" and nodes[1].text == "\u2061":
        return names["".join(nodes[0].itertext())](value(nodes[2], names))
    if nodes[0].tag == "mo" and nodes[0].text == "(":
        nodes = nodes[1:-1]
    total, product, sign = 0.0, None, 1.0
    for node in nodes:
        if node.tag == "mo":
            total += 0.0 if product is None else sign * product
            product, sign = None, -1.0 if node.text == "−" else 1.0
        else:
            product = value(node, names) * (1.0 if product is None else product)
    return total + sign * product


def test_each_law_is_well_formed_and_has_its_parameters():
    for law in ALL_LAWS.values():
        assert_well_formed(law)


def assert_well_formed(law):
    statements = formulas(law)
    assert statements
    for text in statements:
        root = ET.fromstring(text)  # noqa: S314  (our own text)
        assert {node.tag for node in root.iter()} <= ELEMENTS
        assert root[0].tag == "mrow"  # typeset, not passed on as text
        assert "_" not in "".join(root.itertext())
    whole, names = "".join(statements), set(re.findall(r"[A-Za-z]\w*", law.equation))
    for name, meaning in ((item.name, item.meaning) for item in law.parameters):
        # A parameter whose name says more than its symbol names the symbol in its meaning.
        shown = name if name in names else next(word for word in names if f" {word} " in f" {meaning} ")
        assert symbol(shown) in whole, name


def test_it_says_what_is_written():
    names = {"a": 2.0, "b": 3.0, "c": 4.0, "aw": 1.7, "exp": math.exp}
    for text, expected in (("a + b/c", 2.0 + 3.0 / 4.0), ("-a - (b - c)", -2.0 - (3.0 - 4.0)),
        ("a b^c", 2.0 * 3.0**4.0), ("(a + b)/(2 a c)", 5.0 / 16.0),
        ("(a/(a + b))^c + b", (2.0 / 5.0) ** 4.0 + 3.0),
        ("sqrt(1 + 4 a b^2 (5 - c))/(a b)", math.sqrt(73.0) / 6.0),
        ("a_w^(1-b) exp(a b/c)", 1.7**-2.0 * math.exp(1.5)), ("(-1 + a) (b + c)", 7.0), ("a (b + c)", 14.0),
        ("a (b/c)^(1-b) + c", 2.0 * 0.75**-2.0 + 4.0)):  # fmt: skip
        root = ET.fromstring(_Statement(text).typeset())  # noqa: S314
        assert value(root, names) == pytest.approx(expected, rel=1e-12), text


def test_a_law_of_ones_own_in_another_notation_stays_text():
    own = replace(ALL_LAWS["constant"], equation="F_A = F_B exp(mu phi); μ*φ < 3 & more")
    first, second = formulas(own)
    assert first == formulas(ALL_LAWS["constant"])[0]
    assert ET.fromstring(second)[0].tag == "mtext"  # noqa: S314
    assert "".join(ET.fromstring(second).itertext()) == "μ*φ < 3 & more"  # noqa: S314


def test_what_is_no_equation_is_refused():
    for text in ("a = (b", "a + ", "a = b )", "integral of mu to phi", "a * b"):
        with pytest.raises(ValueError, match=re.escape(text.strip()[:3])):
            _Statement(text).typeset()
