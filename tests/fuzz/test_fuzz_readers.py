"""Bytes of recordings: a recording with one length and no infinity comes out, or a refusal that helps."""

import gzip

import numpy as np
from fuzz_kit import answered, fuzzed, scratch
from hypothesis import strategies as st

from ropefric.traces.assemble import assemble_trace
from ropefric.traces.readers import read_recordings
from ropefric.traces.readers.inspection import inspect_file
from ropefric.traces.readers.profile import Channel, ImportProfile

FOLDER = scratch()
ROWS = [(i * 0.01, 12.5 + 1.5 * i) for i in range(24)]


def _text(separator=",", decimal=".", head="time_s{0}force_N\n"):
    rows = "".join(f"{t:.2f}{separator}{f:.1f}\n" for t, f in ROWS)
    return head.format(separator) + (rows.replace(".", decimal) if decimal != "." else rows)


GOOD = (_text(), _text(";", ","), _text("\t"), _text("|"),
    "# rig 2\nOperator;Jo\n\n" + _text(";", ",", "t (s){0}F (kN)\n"),
    "F,t,,\nN,s,,\nA,,B,\n" + "".join(f"{f},{t},{f + 1},{t}\n" for t, f in ROWS),
    "force_N\n" + "".join(f"{f}\n" for _, f in ROWS))  # fmt: skip
JUNK = ("", '"', "'", ",", ";", "\t", "\n", "\r", "\r\n", "\x00", "\ufeff", "-", ".", "e", "E+", "1e400",
    "nan", "inf", "NA", "#", "é", "\x81", " ", "1,234,567", "12:00:01", "2024-01-01", "0x1F", "1_000",
    "9" * 400, "time_s", "force_N", "s", "(", "µ")  # fmt: skip
FILES = (*((name, b"") for name in ("r.csv", "r.txt", "r.csv.gz", "r.mat", "r.xlsx", "r.tdms")),
    ("r.mat", b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"), ("r.tdms", b"TDSm"), ("r.xlsx", b"PK\x03\x04"),
    ("r.ods", b"PK\x03\x04"),
    ("r.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"), ("r.h5", b"\x89HDF\r\n\x1a\n"), ("r.dat", b"\xff\xfe"),
    ("r.cmbl", b"<Document><DataSet><DataColumn><ColumnCells>"),
    ("r.lvm", b"LabVIEW Measurement\t\n***End_of_Header***\n***End_of_Header***\nX_Value\tForce\n"),
    ("r.csv", b"Interval,1,Interval,1\nChannel name,a,Channel name,b\nUnit,s,Unit,N\n"),
    ("r.csv", b"Axis1\nNumber of sampling data,1\nSampling time interval(ms),1\n"))  # fmt: skip
PROFILES = (ImportProfile(), ImportProfile(), ImportProfile(sampling_rate_Hz=1000.0),
    ImportProfile(decimal=","), ImportProfile(separator=";"), ImportProfile(missing=("NA", "")),
    ImportProfile(header_row=3, units_row=2, block_names_row=2), ImportProfile(separator=" ", data_row=5),
    ImportProfile(header_row=0, channels={"time": Channel(column=1, unit="s"), "force": Channel(column=2, unit="N")}),
    ImportProfile(format="delimited", header_row=1),
    ImportProfile(format="wide", header_row=1, units_row=2, block_names_row=3, data_row=4,
    block_columns=2))  # fmt: skip


def judge(data, name, profile):
    """Read bytes as a file; assert what holds for every recording."""
    path = FOLDER / name
    path.write_bytes(data)
    for found in answered(lambda: read_recordings(path, profile, shown_as=name)) or ():
        lengths = {values.size for values in found.columns.values()}
        assert len(lengths) == 1
        for values in found.columns.values():
            assert values.dtype == np.float64
            assert not np.isinf(values).any()
        trace = answered(lambda found=found: assemble_trace(found, profile))
        if trace is not None:
            assert (np.diff(trace.time_s) > 0).all()
            assert trace.force_N.shape == trace.time_s.shape
    found = answered(lambda: inspect_file(path, profile))
    assert found is None or found.to_dict()


def check_spoilt_text(which, edits, name, profile):
    """Text with a few pieces cut, doubled or replaced."""
    text = GOOD[which]
    for place, cut, junk in edits:
        at = place % (len(text) + 1)
        text = text[:at] + junk + text[at + cut :]
    data = text.encode("utf-8", "surrogatepass")
    judge(gzip.compress(data, mtime=0) if name.endswith(".gz") else data, name, PROFILES[profile])


def check_bytes(file, data, profile):
    """Anything at all, also after the first bytes of a format."""
    name, begin = file
    judge(begin + data, name, PROFILES[profile])


PROFILE = st.integers(0, len(PROFILES) - 1)
test_spoilt_text, test_spoilt_text_long = fuzzed(check_spoilt_text, short=60, share=0.03,
    which=st.integers(0, len(GOOD) - 1), edits=st.lists(st.tuples(st.integers(0, 900), st.integers(0, 30),
    st.sampled_from(JUNK)), max_size=6), name=st.sampled_from(["r.csv", "r.csv", "r.txt", "r.csv.gz"]),
    profile=PROFILE)  # fmt: skip
test_bytes, test_bytes_long = fuzzed(check_bytes, short=60, share=0.03, file=st.sampled_from(FILES),
    data=st.binary(max_size=300) | st.text("0123456789.,;\t\n\r -+eE\"'#aN", max_size=200).map(str.encode),
    profile=PROFILE)  # fmt: skip
