"""The files of a simulated campaign, as text and bytes that are the same for the same numbers."""

import csv
import gzip
import io
import math
from collections.abc import Iterable, Mapping, Sequence

from ropefric.files.plain_text import to_spreadsheet
from ropefric.rig.plan import CampaignPlan, RigCondition
from ropefric.rig.protocols import RIG_PROTOCOLS
from ropefric.rig.story import SimulatedRecording


def packed(text: str) -> bytes:
    """Return text as gzip bytes without name and time, so that the same text gives the same bytes."""
    buffer = io.BytesIO()
    # Level 9 takes five times as long for a thousandth of the size: time stamps are what fills these files.
    with gzip.GzipFile(filename="", mode="wb", compresslevel=6, fileobj=buffer, mtime=0) as stream:
        stream.write(text.encode())
    return buffer.getvalue()


def recording_text(recording: SimulatedRecording) -> str:
    """Return a recording as CSV text: `time_s` with 6 decimals, `counts` as whole numbers, empty where missing."""
    counts = ("" if math.isnan(count) else str(int(count)) for count in recording.counts.tolist())
    rows = [f"{time:.6f},{count}" for time, count in zip(recording.time_s.tolist(), counts, strict=True)]
    return "\n".join(["time_s,counts", *rows, ""])


def table_text(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a CSV table."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(
        [to_spreadsheet(cell) if isinstance(cell, str) else cell for cell in row] for row in rows
    )
    return buffer.getvalue()


def toml_value(value: object) -> str:
    """Return a TOML literal of a string, number, boolean, list or (inline) table; floats to 12 digits."""
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(f"{value:.12g}"))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, Sequence):
        return "[" + ", ".join(toml_value(item) for item in value) + "]"
    return str(value)


def quantity_text(value: float, unit: str) -> str:
    """Return a quantity as people write it."""
    return f"{value:.10g} {unit}"


def campaign_text(plan: CampaignPlan) -> str:
    """Return the `campaign.toml` of a plan."""
    bench = plan.bench
    radii = {c.wheel: c.wheel_radius_m for c in sorted(plan.conditions, key=_radius)}
    lines = [
        "# Simulated by ropefric's virtual rig; no rope was pulled. The truth is in truth.toml.",
        *_keys(schema="ropefric.campaign/1", name=f"{plan.name} (simulated)", trials="trials.csv"),
        *_table(
            "rope",
            diameter=quantity_text(1e3 * plan.rope_diameter_m, "mm"),
            linear_density=quantity_text(1e3 * plan.rope_linear_density_kg_m, "g/m"),
            material="polyamide, kernmantle (simulated)",
        ),
    ]
    for name, radius_m in radii.items():
        radius = quantity_text(1e3 * radius_m, "mm")
        lines += _table(f"wheels.{name}", radius=radius, material="aluminium (simulated)")
    for cell in bench.cells:
        lines += _table(
            f"cells.{cell.name}",
            full_scale=_force_text(cell.full_scale_N),
            linearity=_share_text(cell.linearity),
            hysteresis=_share_text(cell.hysteresis),
            repeatability=_share_text(cell.repeatability),
            transmitter=_share_text(cell.transmitter),
        )
        nominal = {"zero_voltage": (cell.zero_V, 0.0), "full_scale_voltage": (cell.full_scale_V, 5.0)}
        lines += _keys(**{key: quantity_text(v, "V") for key, (v, usual) in nominal.items() if v != usual})
    low, high = quantity_text(bench.adc.low_V, "V"), quantity_text(bench.adc.high_V, "V")
    idle_s = math.floor(20.0 * (bench.idle_s[0] - 0.01)) / 20.0
    lines += [
        *_table("adc", bits=bench.adc.bits, low=low, high=high),
        *_table("sampling", rate=_rate_text(bench.sampling_rate_Hz)),
        *_table("protocol", name=plan.protocol),
        *_table("tare", interval=["0 s", quantity_text(idle_s, "s")]),
        *_table("smoothing", window="auto"),
        *_table("rejection", rule="two-sigma"),
        *_table("weights", tolerance="0.05 %"),
        *_table(
            "design",
            wheel_radius=quantity_text(1e3 * plan.design.wheel_radius_m, "mm"),
            wrap_angle=quantity_text(math.degrees(plan.design.wrap_angle_rad), "deg"),
            end_tension=quantity_text(plan.design.end_tension_N, "N"),
        ),
        *_table("import", format="delimited", separator=",", decimal="."),
        *_table("import.channels", time="time_s", counts="counts"),
    ]
    return "\n".join([*lines, ""])


def _radius(condition: RigCondition) -> float:
    return condition.wheel_radius_m


def _keys(**values: object) -> list[str]:
    return [f"{key} = {toml_value(value)}" for key, value in values.items()]


def _table(title: str, /, **values: object) -> list[str]:
    return ["", f"[{title}]", *_keys(**values)]


def _force_text(force_N: float) -> str:
    return quantity_text(force_N / 1e3, "kN") if force_N >= 1e3 else quantity_text(force_N, "N")


def _rate_text(rate_Hz: float) -> str:
    return quantity_text(rate_Hz / 1e3, "kHz") if rate_Hz >= 1e3 else quantity_text(rate_Hz, "Hz")


def _share_text(share: float) -> str:
    return quantity_text(100.0 * share, "%FS")


def known_force(plan: CampaignPlan, condition: RigCondition, lift_force_N: float) -> tuple[str, float]:
    """Return the trial list's column for the force known from the weights, and that force [N].

    The weights hang on the slack side, or, where the slack side is measured, on the tight side.
    """
    if RIG_PROTOCOLS[plan.protocol].measures_lift:
        return "end_tension_N", condition.end_tension_N
    return "lift_force_N", lift_force_N
