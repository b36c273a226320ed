"""Trial tables as Parquet mean what the same cells mean as CSV."""

import math

import pyarrow as pa
import pyarrow.parquet
import pytest

import ropefric as rf
from ropefric.errors import DataError, InputError
from ropefric.files import plain_text
from ropefric.files.plain_text import parquet_as_csv, parquet_bytes
from ropefric.trials.result import write_tables
from ropefric.trials.table import read_trial_table

COLUMNS = {"trial": ["=a", "b\nc", "d;e"], "wheel_diameter_mm": [80, 80, 71],
    "rope_diameter_mm": [9.8, 9.8, 0.1 + 0.2], "wrap_angle_deg": [180.0, 360.0, 540.0],
    "end_mass_kg": [2.0, 2.0, 3.0], "peak_N": [40.5, 1e2 / 3.0, math.nan], "kinetic_N": [None, 30.0, None],
    "kept": [True, True, False], "notes": [None, None, None]}  # fmt: skip


@pytest.fixture(scope="module")
def both(small_extraction, tmp_path_factory):
    return write_tables(small_extraction, tmp_path_factory.mktemp("tables"), parquet=True)


def test_an_extraction_is_the_same_table_both_ways(both):
    text, binary = read_trial_table(both[0]), read_trial_table(both[3])
    assert both[3].name == "trials.parquet"
    assert text.to_frame().equals(binary.to_frame())
    assert (text.labels, text.status) == (binary.labels, binary.status)
    assert [problem.message for problem in text.warnings] == [problem.message for problem in binary.warnings]
    one, two = rf.fit(both[0], "constant").to_dict(), rf.fit(both[3], "constant").to_dict()
    one.pop("provenance"), two.pop("provenance")
    assert one == two


def test_columns_keep_their_names_units_and_types(both):
    stored = pyarrow.parquet.read_table(both[3])
    header = both[0].read_text(encoding="utf-8").split("\n")[0].split(",")
    assert stored.column_names == header
    types = {name: str(stored.schema.field(name).type) for name in header}
    assert (types["peak_N"], types["kept"], types["trial"]) == ("double", "bool", "string")
    assert (types["saturated_samples"], types["sha256"]) == ("int64", "string")


def test_a_table_of_ones_own_keeps_every_digit(tmp_path):
    path = tmp_path / "own.PARQUET"
    pyarrow.parquet.write_table(pa.table(COLUMNS), path)
    found = read_trial_table(path)
    assert (found.trial, found.rope_radius_m[0]) == (("=a", "b c", "d;e"), 0.0049)
    assert found.rope_radius_m[2] == pytest.approx((0.1 + 0.2) / 2000, rel=1e-15)
    assert (found.peak_N[1], found.kept.tolist()) == (1e2 / 3.0, [True, True, False])
    assert found.used.tolist() == [True, True, False]


def test_bad_files_say_what_is_wrong(tmp_path):
    (tmp_path / "text.parquet").write_text("trial,peak_N\n", encoding="utf-8")
    with pytest.raises(DataError, match="not a readable Parquet file"):
        read_trial_table(tmp_path / "text.parquet")
    good = parquet_bytes([{"a": 1.5}], key="")
    for cut in (len(good) // 2, len(good) - 3):
        with pytest.raises(DataError, match="not a readable Parquet file"):
            parquet_as_csv(good[:cut], "cut.parquet")
    assert parquet_as_csv(good, "good.parquet") == "a\n1.5\n"
    assert parquet_as_csv(parquet_bytes([], key=""), "empty.parquet").strip() == ""


def test_without_pyarrow_it_says_what_to_install(monkeypatch, tmp_path):
    def missing(name):
        raise ImportError(name)

    path = tmp_path / "t.parquet"
    path.write_bytes(parquet_bytes([{"a": 1}], key=""))
    monkeypatch.setattr(plain_text, "import_module", missing)
    with pytest.raises(InputError, match="pyarrow") as caught:
        read_trial_table(path)
    assert "ropefric[parquet]" in caught.value.fix
