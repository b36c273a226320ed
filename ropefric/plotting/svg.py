"""A figure as a small piece of SVG for the inside of a page: text stays text, and names do not collide.

Of the 1.2 MB that matplotlib writes for the bench's report 0.4 MB are left. What pays: elements that look alike in one
group that says so once (0.22 MB), steps between rounded points instead of points (0.17 MB), idle points (0.04 MB).
"""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby, pairwise
from typing import Any
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ropefric.files.plain_text import visible
from ropefric.plotting.figure import FORMATS, FigureWithData, rewrite_words
from ropefric.plotting.style import TYPESET, house_style

_NUMBER = re.compile(r"-?(?:\d++(?:\.\d++)?|\.\d++)(?:e-?\d++)?")
_ZERO_BEFORE_POINT = re.compile(r"(?<!\d)0\.")
_SPACE_BEHIND = re.compile(r"([;:,])\s++")
_DOUBLED_COLOUR = re.compile(r"#([0-9a-f])\1([0-9a-f])\2([0-9a-f])\3\b")
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
_IDLE = 4.0
"""How far off a line, in tenths of a point, a point of a long run may lie and be left out."""


def svg_text(figure: FigureWithData, *, stem: str = "") -> str:
    """Return a figure as an `<svg>` element for the inside of an HTML page; the same figure gives the same text.

    Text is text, so it can be selected and found, and no font is embedded. There is no date and no style sheet that
    would reach other parts of the page. Paths are rounded to a tenth of a point. Ids differ from those of any other
    figure with another stem.
    """
    stream = io.BytesIO()
    settings: Any = {"svg.fonttype": "none", "svg.hashsalt": stem or figure.alt}
    with house_style(), mpl.rc_context(settings), _ready(figure.figure):
        figure.figure.savefig(stream, format="svg", metadata=FORMATS["svg"])
    root = ET.fromstring(stream.getvalue())  # noqa: S314  (what matplotlib has just written)
    for element in list(root.iter()):
        _shorten(element)
    used = {
        name
        for element in root.iter()
        for value in element.attrib.values()
        for name in _REFERENCE.findall(value)
    }
    _group(root, used)
    root.attrib = {
        "role": "img",
        "aria-label": visible(figure.alt),
        "viewBox": root.attrib["viewBox"],
        "class": "figure",
        "style": f"stroke-linejoin:round;stroke-linecap:butt;white-space:pre;font-family:{_FONT},{_FALLBACK}",
    }
    return ET.tostring(root, encoding="unicode")


@contextmanager
def _ready(figure: Figure) -> Iterator[None]:
    """Make the layout once and hold it: left to itself, matplotlib draws everything twice to find it."""
    engine = figure.get_layout_engine()
    rewrite_words(figure, lambda text: TYPESET.sub(rf"\1{_MARK}\2{_MARK}", text))
    try:
        if engine is not None and figure.axes:
            engine.execute(figure)
            figure.set_layout_engine(None)
        yield
    finally:
        rewrite_words(figure, lambda text: _INDEX.sub(r"$\1_{\\mathrm{\2}}$", text))
        figure.set_layout_engine(engine)


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
    for name in _ROUNDED:
        if name in at:
            at[name] = _NUMBER.sub(lambda found: _short(float(found.group()), 2), at[name])
    if at.get("transform", "").startswith("rotate(0 "):
        del at["transform"]
    if "style" in at:
        style = _SPACE_BEHIND.sub(r"\1", at["style"]).replace(f"font-family:{_FONT};", "")
        style = _DOUBLED_COLOUR.sub(r"#\1\2\3", style)
        at["style"] = style.replace(f" {_FONT}", f" {_FONT},{_FALLBACK}")


def _set_indices(text: ET.Element) -> None:
    """Set the index of every symbol in a text low and small, and what follows back on the line."""
    before, *rest = _INDEX.split(text.text or "")
    text.text = before
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
    if element.tag == "defs":
        element[:] = children
        return
    if name.startswith("matplotlib.axis"):
        # Lines, ticks and numbers of an axis come in turns; sorted, those that look alike stand together.
        children.sort(key=lambda child: child.tag)
    element[:] = []
    for look, run in groupby(children, key=_look):
        alike = list(run)
        if look and len(alike) > 1:
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

    Steps are taken between rounded points, so that rounding does not add up. In a long run, points that lie on the
    line between others, to 0.4 points, are left out: no corner moves, so no peak is lost.
    """
    parts = [
        (command, [float(number) for number in text.split()]) for command, text in _COMMAND.findall(path)
    ]
    digits = 1 if sum(len(numbers) + 1 for _, numbers in parts) > _LONG else 2
    unit = 10**digits
    drawn, short, at = "", "", [0, 0]
    for is_line, run in groupby(parts, key=lambda part: part[0] == "L"):
        rounded = [(command, [round(unit * number) for number in numbers]) for command, numbers in run]
        if is_line:
            points = [at, *(numbers for _, numbers in rounded)]
            kept = _without_idle_points(points) if digits == 1 else points
            rounded = [("l", [x - x_before, y - y_before]) for (x_before, y_before), (x, y) in pairwise(kept)]
            at = points[-1]
        for command, numbers in rounded:
            at = numbers[-2:] if command not in {"l", "z"} else at
            steps = " ".join(_short(number / unit, digits) for number in numbers).replace(" -", "-")
            again = command == drawn == "l"
            short += (" " if again and not steps.startswith("-") else "" if again else command) + steps
            drawn = command
    return short


def _short(value: float, digits: int) -> str:
    """Return a number with so many digits after the point, one or more, as short as SVG allows."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else _ZERO_BEFORE_POINT.sub(".", text)


def _without_idle_points(points: list[list[int]]) -> list[list[int]]:
    """Return the points that shape a line, by Douglas and Peucker."""
    xy = np.array(points, dtype=np.float64)
    kept, open_ = {0, len(points) - 1}, [(0, len(points) - 1)]
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        along, inner = xy[last] - xy[first], xy[first + 1 : last] - xy[first]
        # To the line between the two, not to its prolongation.
        share = np.clip(inner @ along / max(along @ along, 1.0), 0.0, 1.0)
        off = np.hypot(*(inner - share[:, None] * along).T)
        if off.max() > _IDLE:
            middle = first + 1 + int(np.argmax(off))
            kept.add(middle)
            open_ += [(first, middle), (middle, last)]
    return [points[place] for place in sorted(kept)]
