"""Units at the edge: what people write comes out in SI, or is refused with the right words."""

import contextlib
import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ropefric import quantities
from ropefric.errors import InputError
from ropefric.quantities import (
    SUFFIX_UNITS,
    parse_any_quantity,
    parse_fraction,
    parse_quantity,
    si_unit_of,
    split_unit_suffix,
    unit_factor,
)


def near(value):
    return pytest.approx(value, rel=1e-13)


def test_what_people_write():
    for text, si_unit, value in (
        ("40 mm", "m", 0.04), ("9.8mm", "m", 0.0098), ("540 deg", "rad", 3 * math.pi), ("0.5 in", "m", 0.0127),
        ("1.5 turn", "rad", 3 * math.pi), ("62 g/m", "kg/m", 0.062), ("0.3 %", "", 0.003), ("0.25", "", 0.25),
        ("5 kN", "N", 5000.0), ("120 kgf", "N", 1176.798), ("3 kHz", "Hz", 3000.0), ("30 ms", "s", 0.03),
        ("490.9 mm^2", "m^2", 490.9e-6), ("3 bar", "Pa", 3e5), ("-2 mV", "V", -0.002), ("1e3 N", "N", 1000.0),
    ):  # fmt: skip
        assert parse_quantity(text, si_unit) == pytest.approx(value, rel=1e-15), text
    for text, value in (("490.9 mm^2", 490.9e-6), ("3 bar", 3e5), ("1 lbf", 4.4482216152605),
            ("2 kN/mm", 2e6), ("5 min", 300.0), ("0.5", 0.5), ("-1.5e-3 V", -1.5e-3),
            ("9.80665 m/s^2", 9.80665), ("180 deg", math.pi), ("12 %", 0.12), ("2 1/min", 1 / 30),
            ("1 N*mm", 1e-3), ("1.5 kNm", 1500.0), ("3 Ncm", 0.03), ("3 µm", 3e-6)):  # fmt: skip
        assert parse_any_quantity(text) == near(value), text
    for text, value in (("0.02 %FS", 2e-4), ("0.02 % FS", 2e-4), ("0.02%", 2e-4), ("1 % of full scale", 0.01),
            ("0 %F.S.", 0.0)):  # fmt: skip
        assert parse_fraction(text) == value, text
    # Decimal numbers stay what was written.
    assert (parse_quantity("9.8 mm", "m"), parse_quantity("0.1 mm", "m")) == (0.0098, 0.0001)
    # Zero has no lower limit.
    assert parse_quantity("0 mm", "m") == parse_quantity("0e-400 mm", "m") == 0.0


def test_what_is_refused_and_how():
    for text, si_unit, words in ((40, "m",
            'radius: 40 has no unit Fix: write it with one, for example "40 mm"'),
            ("5 kn", "N", "'kn' is a knot, not a force. Fix: write 'kN'"), ("5 hz", "Hz", "write 'Hz'"),
            ("540 Grad", "rad", "'Grad' is not clear as [rad]. Fix: write 'deg' or 'gon'"),
            ("540 grad", "rad", "write 'deg' or 'gon'"), ("40 N", "m", "'N' is not a unit of length"),
            ("40,5 mm", "m", "has a decimal comma"), ("20 mm, 40 mm", "m", "more than one quantity"),
            ("2 m .. 4 m", "m", "or a list of such texts"), ("40 foos", "m", "unknown unit 'foos'"),
            ("mm", "m", "cannot read 'mm' as a number with a unit"), ("", "m", "cannot read ''"),
            (True, "m", "True is not a quantity"), (None, "m", "None is not a quantity"),
            ("1e999 m", "m", "not a finite number"), ("1 9**9**9**9", "m", "is not a unit"),
            ("1 m^9^9^9^9", "m", "is not a unit"), ("1e300 mm", "m", "too large: 1e+30 m is the limit"),
            ("1e300 Hz", "Hz", "too large: 1e+30 Hz is the limit"), ("-1e31 N", "N", "too large"),
            ("5e-324", "", "too small: 1e-30 is the limit"), ("1e-28 mm", "m", "too small"),
            ("5e-324 mm", "m", "too small")):  # fmt: skip
        with pytest.raises(InputError, match=re.escape(words)) as caught:
            parse_quantity(text, si_unit, name="radius")
        assert caught.value.code == ("RF110" if words.startswith("too ") else "RF130")
    units = ("20 degC", "1 mol", "1 kn", "1 n", "x", "", "1 2", "1 m m m (", "1,5 mm", "nan", "1e999")
    fractions = ("0.02", "0.02 FS", "%", "x %", "0.02 %XY")
    for read, texts in ((parse_any_quantity, units), (parse_fraction, fractions)):
        for text in texts:
            with pytest.raises(InputError) as caught:
                read(text)
            assert caught.value.code == "RF130", text


