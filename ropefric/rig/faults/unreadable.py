"""A file that was cut off or overwritten."""

import numpy as np

from ropefric.rig.faults.fault import Fault
from ropefric.traces.breakaway import Status

__all__ = ["FAULT"]


def _apply(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.5:
        return data[: int(len(data) * rng.uniform(0.2, 0.8))]
    head = rng.integers(0, 256, 64, dtype=np.uint8).tobytes()
    return b"\x00" + head[1:] + data[64:]  # whatever the draw, this is no gzip header


FAULT = Fault(
    name="unreadable",
    meaning="the file is cut off, or its beginning overwritten",
    expected_status=Status.UNREADABLE,
    rate=0.0025,
    on_bytes=_apply,
)
