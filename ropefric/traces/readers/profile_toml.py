"""An import profile as the `[import]` section of a campaign file."""

import json
import re
from collections.abc import Iterator

from ropefric.traces.readers.profile import Channel, ImportProfile

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+", re.ASCII)


def profile_to_toml(profile: ImportProfile) -> str:
    r"""Return the `[import]` section that says what a profile says; what is left open is left out.

    Constants are written as bare SI numbers.
    """
    lines = ["[import]", *_plain(profile)]
    if profile.channels:
        lines += ["", "[import.channels]"]
        lines += [f"{_key(name)} = {_channel(channel)}" for name, channel in profile.channels.items()]
    if profile.constants:
        lines += ["", "[import.constants]"]
        lines += [f"{_key(name)} = {float(value)!r}" for name, value in profile.constants.items()]
    if profile.derived:
        lines += ["", "[import.derived]"]
        lines += [f"{_key(name)} = {_string(formula)}" for name, formula in profile.derived.items()]
    return "\n".join(lines) + "\n"


def _plain(profile: ImportProfile) -> Iterator[str]:
    default = ImportProfile()
    for key in ("format", "separator", "decimal", "encoding", "table"):
        if getattr(profile, key) != getattr(default, key):
            yield f"{key} = {_string(getattr(profile, key))}"
    for key in ("header_row", "units_row", "data_row", "block_columns", "block_names_row"):
        if getattr(profile, key) != getattr(default, key):
            yield f"{key} = {getattr(profile, key)}"
    if profile.sampling_rate_Hz is not None:
        yield f'sampling_rate = "{float(profile.sampling_rate_Hz)!r} Hz"'
    if profile.missing:
        yield f"missing = [{', '.join(_string(text) for text in profile.missing)}]"


def _channel(channel: Channel) -> str:
    column = channel.column if isinstance(channel.column, int) else _string(channel.column)
    if channel.unit:
        return f"{{ column = {column}, unit = {_string(channel.unit)} }}"
    return str(column) if isinstance(channel.column, str) else f"{{ column = {column} }}"


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _string(name)


def _string(text: str) -> str:
    # JSON's escapes are TOML's, but for the delete character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
