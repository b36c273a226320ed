"""Time stamps written as text -> seconds since the first: ISO, German, American, with and without zone, clock only."""

import re
from collections.abc import Callable, Iterable, Sequence
from datetime import UTC, date, datetime, timedelta
from zoneinfo import ZoneInfo

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.errors import DataError, InputError

ORDERS = {"ymd": "year, month, day", "dmy": "day, month, year", "mdy": "month, day, year"}
"""What the numbers of a date mean, by the key `date_order`."""

_SEPARATORS = re.compile(r"[-/.]")
_STAMP = re.compile(
    r"(?:(?P<date>\d{4}([-/.])\d{1,2}\2\d{1,2}|\d{1,2}([-/.])\d{1,2}\3(?:\d{4}|\d\d))(?:T|,?\s++|,))?"
    r"(?P<hour>\d{1,3}):(?P<minute>[0-5]\d)(?::(?P<second>[0-5]\d|60)(?:[.,:](?P<part>\d{1,30}))?)?"
    r"(?:\s*+(?P<half>[AaPp])\.?[Mm]\.?)?(?:\s*+(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?))?",
    re.ASCII,
)
_DAY_S = 86400
_PS = 10**12
_HOUR_BACK_S = (3000, 3600)  # a step back of an hour, less the time that passed

_Refuse = Callable[[int, str, str], DataError]


def is_stamp(text: str) -> bool:
    """Return whether a text is a time of day with seconds, or a date with a time of day."""
    if ":" not in text[:16]:
        return False
    found = _STAMP.fullmatch(text)
    return found is not None and bool(found["date"] or found["second"])


def read_stamps(
    cells: Iterable[tuple[int, str]], *, order: str, zone: str, no_value: Iterable[str], refuse: _Refuse
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the seconds from the first stamp of a column on, by whole picoseconds, and how they were understood.

    Stamps with a zone count in UTC. Without one they are local times of `zone`, or, where none is named, of a clock
    that nobody sets; one that goes back by an hour is refused. Without a date, a fall by more than twelve hours is
    midnight. A date whose order only the writer can know is refused.
    """
    rows, empty = list(cells), frozenset(no_value)
    found = [None if text in empty else _STAMP.fullmatch(text) for _, text in rows]
    first = next((match for match in found if match is not None), None)
    if first is None:
        return np.full(len(rows), np.nan), ()
    days, said = _days({match["date"] for match in found if match and match["date"]}, order, rows, refuse)
    place = _place(zone)
    offsets, zones = dict[int, tuple[int, int]](), dict[str, int]()
    values: list[int | None] = []
    last, n_midnights = None, 0
    for (line, text), match in zip(rows, found, strict=True):
        if text in empty:
            values.append(None)
            continue
        if match is None or any((match[key] is None) != (first[key] is None) for key in ("date", "zone")):
            raise refuse(
                line, f"cannot read {text[:40]!r} as a time stamp like {first[0]!r}", "mend the cell"
            )
        at_s = days[match["date"]] * _DAY_S if match["date"] else 0
        at_s += _second_of_day(match, line, refuse)
        part = int((match["part"] or "").ljust(12, "0")[:12])
        if match["zone"]:
            at_s -= zones.setdefault(match["zone"], _offset_s(match["zone"]))
        elif match["date"] and place is not None:
            early_s, late_s = offsets.setdefault(at_s // 900, _offsets_s(at_s // 900 * 900, place))
            at_s -= early_s
            if last is not None and at_s * _PS + part < last:  # the hour that summer's end repeats
                at_s += early_s - late_s
        elif match["date"]:
            if last is not None and _HOUR_BACK_S[0] <= last // _PS - at_s <= _HOUR_BACK_S[1]:
                fix = 'name the zone of the clock, for example [import] time_zone = "Europe/Berlin"'
                raise refuse(line, f"the clock goes back by an hour to {text!r}: summer time ended", fix)
        else:
            n_midnights += last is not None and last // _PS - (at_s + n_midnights * _DAY_S) > _DAY_S // 2
            at_s += n_midnights * _DAY_S
        last = at_s * _PS + part
        values.append(last)
    start = next(value for value in values if value is not None)
    seconds = [np.nan if value is None else (value - start) / _PS for value in values]
    facts = [said or "without a date", *([f"local time of {zone}"] if place and not first["zone"] else [])]
    facts += [f"past midnight {n_midnights} times"] if n_midnights else []
    return np.array(seconds), (f"text time stamps ({', '.join(facts)}) from {first[0]} on",)


def _place(zone: str) -> ZoneInfo | None:
    try:
        return ZoneInfo(zone) if zone else None
    except (LookupError, ValueError, OSError):
        fix = 'write it like "Europe/Berlin"'
        raise InputError(f"there is no time zone {zone!r}", key="[import] time_zone", fix=fix) from None


def _days(
    texts: set[str], order: str, rows: Sequence[tuple[int, str]], refuse: _Refuse
) -> tuple[dict[str, int], str]:
    """Return the day number of every date, and the order of their numbers in words."""
    if not texts:
        return {}, ""
    numbers = {text: [int(part) for part in _SEPARATORS.split(text)] for text in texts}
    some = min(texts)
    line = next(line for line, text in rows if text.startswith(some))
    if all(text[:4].isdigit() for text in texts):
        order = "ymd"
    elif not order and all("." in text for text in texts):
        order = "dmy"
    elif not order:
        # Nobody can tell the fourth of March from the third of April, but the 25th of a month is a day.
        late = (way for way, at in (("dmy", 0), ("mdy", 1)) if any(n[at] > 12 for n in numbers.values()))
        order = next(late, "")
    if not order:
        why = f"{some!r} may mean day, month, year or month, day, year"
        raise refuse(line, why, 'set [import] date_order = "mdy" or "dmy"')
    days = {}
    for text, parts in numbers.items():
        named = dict(zip(order, parts, strict=True))
        year = named["y"] if named["y"] > 99 else 2000 + named["y"]
        try:
            days[text] = date(year, named["m"], named["d"]).toordinal()
        except ValueError:
            line = next(line for line, cell in rows if cell.startswith(text))
            why = f"there is no date {text!r} in the order {ORDERS[order]}"
            raise refuse(line, why, "mend it, or correct [import] date_order") from None
    return days, ORDERS[order]


def _second_of_day(match: re.Match[str], line: int, refuse: _Refuse) -> int:
    hour, half = int(match["hour"]), (match["half"] or "").lower()
    if half:
        hour = hour % 12 + 12 * (half == "p") if 1 <= hour <= 12 else 99
    if hour > 23 and (half or match["date"]):
        raise refuse(line, f"there is no such hour as in {match[0]!r}", "mend the cell")
    return hour * 3600 + int(match["minute"]) * 60 + int(match["second"] or 0)


def _offset_s(zone: str) -> int:
    if zone[0] not in "+-":
        return 0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    return (int(digits[:2]) * 3600 + int(digits[2:]) * 60) * (-1 if zone[0] == "-" else 1)


def _offsets_s(at_s: int, place: ZoneInfo) -> tuple[int, int]:
    """Return how far a local time is ahead of UTC, where it comes first and where it comes again."""
    local = datetime(1, 1, 1, tzinfo=UTC) + timedelta(seconds=at_s - _DAY_S)
    both = (local.replace(tzinfo=place, fold=fold).utcoffset() or timedelta() for fold in (0, 1))
    early, late = (int(offset.total_seconds()) for offset in both)
    return early, late
