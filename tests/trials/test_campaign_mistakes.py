"""Every kind of mistake in campaign.toml, one by one: code, line, key, what is said and how to mend it."""

# ruff: noqa: E501  (a mistake a row reads better than a mistake a page)

from pathlib import Path

import pytest

from ropefric.errors import RopefricError
from ropefric.trials.campaign import check_campaign, load_campaign

# What is replaced, by what (its first line is where the problem is), code, key, part of the message, part of the fix.
MISTAKES = {
    "other schema": ('"ropefric.campaign/1"', '"ropefric.campaign/9"', "RF110", "schema", "campaign/9", "ropefric.campaign/1"),
    "unknown top key": ("[design]", "[desing]", "RF120", "desing", "unknown key 'desing'", "did you mean 'design'?"),
    "unknown key": ('diameter = "9.8', 'diametre = "9.8', "RF120", "rope.diametre", "unknown key 'diametre' in [rope]", "did you mean 'diameter'?"),
    "bare number": ('diameter = "9.8 mm"', "diameter = 9.8", "RF130", "rope.diameter", 'expected text like "40 mm", got 9.8', '"9.8 mm"'),
    "number without unit in text": ('"9.8 mm"', '"9.8"', "RF130", "rope.diameter", "'9.8' has no unit", '"9.8 mm"'),
    "decimal comma": ('"9.8 mm"', '"9,8 mm"', "RF130", "rope.diameter", "decimal comma", "decimal point"),
    "unit of another dimension": ('"9.8 mm"', '"9.8 N"', "RF130", "rope.diameter", "'N' is not a unit of length", "'mm'"),
    "knots": ('"1 kN"', '"1 kn"', "RF130", "cells.K1.full_scale", "knot", "'kN'"),
    "arithmetic as unit": ('"9.8 mm"', '"9.8 9**9**9**9"', "RF130", "rope.diameter", "not a unit", "'mm'"),
    "endless exponent": ('"9.8 mm"', '"1e-99999999999999999999 mm"', "RF130", "rope.diameter", "out of range", "40 mm"),
    "negative": ('"9.8 mm"', '"-9.8 mm"', "RF110", "rope.diameter", "not more than 0", "40 mm"),
    "text for a table": ('[weights]\ntolerance = "0.05 %"', "", "RF110", "weights", 'expected a table, got "0.05 %"', "[weights]"),
    "wheel without table": ('[wheels.W60]\ndiameter = "120 mm"', '[wheels]\nW60 = "60 mm"', "RF110", "wheels.W60", 'expected a table, got "60 mm"', "[wheels.W60]"),
    "two sizes": ('diameter = "9.8 mm"', 'diameter = "9.8 mm"\nradius = "5 mm"', "RF111", "rope.diameter", "both", "remove one"),
    "no size": ('diameter = "9.8 mm"', "", "RF121", "rope", "neither radius nor diameter", 'diameter = "9.8 mm"'),
    "missing key": ('full_scale = "1 kN"', "", "RF121", "cells.K1.full_scale", "'full_scale' is missing in the table [cells.K1]", "add full_scale"),
    "share without per cent": ('"0.02 %FS"', '"0.02"', "RF130", "cells.K1.linearity", "no per-cent sign", "0.02 %FS"),
    "share too large": ('"0.02 %FS"', '"20 %FS"', "RF110", "cells.K1.linearity", "not between 0 % and 10 %", "0.02 %FS"),
    "voltages the wrong way": ('full_scale_voltage = "5 V"', 'full_scale_voltage = "-5 V"', "RF110", "cells.K1.full_scale_voltage", "not above 0 V", "swap"),
    "one calibration point": ('["0 N", "0.002 V"], ', "", "RF110", "cells.K1.calibration_points", "one calibration point", "two or more"),
    "calibration point without unit": ('["500 N", "2.501 V"]', "[500, 2.501]", "RF130", "cells.K1.calibration_points[1]", "got 500", '"500 N"'),
    "date in quotes": ("2026-01-15", '"2026-01-15"', "RF110", "cells.K1.calibrated", "expected a date", "without quotes"),
    "too many bits": ("bits = 10", "bits = 64", "RF110", "adc.bits", "a whole number from 1 to 32, got 64", ""),
    "empty converter range": ('high = "5 V"', 'high = "0 V"', "RF111", "adc.high", "empty", ""),
    "unknown protocol": ('name = "breakaway"', 'name = "break-away"', "RF120", "protocol.name", "break-away", "did you mean 'breakaway'?"),
    "tare the wrong way": ('["0 s", "300 ms"]', '["1 s", "300 ms"]', "RF111", "tare.interval", "empty", ""),
    "tare of one time": ('["0 s", "300 ms"]', '["0 s"]', "RF110", "tare.interval", "two times", "0.3 s"),
    "unknown window": ('"10 ms"', '"atuo"', "RF120", "smoothing.window", "atuo", '"auto"'),
    "peak of before": ('"10 ms"', '"10 ms"\npeak = "two-line"', "RF120", "smoothing.peak", "two-line", "known: smoothed"),
    "unknown rule": ('"grubbs"', '"grubs"', "RF120", "rejection.rule", "grubs", "did you mean 'grubbs'?"),
    "design without tension": ('end_tension = "60 N"', "", "RF121", "design.end_tension", "missing in the table [design]", "add end_tension"),
    "long separator": ('separator = ","', 'separator = ", "', "RF110", "import.separator", "one character", '"tab"'),
    "decimal is separator": ('decimal = "."', 'decimal = ","', "RF111", "import.decimal", "the same", ""),
    "unknown encoding": ('"utf-8-sig"', '"utf-9"', "RF110", "import.encoding", "utf-9", "cp1252"),
    "column zero": ("column = 3", "column = 0", "RF110", "import.channels.pressure", "number from 1", ""),
    "no force": ('counts = "counts"', "", "RF121", "import.channels", "no channel gives the force", "force ="),
    "constant of no dimension": ('"490.9 mm^2"', '"490.9 mol"', "RF130", "import.constants.area", "no SI unit is known for 'mol'", "in SI"),
    "constant and channel": ("[import.constants]", "[import.constants]\npressure = 1", "RF109", "import.constants", "a constant and a channel", "rename"),
    "formula": ('"pressure * area"', '"pressure *"', "RF109", "import.derived.load", "not a formula", "arithmetic"),
    "formula with unknown channel": ('"pressure * area"', '"presure * area"', "RF109", "import.derived.load", "'presure'", "did you mean 'pressure'?"),
    "formula that is code": ('"pressure * area"', '"__import__(1)"', "RF109", "import.derived.load", "more than arithmetic", ""),
    "empty part": ('until = "6 s"', 'until = "-1 s"', "RF111", "protocol.until", "from 0 s until -1 s is empty", ""),
    "yes for a number": ('"490.9 mm^2"', "true", "RF110", "import.constants.area", "got true", ""),
    "key of before": ('data   = "recordings"', 'report.language = "de"\ndata   = "recordings"', "RF120", "report.language", "there is no 'language' in [report] any more", "leave it out"),
    "two rates": ('decimal = "."', 'decimal = "."\nsampling_rate = "2 kHz"', "RF111", "import.sampling_rate", "2000 Hz, but [sampling] rate is 3000 Hz", "remove one"),
    "data folder": ('"recordings"', '"recordngs"', "RF106", "data", "recordngs", "relative to the campaign file"),
    "trials file": ('"trials.csv"', '"trails.csv"', "RF101", "", "there is no such file", "check the path"),
}  # fmt: skip


