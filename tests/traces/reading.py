"""Files read to traces, refused ones, and packages that are not there."""

import builtins

import pytest

from ropefric.errors import DataError
from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.profile import ImportProfile


def read(path, **keys):
    """Return the traces of a file by a profile of some keys."""
    profile = ImportProfile(**keys)
    return [assemble_trace(raw, profile) for raw in read_recordings(path, profile, shown_as="run")]


def refused(path, **keys):
    """Return the error that a file ends in."""
    with pytest.raises(DataError) as caught:
        read(path, **keys)
    return caught.value


def hide(monkeypatch, packages):
    """Let some packages not be installed."""
    real = builtins.__import__

    def importing(name, *args, **kwargs):
        if name.split(".")[0] in packages:
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", importing)
