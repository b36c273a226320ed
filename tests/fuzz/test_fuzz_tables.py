"""Trial tables: the trials that are used obey physics, or the table is refused with every line at fault."""

import json

import numpy as np
from fuzz_kit import HOSTILE, answered, fuzzed, scratch
from hypothesis import strategies as st

from ropefric.fitting.fit import fit_law
from ropefric.trials.table import read_trial_table, table_from_frame

FOLDER = scratch()
USUAL = ("trial", "wheel_radius_mm", "rope_diameter_mm", "wrap_angle_deg", "end_tension_N", "peak_N", "kept",
    "status")  # fmt: skip
HEADERS = (*USUAL, "wheel_diameter_mm", "rope_radius_mm", "wrap_turns", "wrap_angle_rad", "end_mass_kg",
    "lift_force_kN", "peak_std_N", "end_tension_std_N", "wrap_angle_std_deg", "wheel_radius_std_mm",
    "comment", "", "peak", "wheel_radius", "peak_furlong")  # fmt: skip
CELLS = ("", "40", "9.8", "180", "540", "20", "80", "321.7", "-1", "0", "-0.0", "1e300", "1e-300", "1e400",
    "5e-324", "nan", "NaN", "inf", "-inf", "0,5", "1.234,5", "1,234.5", "true", "false", "yes", "maybe", "ok",
    "no-peak", "x", '"', "a b", "9" * 50, "١", "1e", "0x10", "2024-01-01", "\x00", "\u00a0",
    *HOSTILE)  # fmt: skip
GOOD = "\n".join([",".join(USUAL)] +
    [f"t{i},{40 + 10 * (i % 3)},9.8,{180 * (1 + i % 4)},20,{40 + 7 * i},true,ok"
    for i in range(12)])  # fmt: skip


def judge(data):
    path = FOLDER / "trials.csv"
    path.write_bytes(data)
    table = answered(lambda: read_trial_table(path))
    if table is None:
        return
    used = table.used
    assert used.sum() >= 2
    assert (table.peak_N[used] > 0.0).all()
    assert (table.end_tension_N[used] > 0.0).all()
    assert np.isfinite(table.peak_N[used]).all()
    for name in ("peak_std_N", "end_tension_std_N", "wrap_std_rad", "wheel_radius_std_m"):
        values = getattr(table, name)[used]
        assert not (values < 0.0).any()
        assert not np.isinf(values).any()
    conditions = answered(table.conditions)
    if conditions is not None:
        assert len(conditions) == used.sum() == table.group().size == table.log_lift().size
        fit = answered(lambda: fit_law(table, "constant"))
        assert fit is None or json.dumps(fit.to_dict(), allow_nan=False)
    again = answered(lambda: table_from_frame(table.to_frame()))
    assert again is None or np.array_equal(again.peak_N, table.peak_N, equal_nan=True)


def check_spoilt_table(edits, junk):
    """A good table with cells replaced and text cut."""
    lines = [line.split(",") for line in GOOD.split("\n")]
    for row, column, cell in edits:
        cells = lines[row % len(lines)]
        cells[column % len(cells)] = CELLS[cell % len(CELLS)]
    text = "\n".join(",".join(line) for line in lines)
    for place, cut, new in junk:
        at = place % (len(text) + 1)
        text = text[:at] + new + text[at + cut :]
    judge(text.encode("utf-8", "surrogatepass"))


def check_any_table(header, rows, mark, ending):
    """Any columns and any cells."""
    judge(ending.join(mark.join(row) for row in [header, *rows]).encode("utf-8", "surrogatepass"))


test_spoilt, test_spoilt_long = fuzzed(check_spoilt_table, short=50, share=0.04,
    edits=st.lists(st.tuples(st.integers(0, 12), st.integers(0, 7), st.integers(0, len(CELLS) - 1)),
    max_size=5), junk=st.lists(st.tuples(st.integers(0, 700), st.integers(0, 20),
    st.sampled_from(["", ",", ";", "\n", '"', "\t", "\ufeff", "e"])), max_size=2))  # fmt: skip
test_any, test_any_long = fuzzed(check_any_table, short=40, share=0.04,
    header=st.permutations(USUAL).map(tuple) | st.lists(st.sampled_from(HEADERS), max_size=10).map(tuple),
    rows=st.lists(st.lists(st.sampled_from(CELLS), min_size=1, max_size=10), max_size=5),
    mark=st.sampled_from(",;\t"), ending=st.sampled_from(["\n", "\r\n", "\r", "\n\n"]))  # fmt: skip