HOSTILE = ("9.8 Millimeterdurchmesserlautdatenblatt-2019", "10**10**10 mm",
    "1 aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa!", "1 m²²²²²²²²²²", "1 m^999", "1 percent^99 percent^99",
    "1 " + "m" * 20_000, "1" * 20_000 + " m", "1 " + "(" * 20_000, " " * 20_000 + "x",
    "1" + " " * 20_000 + "m", "1e" + "9" * 20_000 + " m", "1" + " m" * 20_000, 10**5000,
    "1e-99999999999999999999 m", "0e99999999999999999999 x")  # fmt: skip


def test_no_text_keeps_us_busy():
    for text in HOSTILE:
        for si_unit in ("m", ""):
            with pytest.raises(InputError) as caught:
                parse_quantity(text, si_unit)
            assert len(str(caught.value)) < 400
            with pytest.raises(InputError) as caught:
                unit_factor(f"{text}!" if isinstance(text, str) else "x", si_unit)
            assert len(str(caught.value)) < 400
    for letter in "_([ )].":  # long headers are taken apart at once: 8 to 25 s each, once
        run = letter * 20_000
        for header in (run, f"F{run}", f"{run}F", f"F ({run}N)"):
            stem, unit = split_unit_suffix(header)
            assert len(stem) + len(unit) <= len(header)


TEXTS = st.text("mNkgsVPabrdeµ%^*/ ()-+0123456789._~'\"", max_size=12) | st.text(max_size=30)


@settings(max_examples=30)
@given(number=st.sampled_from(["1 ", "-2.5 ", "1e5 ", ".", "", "1e-99999999999999999999 "]), unit=TEXTS)
def test_any_text_is_read_or_refused(number, unit):
    reads = [lambda text, si=si: parse_quantity(text, si) for si in ("m", "N", "rad", "s", "")]
    for read in (*reads, parse_any_quantity, parse_fraction):
        try:
            value = read(f"{number}{unit}")
        except InputError:
            continue
        assert math.isfinite(value)
    with contextlib.suppress(InputError):
        assert isinstance(si_unit_of(unit), str)


def test_headers_give_up_their_units():
    for header, wanted in {"wrap_angle_deg": ("wrap_angle", "deg"), "Force (kN)": ("Force", "kN"),
            "Force [kN]": ("Force", "kN"), "Time.(s)": ("Time", "s"),
            "linear_density_g_m": ("linear_density", "g/m"), "speed_m_s": ("speed", "m/s"),
            "file": ("file", ""), "_mm": ("_mm", "")}.items():  # fmt: skip
        assert split_unit_suffix(header) == wanted


def test_units_and_factors_are_pints():
    si_units = ("N", "m", "rad", "s", "Hz", "V", "kg", "Pa", "m/s", "kg/m", "N/m", "N/s")
    for unit in set(SUFFIX_UNITS.values()) - {"degC"}:
        assert any(_converts(unit, si_unit) for si_unit in si_units), unit
    for si_unit, units in quantities._USUAL.items():
        for unit, factor in units.items():
            assert factor == quantities._factor_by_pint(unit, si_unit), unit


def _converts(unit, si_unit):
    try:
        return unit_factor(unit, si_unit) > 0
    except InputError:
        return False
