"""How results show themselves: a few lines, a small table, a frame, a figure, all driven by what a class declares."""

import html
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from enum import Enum
from operator import attrgetter
from typing import TYPE_CHECKING, Any, ClassVar

from ropefric.quantities import split_unit_suffix
from ropefric.section import plus_minus

if TYPE_CHECKING:
    import pandas as pd

_MOST_VALUES, _MOST_ROWS, _MOST_TEXT = 4, 10, 90

_ABOVE: dict[str, Callable[[], Callable[..., Any]]] = {}


class Shown:
    """Base of all results: `repr`, `_repr_html_`, `to_frame()` and `plot()`.

    A class declares in `_said` what its text shows, as paths of attributes with their standard uncertainty after
    a ±: `"peak_N ± peak_std_N"`, under another name `"verdict=verdict.word"`. Units are read off the names. `_framed`
    says what `to_frame()` holds: an attribute with records or columns, or several attributes that are columns of one
    length; by default one row of the text.
    """

    __slots__ = ()
    _said: ClassVar[tuple[str, ...]] = ()
    _framed: ClassVar[str | tuple[str, ...]] = ()

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.__repr__ = cls.__str__ = Shown.__repr__  # type: ignore[method-assign,assignment]  # others would write their own

    def __repr__(self) -> str:
        rows = [(name, text) for name, text in _rows(self) if text]
        width = max((len(name) for name, _ in rows), default=0)
        return "\n".join([type(self).__name__, *(f"  {name:{width}}  {text}" for name, text in rows)])

    def _repr_html_(self) -> str:
        cells = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>"
            for name, text in _rows(self)
            if text
        )
        head = f"<table><caption>{type(self).__name__}</caption>{cells}</table>"
        if not self._framed and type(self).to_frame is Shown.to_frame:
            return head
        frame = self.to_frame()
        return head + frame.head(_MOST_ROWS).to_html(index=False, float_format="{:.5g}".format, border=0)

    def _more_said(self) -> Iterator[tuple[str, str]]:
        """Yield further lines of the `repr`: name and text."""
        return iter(())

    def to_frame(self) -> "pd.DataFrame":
        """Return the result as a pandas DataFrame."""
        import pandas as pd  # noqa: PLC0415  (quick start-up)

        if isinstance(self._framed, str):
            found = attrgetter(self._framed)(self)
            found = found() if callable(found) else found
            if isinstance(found, Mapping):
                return pd.DataFrame(dict(found))
            return pd.DataFrame([_record(item) for item in found])
        columns: dict[str, Any] = {}
        for path in self._framed or _paths(self._said):
            name, value = path.rpartition(".")[2], attrgetter(path)(self)
            if getattr(value, "ndim", 1) == 2 and value.shape[1] == 2:
                columns |= {f"{name}_low": value[:, 0], f"{name}_high": value[:, 1]}
            else:
                columns[name] = value if self._framed else [_bare(value)]
        return pd.DataFrame(columns)

    def plot(self, *args: Any, **options: Any) -> Any:
        """Return the matplotlib axes the result is drawn on: the figure of the report.

        `ax`, also as the first argument, are axes to draw on; without them a figure is made, `axes.figure`. A
        break-away takes its trace, a fit `over`, a sweep `quantity`.
        """
        return from_above("plot")(self, *args, **options)


def provide(**functions: Callable[[], Callable[..., Any]]) -> None:
    """Set how the functions of higher rooms that are methods of results are found; each is loaded when first called."""
    _ABOVE.update(functions)


def from_above(name: str) -> Callable[..., Any]:
    """Return the function of a higher room that is behind a method of results."""
    return _ABOVE[name]()


def _paths(said: Sequence[str]) -> Iterator[str]:
    for one in said:
        yield from (part.strip() for part in one.rpartition("=")[2].split("±"))


def _bare(value: Any) -> Any:
    return value.value if isinstance(value, Enum) else value


def _record(item: Any) -> dict[str, Any]:
    """Return the plain numbers, words and pairs of numbers of a record; an interval becomes two columns."""
    for as_mapping in ("to_dict", "_asdict"):
        item = getattr(item, as_mapping, lambda item=item: item)()
    if not isinstance(item, Mapping):
        item = {one.name: getattr(item, one.name) for one in fields(item)}
    found: dict[str, Any] = {}
    for name, value in item.items():
        if isinstance(value, tuple) and len(value) == 2 and all(isinstance(one, float) for one in value):
            found |= {f"{name}_low": value[0], f"{name}_high": value[1]}
        elif value is None or isinstance(value, str | int | float):
            found[name] = _bare(value)
    return found


def _rows(result: Shown) -> Iterator[tuple[str, str]]:
    for said in result._said:  # noqa: SLF001  (its own base class)
        path, _, of_std = (part.strip() for part in said.rpartition("=")[2].partition("±"))
        name, unit = split_unit_suffix(said.rpartition("=")[0] or path.rpartition(".")[2])
        std = attrgetter(of_std)(result) if of_std else None
        yield name.replace("_", " "), in_words(attrgetter(path)(result), unit, std)
    yield from result._more_said()  # noqa: SLF001


def in_words(value: Any, unit: str = "", std: Any = None) -> str:
    """Return a value of any kind in a few words: a number with its unit and uncertainty, a short list; "" for none.

    >>> in_words(70.1234, "N", 0.0512), in_words(float("nan"), "N"), in_words(0.01234, "m")
    ('70.123 ± 0.051 N', '', '0.01234 m')
    """
    if hasattr(value, "tolist"):
        value, std = value.tolist(), getattr(std, "tolist", lambda: std)()
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    if isinstance(value, int | float) and not isinstance(value, Enum):
        text = _number(float(value), std) if isinstance(value, float) else str(value)
        return f"{text} {unit}".strip() if text else ""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return _list_in_words(value, unit, std)
    return _cut(" ".join(str(_bare(value)).split()))


def _list_in_words(values: Sequence[Any], unit: str, std: Any) -> str:
    if len(values) > 1 and all(isinstance(one, bool) for one in values):
        return f"{sum(values)} of {len(values)}"
    if len(values) > _MOST_VALUES:
        if not all(isinstance(one, int | float) for one in values):
            return str(len(values))
        low, high = min(values), max(values)
        span = f"{in_words(low)} to {in_words(high, unit)}" if high > low else in_words(low, unit)
        return f"{len(values)}: {span}"
    texts = []
    for one, its in zip(values, std if isinstance(std, Sequence) else [std] * len(values), strict=True):
        ends = one if isinstance(one, list) else [one]
        texts.append(" to ".join(in_words(end, "", its) or "–" for end in ends))
    return f"{_cut(', '.join(texts))} {unit}".strip()


def _cut(text: str) -> str:
    return text if len(text) <= _MOST_TEXT else f"{text[:_MOST_TEXT].rpartition(' ')[0]} …"


def _number(value: float, std: Any) -> str:
    if math.isnan(value):
        return ""
    known = isinstance(std, float) and 0.0 < std < math.inf and math.isfinite(value)
    return plus_minus(value, std) if known else f"{value:.4g}"
