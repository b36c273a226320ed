"""A figure as a small piece of SVG for the inside of a page: text stays text, and names do not collide."""

import hashlib
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby, pairwise
from xml.etree import ElementTree as ET

import matplotlib as mpl
from matplotlib.figure import Figure

from ropefric.files.plain_text import visible
from ropefric.plotting.figure import FigureWithData
from ropefric.plotting.save import FORMATS
from ropefric.plotting.style import house_style
from ropefric.plotting.svg_path import short_number, short_path
from ropefric.plotting.words import TYPESET

_NUMBER = re.compile(r"-?(?:\d++(?:\.\d++)?|\.\d++)(?:e-?\d++)?")
_SIZE = re.compile(r"(?<![\d.])(\d++(?:\.\d++)?|\.\d++)px")
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]")
_SPACE_BEHIND = re.compile(r"([;:,])\s++")
_DOUBLED_COLOUR = re.compile(r"#([0-9a-f])\1([0-9a-f])\2([0-9a-f])\3\b")
_OPACITY = re.compile(r"(^|;)opacity:")
# A colour such as #ccc is no reference.
_REFERENCE = re.compile(r"(?<=url\(#)[^)]+|(?<=^#).+")
_ROUNDED = ("transform", "x", "y", "width", "height", "points")
_FONT = "'DejaVu Sans'"
_FALLBACK = "Verdana,sans-serif"  # of nearly the same width


def svg_text(figure: FigureWithData, *, stem: str = "") -> str:
    """Return a figure as an `<svg>` element for the inside of an HTML page; the same figure gives the same text.

    Text is text, so it can be selected and found, and no font is embedded. There is no date and no style sheet that
    would reach other parts of the page. Paths are rounded to a tenth of a point.
    """
    stream = io.BytesIO()
    with house_style(), mpl.rc_context({"svg.fonttype": "none"}), _laid_out(figure.figure):
        figure.figure.savefig(stream, format="svg", metadata=FORMATS["svg"])
    parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))  # noqa: S314
    root = ET.fromstring(stream.getvalue(), parser)  # noqa: S314  (what matplotlib has just written)
    _strip(root)
    _flatten(root)
    _rename(root, _prefix(stem) if stem else f"f{_hash(ET.tostring(root))}")
    root.attrib = {
        "role": "img",
        "aria-label": visible(figure.alt),
        "viewBox": root.attrib["viewBox"],
        "class": "figure",
        "style": f"stroke-linejoin:round;stroke-linecap:butt;white-space:pre;font-family:{_FONT},{_FALLBACK}",
    }
    return ET.tostring(root, encoding="unicode")


@contextmanager
def _laid_out(figure: Figure) -> Iterator[None]:
    """Make the layout once and hold it: left to itself, matplotlib draws everything twice to find it."""
    engine = figure.get_layout_engine()
    if engine is not None and figure.axes:
        engine.execute(figure)
        figure.set_layout_engine(None)
    try:
        yield
    finally:
        figure.set_layout_engine(engine)


def _prefix(stem: str) -> str:
    """Return a stem as the start of an id; stems that differ give prefixes that differ."""
    safe = _UNSAFE.sub("-", stem)
    return safe if safe == stem else f"{safe}-{_hash(stem.encode())}"


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:8]


def _strip(root: ET.Element) -> None:
    """Take off namespaces, white space, metadata and the style sheet, and shorten what is left."""
    for element in root.iter():
        if _is_comment(element):
            continue
        element.tag = element.tag.rpartition("}")[2]
        element.attrib = {key.rpartition("}")[2]: value for key, value in element.attrib.items()}
        if element.tag not in {"text", "tspan"} and not (element.text or "").strip():
            element.text = None
        if not (element.tail or "").strip():
            element.tail = None
        _shorten(element)
    for parent in list(root.iter()):
        children = list(parent)
        for child, following in pairwise(children):
            # Only symbols are known here; a number such as 2 × 10³ stays as matplotlib has placed it.
            words = child.text or ""
            if _is_comment(child) and TYPESET.search(words) and "$" not in TYPESET.sub("", words):
                _write_as_words(following, str(child.text).strip())
        for child in children:
            if _is_comment(child) or child.tag in {"metadata", "style"}:
                parent.remove(child)


def _is_comment(element: ET.Element) -> bool:
    return callable(element.tag)  # the parser's way to mark one