def test_every_mistake_is_told_with_its_place_and_remedy(bench):
    good = bench.path.read_bytes()
    for name, (old, new, code, key, message, fix) in MISTAKES.items():
        bench.write(toml=good)
        bench.spoil(old, new)
        put = new if key != "weights" else 'weights = "0.05 %"'
        if key == "weights":
            bench.spoil('data   = "recordings"', f'{put}\ndata   = "recordings"')
        problem = bench.only()
        assert (problem.code, problem.key) == (code, key), name
        assert message in problem.message, name
        assert fix in problem.fix, name
        assert not any(word in str(problem) for word in ("pydantic", "Input should")), name
        assert problem.path.rsplit("/", 1)[1] == ("trails.csv" if key == "" else "campaign.toml"), name
        if key and put:
            text = bench.path.read_text(encoding="utf-8")
            first = text.count("\n", 0, text.index(put)) + 1
            # A key that was added stands in the last line of what was put in.
            assert problem.line in {first, first + put.count("\n")}, name
        assert code != "RF121" or problem.line is not None, name


def test_required_keys_and_tables(bench):
    good = bench.path.read_bytes()
    for key in ("schema", "name", "trials", "rope"):
        bench.write(toml=good)
        bench.spoil(r"^\[rope\]\n(.+\n){3}" if key == "rope" else rf"^{key} .*\n", "", pattern=True)
        problem = bench.only()
        assert (problem.code, problem.key, problem.message) == ("RF121", key,
            f"'{key}' is missing in the file")  # fmt: skip
    bench.write(toml=good)
    bench.spoil('full_scale = "1 kN"\n', "")
    assert bench.only().line == bench.path.read_text().splitlines().index("[cells.K1]") + 1
    for table in (r"cells.K1", r"adc"):  # recordings in counts need both
        bench.write(toml=good)
        bench.spoil(rf"^\[{table}\]\n(.+\n)+", "", pattern=True)
        problem = bench.errors()[0]
        line = bench.path.read_text().splitlines().index('counts = "counts"') + 1
        assert (problem.code, problem.line, problem.key) == ("RF121", line, "import.channels.counts")


