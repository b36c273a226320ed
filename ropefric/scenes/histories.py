"""The histories of a start-up as one wide table: every quantity of every span, roller and tensioner over time."""

from collections.abc import Iterator

import numpy as np

from ropefric.arrays import FloatArray
from ropefric.systems.press.transient.start_up import StartUp


def start_up_columns(found: StartUp) -> dict[str, FloatArray]:
    """Return the histories of a start-up by column name, each of shape (n,).

    Columns of a span, roller or tensioner end in its name: `tension_N.8`, `utilisation.2`, `travel_m.3`.
    """
    spans = [span.name for span in found.press.spans]
    rollers = [roller.name for roller in found.press.rollers]
    tensioners = [roller.name for roller in found.press.tensioners]
    columns = {"time_s": found.time_s, "drive_speed_m_s": found.drive_speed_m_s}
    columns |= dict(_spread("tension_N", spans, found.tension_N))
    columns |= dict(_spread("travel_m", tensioners, found.travel_m))
    for name in (
        "roller_speed_rad_s",
        "relative_angle_rad",
        "contact",
        "slip_m",
        "slip_speed_m_s",
        "friction_N",
    ):
        columns |= dict(_spread(name, rollers, getattr(found, name)))
    if found.utilisation is not None:
        columns |= dict(_spread("utilisation", rollers, found.utilisation))
    return columns


def _spread(name: str, members: list[str], values: FloatArray) -> Iterator[tuple[str, FloatArray]]:
    for place, member in enumerate(members):
        yield f"{name}.{member}", np.asarray(values[:, place], dtype=np.float64)
