"""Paths of an SVG with as few characters as they can be drawn from."""

import re
from itertools import pairwise

import numpy as np

_LONG = 60
"""Numbers in a path above which a tenth of a point is fine enough."""
_IDLE = 4.0
"""How far off a line, in tenths of a point, a point of a long run may lie and be left out."""
_TOKEN = re.compile(r"[A-Za-z]|-?(?:\d++(?:\.\d++)?|\.\d++)(?:e-?\d++)?")
_ZERO_BEFORE_POINT = re.compile(r"^(-?)0\.")
_SIZES = {"Q": 4, "C": 6, "z": 0, "Z": 0}


def short_number(value: float, digits: int) -> str:
    """Return a number with so many digits after the point, one or more, as short as SVG allows."""
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else _ZERO_BEFORE_POINT.sub(r"\1.", text)


def short_path(path: str) -> str:
    """Return a path with rounded numbers, its straight runs as steps from point to point.

    Steps are taken between rounded points, so that rounding does not add up. In a long run, points that lie on the
    line between others, to 0.4 points, are left out: no corner moves, so no peak is lost.
    """
    tokens = _TOKEN.findall(path)
    digits = 1 if len(tokens) > _LONG else 2
    unit = 10.0**digits
    parts: list[tuple[str, list[int]]] = []
    run: list[tuple[int, int]] = []
    command, place = "", 0
    while place < len(tokens):
        if tokens[place].isalpha():
            command, place = tokens[place], place + 1
        size = _SIZES.get(command, 2)
        numbers = [round(float(token) * unit) for token in tokens[place : place + size]]
        place += size
        if command != "L":
            parts += _steps(run, digits)
            parts.append((command, numbers))
            run = []
        run += [(numbers[-2], numbers[-1])] if numbers else []
    return _joined([*parts, *_steps(run, digits)], unit, digits)


def _steps(run: list[tuple[int, int]], digits: int) -> list[tuple[str, list[int]]]:
    """Return a run of straight lines as steps from its first point."""
    points = _without_idle_points(run) if digits == 1 else run
    pairs = pairwise(points)
    return [("l", [x - before_x, y - before_y]) for (before_x, before_y), (x, y) in pairs]


def _without_idle_points(points: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the points that shape a line, by Douglas and Peucker."""
    if len(points) < 3:
        return points
    kept = {0, len(points) - 1}
    open_ = [(0, len(points) - 1)]
    xy = np.array(points, dtype=np.float64)
    while open_:
        first, last = open_.pop()
        if last - first < 2:
            continue
        along, inner = xy[last] - xy[first], xy[first + 1 : last] - xy[first]
        length = float(np.hypot(*along))
        off = np.abs(inner @ [along[1], -along[0]]) / length if length else np.hypot(*inner.T)
        # Points beyond either end are off the line too, however near they are to its prolongation.
        beyond = inner @ along / length if length else np.zeros(len(inner))
        off = np.maximum(off, np.maximum(beyond - length, -beyond))
        worst = int(np.argmax(off))
        if off[worst] > _IDLE:
            middle = first + 1 + worst
            kept.add(middle)
            open_ += [(first, middle), (middle, last)]
    return [points[place] for place in sorted(kept)]


def _joined(parts: list[tuple[str, list[int]]], unit: float, digits: int) -> str:
    text, last = [], ""
    for command, numbers in parts:
        drawn = "" if command == last == "l" else command
        text.append(
            drawn + _packed([short_number(number / unit, digits) for number in numbers], first=bool(drawn))
        )
        last = command
    return "".join(text)


def _packed(numbers: list[str], *, first: bool) -> str:
    text = ""
    for number in numbers:
        text += number if first or number.startswith("-") else f" {number}"
        first = False
    return text