def _write_as_words(group: ET.Element, source: str) -> None:
    """Write text with symbols as one run of words; matplotlib places each of its letters for itself."""
    text = group.find("text")
    letters = [] if text is None else text.findall("tspan")
    sizes = [float(size) for letter in letters for size in _SIZE.findall(letter.get("style", ""))]
    if text is None or not sizes:
        return
    baseline, size = letters[0].get("y", "0"), max(sizes)
    text.attrib = {"y": baseline, "style": f"font-size:{size:g}px"}
    text[:] = []
    text.text, rest = None, 0
    back: dict[str, str] = {}
    for symbol in TYPESET.finditer(source):
        words = source[rest : symbol.start()]
        _append(text, words, back)
        _append(text, symbol.group(1), {"font-style": "italic"} | ({} if words else back))
        _append(text, symbol.group(2), {"dy": "2", "font-size": "70%"})
        rest, back = symbol.end(), {"dy": "-2"}
    _append(text, source[rest:], back)


def _append(text: ET.Element, words: str, attributes: dict[str, str]) -> None:
    if not words:
        return
    if attributes:
        ET.SubElement(text, "tspan", attributes).text = words
    elif len(text):
        text[-1].tail = words
    else:
        text.text = words


def _shorten(element: ET.Element) -> None:
    at = element.attrib
    if "d" in at:
        at["d"] = short_path(at["d"])
    for name in _ROUNDED:
        if name in at:
            at[name] = _NUMBER.sub(lambda found: short_number(float(found.group()), 2), at[name])
    if at.get("transform", "").startswith("rotate(0 "):
        del at["transform"]
    if "style" in at:
        style = _SPACE_BEHIND.sub(r"\1", at["style"]).replace(f"font-family:{_FONT};", "")
        style = _DOUBLED_COLOUR.sub(r"#\1\2\3", style)
        at["style"] = style.replace(f" {_FONT}", f" {_FONT},{_FALLBACK}")


def _flatten(element: ET.Element) -> None:
    """Take away groups that group nothing: those without a meaning of their own, and those without a child."""
    children: list[ET.Element] = []
    for child in element:
        _flatten(child)
        own = {key for key in child.attrib if key != "id"}
        if child.tag == "g" and not own:
            children += list(child)
        elif child.tag not in {"g", "defs"} or len(child):
            children.append(child)
    if element.attrib.get("id", "").startswith("matplotlib.axis"):
        # Lines, ticks and numbers of an axis come in turns; sorted, those that look alike stand together.
        children.sort(key=lambda child: child.tag)
    element[:] = children if element.tag == "defs" else _group_alike(children)


def _group_alike(children: list[ET.Element]) -> list[ET.Element]:
    """Return children in their order, those in a row that look alike in one group that says so once."""
    grouped: list[ET.Element] = []
    for look, run in groupby(children, key=_look):
        alike = list(run)
        if look is None or len(alike) == 1:
            grouped += alike
            continue
        group = ET.Element("g", dict(look))
        for child in alike:
            for key, _ in look:
                del child.attrib[key]
            group.append(child)
        grouped.append(group)
    return grouped


def _look(element: ET.Element) -> tuple[tuple[str, str], ...] | None:
    """Return what a group can say for an element; None where it cannot: opacity is not handed down."""
    if element.tag not in {"path", "use", "text"} or _OPACITY.search(element.get("style", "")):
        return None
    look = tuple((key, element.attrib[key]) for key in ("clip-path", "style") if key in element.attrib)
    return look or None


def _rename(root: ET.Element, prefix: str) -> None:
    """Keep the ids that something refers to, under names of this figure's own."""
    used = list(dict.fromkeys(name for value in _references(root) for name in _REFERENCE.findall(value)))
    names = {name: f"{prefix}-{place}" for place, name in enumerate(used)}
    for element in root.iter():
        own = element.attrib.pop("id", "")
        if own in names:
            element.attrib["id"] = names[own]
        for key in _REFERRING & element.attrib.keys():
            element.attrib[key] = _REFERENCE.sub(lambda found: names[found.group()], element.attrib[key])


_REFERRING = {"href", "clip-path", "style"}


def _references(root: ET.Element) -> Iterator[str]:
    for element in root.iter():
        for key in sorted(_REFERRING & element.attrib.keys()):
            yield element.attrib[key]
