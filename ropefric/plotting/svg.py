"""A figure as a small piece of SVG for the inside of a page: text stays text, and names do not collide.

Of the 1.2 MB that matplotlib writes for the bench's report two fifths are left. What pays: elements that look alike in
one group that says so once (0.22 MB), steps between rounded points instead of points (0.17 MB).
"""

import io
import re
from itertools import groupby
from typing import Any
from xml.etree import ElementTree as ET

import matplotlib as mpl

from ropefric.files.plain_text import visible
from ropefric.plotting.figure import FigureWithData, rewrite_words
from ropefric.plotting.style import TYPESET, house_style

_NUMBER = re.compile(r"-?(?:\d++(?:\.\d++)?|\.\d++)(?:e-?\d++)?")
_ZERO_BEFORE_POINT = re.compile(r"(?<!\d)0\.")
_SPACE_BEHIND = re.compile(r"([;:,])\s++")
_OPACITY = re.compile(r"(^|;)opacity:")
# A colour such as #ccc is no reference.
_REFERENCE = re.compile(r"(?<=url\(#)[^)]+|(?<=^#).+")
_ROUNDED = ("transform", "x", "y", "width", "height", "points")
_FONT = "'DejaVu Sans'"
_FALLBACK = "Verdana,sans-serif"  # of nearly the same width
# Words with a symbol are drawn as plain words, the index between marks that no eye sees and every font has.
_MARK = "\u2063"
_INDEX = re.compile(f"(?<![A-Za-zφμρσ])([A-Za-zφμρσ]+){_MARK}([^{_MARK}]+){_MARK}")
_COMMAND = re.compile(r"([A-Za-z])([^A-Za-z]*)")
_LONG = 60
"""Numbers in a path above which a tenth of a point is fine enough."""


def svg_text(figure: FigureWithData, *, stem: str = "") -> str:
    """Return a figure as an `<svg>` element for the inside of an HTML page; the same figure gives the same text.

    Text is text, so it can be selected and found, and no font is embedded. There is no date and no style sheet that
    would reach other parts of the page. Paths are rounded to a tenth of a point. Ids differ from those of any other
    figure with another stem.
    """
    stream, drawn = io.BytesIO(), figure.figure
    settings: Any = {"svg.fonttype": "none", "svg.hashsalt": stem or figure.alt}
    engine = drawn.get_layout_engine()
    rewrite_words(drawn, lambda text: TYPESET.sub(rf"\1{_MARK}\2{_MARK}", text))
    with house_style(), mpl.rc_context(settings):
        try:
            if engine is not None and drawn.axes:
                # The layout is made once and held: left to itself, matplotlib draws everything twice to find it.
                engine.execute(drawn)
                drawn.set_layout_engine(None)
            drawn.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        finally:
            rewrite_words(drawn, lambda text: _INDEX.sub(r"$\1_{\\mathrm{\2}}$", text))
            drawn.set_layout_engine(engine)
    root = ET.fromstring(stream.getvalue())  # noqa: S314  (what matplotlib has just written)
    for element in list(root.iter()):
        _shorten(element)
    values = [value for element in root.iter() for value in element.attrib.values()]
    _group(root, {name for value in values for name in _REFERENCE.findall(value)})
    root.attrib = {
        "role": "img",
        "aria-label": visible(figure.alt),
        "viewBox": root.attrib["viewBox"],
        "class": "figure",
        "style": f"stroke-linejoin:round;stroke-linecap:butt;white-space:pre;font-family:{_FONT},{_FALLBACK}",
    }
    return ET.tostring(root, encoding="unicode")