SYNTAX = {"no quotes": ('"9.8 mm"', "9.8 mm", "something follows the value", 'write diameter = "9.8 mm"'),
    "no quotes and comma": ('"9.8 mm"', "9,8 mm", "something follows the value",
    'write diameter = "9.8 mm"'), "word": ('"9.8 mm"', "unknown", "the value is not TOML", "in quotes"),
    "no equals sign": ('diameter = "9.8 mm"', "diameter", "no '='", "key ="),
    "key twice": ('diameter = "9.8 mm"', 'diameter = "9.8 mm"\ndiameter = "9 mm"', "given a second time",
    "remove one"), "table twice": ("[adc]", "[rope]", "given a second time", "one heading"),
    "table with a blank": ("[adc]", "[wheels.my wheel]", "is not closed", 'in quotes: [wheels."my wheel"]'),
    "open quote": ('"9.8 mm"', '"9.8 mm', "a quote is not closed", "close the quote"),
    "backslash": ('"recordings"', '"C:\\lab"', "backslash", "/")}  # fmt: skip


def test_no_toml(bench):
    good = bench.path.read_bytes()
    for name, (old, new, message, fix) in SYNTAX.items():
        bench.write(toml=good)
        bench.spoil(old, new)
        problem, text = bench.only(), bench.path.read_text(encoding="utf-8")
        at = text.rindex(new) if old == "[adc]" else text.index(new)
        line = text.count("\n", 0, at) + 1 + new.count("\n")
        assert (problem.code, problem.line) == ("RF101", line), name
        assert message in problem.message, name
        assert fix in problem.fix, name


ODD = [
    (b'a = 1\nname = "\xff"\n', 2, "UTF-8"), (b"a = " + b"[" * 5000, None, ""), (b"", None, "missing"),
    (b"a = " + b"1" * 5000, None, "cannot be read"), (b"a = 1\nb = [1,\n", 2, ""),
    (b"a = 1979-99-99\n", 1, ""), (b"\0", 1, ""),
]  # fmt: skip


