"""Files read to traces, and refused ones."""

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