def _shorten(element: ET.Element) -> None:
    """Take off namespaces, white space, metadata and the style sheet, and shorten what is left."""
    element.tag = element.tag.rpartition("}")[2]
    element[:] = [child for child in element if not child.tag.endswith(("}metadata", "}style"))]
    at = element.attrib = {key.rpartition("}")[2]: value for key, value in element.attrib.items()}
    element.tail = None
    if not (element.text or "").strip():
        element.text = None
    elif element.tag == "text":
        _set_indices(element)
    if "d" in at:
        at["d"] = short_path(at["d"])
    for name in at.keys() & _ROUNDED:
        at[name] = _NUMBER.sub(lambda found: _short(float(found.group()), 2), at[name])
    if at.get("transform", "").startswith("rotate(0 "):
        del at["transform"]
    if "style" in at:
        style = _SPACE_BEHIND.sub(r"\1", at["style"]).replace(f"font-family:{_FONT};", "")
        at["style"] = style.replace(f" {_FONT}", f" {_FONT},{_FALLBACK}")


def _set_indices(text: ET.Element) -> None:
    """Set the index of every symbol in a text low and small, and what follows back on the line."""
    text.text, *rest = _INDEX.split(text.text or "")
    back: dict[str, str] = {}
    for symbol, index, behind in zip(rest[::3], rest[1::3], rest[2::3], strict=True):
        ET.SubElement(text, "tspan", {"font-style": "italic"} | back).text = symbol
        ET.SubElement(text, "tspan", {"dy": "2", "font-size": "70%"}).text = index
        back = {"dy": "-2"}
        if behind:
            ET.SubElement(text, "tspan", back).text = behind
            back = {}


def _group(element: ET.Element, used: set[str]) -> None:
    """Take away ids and groups that say nothing, and say once in a new group what elements in a row have in common."""
    name = element.attrib.get("id", "")
    if name not in used:
        element.attrib.pop("id", None)
    children: list[ET.Element] = []
    for child in element:
        _group(child, used)
        if child.tag == "g" and not child.attrib:
            children += child
        elif child.tag not in {"g", "defs"} or len(child):
            children.append(child)
    if name.startswith("matplotlib.axis"):
        # Lines, ticks and numbers of an axis come in turns; sorted, those that look alike stand together.
        children.sort(key=lambda child: child.tag)
    element[:] = []
    for look, run in groupby(children, key=_look):
        alike = list(run)
        if look and len(alike) > 1 and element.tag != "defs":
            group = ET.SubElement(element, "g", dict(look))
            for child in alike:
                child.attrib = {key: value for key, value in child.attrib.items() if (key, value) not in look}
            group[:] = alike
        else:
            element.extend(alike)


def _look(element: ET.Element) -> tuple[tuple[str, str], ...]:
    """Return what a group can say for an element; opacity is not handed down."""
    if element.tag not in {"path", "use", "text"} or _OPACITY.search(element.get("style", "")):
        return ()
    return tuple((key, element.attrib[key]) for key in ("clip-path", "style") if key in element.attrib)


def short_path(path: str) -> str:
    """Return a path with rounded numbers, its straight runs as steps from point to point.

    Steps are taken between rounded points, so that rounding does not add up.
    """
    parts = [(command, list(map(float, text.split()))) for command, text in _COMMAND.findall(path)]
    digits = 1 if sum(len(numbers) + 1 for _, numbers in parts) > _LONG else 2
    unit = 10**digits
    drawn, short, at = "", "", [0, 0]
    for command, numbers in parts:
        ends = steps = [round(unit * number) for number in numbers]
        if command == "L":
            command, steps = "l", [ends[0] - at[0], ends[1] - at[1]]  # noqa: PLW2901  (steps for points)
        at = ends[-2:] or at
        text = " ".join(_short(step / unit, digits) for step in steps).replace(" -", "-")
        again = command == drawn == "l"
        short += (" " if again and not text.startswith("-") else "" if again else command) + text
        drawn = command
    return short


def _short(value: float, digits: int) -> str:
    """Return a number with so many digits after the point, one or more, as short as SVG allows."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else _ZERO_BEFORE_POINT.sub(".", text)