def test_odd_files_and_none(bench, tmp_path):
    for content, line, message in ODD:
        bench.write(toml=content)
        problem = bench.errors()[0]
        assert message in problem.message, content[:20]
        assert line is None or problem.line == line, content[:20]
    for name in ("nothing.toml", ".", "x\0y", "n" * 300):
        (problem,) = check_campaign(tmp_path / name)
        assert problem.code == "RF101"
        with pytest.raises(RopefricError):
            load_campaign(tmp_path / name)


@pytest.mark.skipif(not Path("/proc/self/mem").is_file(), reason="needs /proc")
def test_a_device_that_says_it_is_a_file_is_refused_in_words(bench):
    bench.spoil('trials = "trials.csv"', 'trials = "/proc/self/mem"')
    problem = bench.only()
    assert problem.path.endswith("/proc/self/mem")
    assert "cannot be read: input/output error" in problem.message.lower()


def test_all_mistakes_in_one_pass(bench):
    bench.spoil('"9.8 mm"', "9.8")
    bench.spoil("bits = 10", "bits = 99")
    bench.spoil("grubbs", "grubs")
    bench.spoil("[design]", "[desing]")
    bench.spoil('"490.9 mm^2"', '"490.9 mn^2"')
    bench.spoil('"pressure * area"', '"presure * area"')
    bench.spoil_table("t2,b.csv,W60", "t1,b.csv,W6O")
    bench.spoil_table("540,60.5", "-540,")
    bench.spoil_table("a.csv", "missing.csv")
    assert bench.places() == [("campaign.toml", "RF130", "rope.diameter"), ("campaign.toml", "RF110", "adc.bits"),
        ("campaign.toml", "RF120", "rejection.rule"), ("campaign.toml", "RF120", "desing"),
        ("campaign.toml", "RF130", "import.constants.area"),
        ("campaign.toml", "RF109", "import.derived.load"), ("trials.csv", "RF124", "file"),
        ("trials.csv", "RF122", "trial"), ("trials.csv", "RF120", "wheel"),
        ("trials.csv", "RF110", "wrap_angle_deg"), ("trials.csv", "RF121", "end_tension_N")]  # fmt: skip
    assert bench.problems() == bench.problems()
    with pytest.raises(RopefricError) as caught:
        load_campaign(bench.path)
    assert caught.value.problems == tuple(bench.errors())


def test_doubts(bench):
    good = bench.path.read_bytes()
    tight = ('name = "breakaway"', 'name = "breakaway"\nside = "tight"', "RF141", "protocol.side")
    for old, new, code, key in (('"40 mm"', '"40 m"', "RF140", "wheels.W40"), tight):
        bench.write(toml=good)
        bench.spoil(old, new)
        (doubt,) = [p for p in bench.warnings() if p.path.endswith("campaign.toml")]
        assert ((doubt.code, doubt.key), bench.errors()) == ((code, key), [])
        assert load_campaign(bench.path).warnings == bench.problems()


def test_a_list_is_asked_for_nothing_that_a_wrong_campaign_file_leaves_open(bench):
    bench.spoil('radius = "40 mm"', "radius = 40")
    bench.spoil('"1 kN"', "1")
    bench.spoil('"breakaway"', '"brakeaway"')
    bench.spoil_table("80,", ",")
    bench.spoil_table("wrap_angle_deg", "wrap_angle")
    bench.spoil_table("c.csv", "lost.csv")
    assert bench.places() == [("campaign.toml", "RF130", "wheels.W40.radius"), ("campaign.toml", "RF130", "cells.K1.full_scale"),
        ("campaign.toml", "RF120", "protocol.name"), ("trials.csv", "RF130", "wrap_angle"),
        ("trials.csv", "RF124", "file")]  # fmt: skip
