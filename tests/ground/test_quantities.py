"""Units at the edge: what people write comes out in SI, or is refused with the right words."""

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric import quantities
from ropefric.errors import InputError
from ropefric.quantities import SUFFIX_UNITS, parse_quantity, split_unit_suffix, unit_factor


@pytest.mark.parametrize(
    ("text", "si_unit", "wanted"),
    [
        ("40 mm", "m", 0.04),
        ("9.8mm", "m", 0.0098),
        ("540 deg", "rad", 3 * math.pi),
        ("1.5 turn", "rad", 3 * math.pi),
        ("62 g/m", "kg/m", 0.062),
        ("0.3 %", "", 0.003),
        ("0.25", "", 0.25),
        ("5 kN", "N", 5000.0),
        ("120 kgf", "N", 1176.798),
        ("0.5 in", "m", 0.0127),
        ("3 kHz", "Hz", 3000.0),
        ("30 ms", "s", 0.03),
        ("490.9 mm^2", "m^2", 490.9e-6),
        ("3 bar", "Pa", 3e5),
        ("-2 mV", "V", -0.002),
        ("1e3 N", "N", 1000.0),
    ],
)
def test_what_people_write(text, si_unit, wanted):
    assert parse_quantity(text, si_unit) == pytest.approx(wanted, rel=1e-15)


def test_decimal_numbers_stay_what_was_written():
    assert parse_quantity("9.8 mm", "m") == 0.0098
    assert parse_quantity("0.1 mm", "m") == 0.0001


@pytest.mark.parametrize(
    ("text", "si_unit", "words"),
    [
        (40, "m", r'radius: 40 has no unit Fix: write it with one, for example "40 mm"'),
        ("5 kn", "N", "'kn' is a knot, not a force. Fix: write 'kN'"),
        ("5 hz", "Hz", "write 'Hz'"),
        ("540 Grad", "rad", "'Grad' is not clear as \\[rad\\]. Fix: write 'deg' or 'gon'"),
        ("540 grad", "rad", "write 'deg' or 'gon'"),
        ("40 N", "m", "'N' is not a unit of length"),
        ("40,5 mm", "m", "has a decimal comma"),
        ("40 foos", "m", "unknown unit 'foos'"),
        ("mm", "m", "cannot read 'mm' as a number with a unit"),
        ("", "m", "cannot read ''"),
        (True, "m", "True is not a quantity"),
        (None, "m", "None is not a quantity"),
        ("1e999 m", "m", "not a finite number"),
        ("1 9**9**9**9", "m", "is not a unit"),
        ("1 m^9^9^9^9", "m", "is not a unit"),
    ],
)
def test_what_is_refused_and_how(text, si_unit, words):
    with pytest.raises(
        InputError, match=words.replace("(", r"\(").replace("^", r"\^").replace("*", r"\*")
    ) as caught:
        parse_quantity(text, si_unit, name="radius")
    assert caught.value.code == "RF130"


HOSTILE = (
    "9.8 Millimeterdurchmesserlautdatenblatt-2019", "10**10**10 mm", "1 aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa!",
    "1 m²²²²²²²²²²", "1 m^999", "1 percent^99 percent^99", "1 " + "m" * 20_000, "1" * 20_000 + " m",
    "1 " + "(" * 20_000, " " * 20_000 + "x", "1" + " " * 20_000 + "m", "1e" + "9" * 20_000 + " m",
    "1" + " m" * 20_000,
    10**5000, "1e-99999999999999999999 m", "0e99999999999999999999 x",
)  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
@pytest.mark.parametrize("si_unit", ["m", ""])
def test_no_text_keeps_us_busy(text, si_unit):
    with pytest.raises(InputError) as caught:
        parse_quantity(text, si_unit)
    assert len(str(caught.value)) < 400
    with pytest.raises(InputError) as caught:
        unit_factor(f"{text}!" if isinstance(text, str) else "x", si_unit)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("letter", "_([ )].")
def test_long_headers_are_taken_apart_at_once(letter):
    # 8 to 25 s each, once.
    for header in (letter * 20_000, "F" + letter * 20_000, letter * 20_000 + "F", f"F ({letter * 20_000}N)"):
        stem, unit = split_unit_suffix(header)
        assert len(stem) + len(unit) <= len(header)


@pytest.mark.parametrize(
    ("text", "si_unit", "words"),
    [
        ("1e300 mm", "m", "too large: 1e+30 m is the limit"),
        ("1e300 Hz", "Hz", "too large: 1e+30 Hz is the limit"),
        ("-1e31 N", "N", "too large"),
        ("5e-324", "", "too small: 1e-30 is the limit"),
        ("1e-28 mm", "m", "too small"),
        ("5e-324 mm", "m", "too small"),
    ],
)
def test_what_no_machine_has_is_refused_with_the_limit(text, si_unit, words):
    with pytest.raises(InputError, match=words.replace("+", r"\+")):
        parse_quantity(text, si_unit)


def test_zero_has_no_lower_limit():
    assert parse_quantity("0 mm", "m") == parse_quantity("0e-400 mm", "m") == 0.0


@given(st.text(max_size=30), st.sampled_from(["m", "N", "rad", "s", ""]))
def test_any_text_is_a_number_or_refused(text, si_unit):
    with contextlib.suppress(InputError):
        assert math.isfinite(parse_quantity(text, si_unit))


@given(st.floats(1e-25, 1e6).map(lambda x: float(f"{x:.9g}")) | st.just(0.0))
def test_millimetres_are_thousandths(number):
    assert parse_quantity(f"{number!r} mm", "m") == pytest.approx(number / 1000, rel=1e-15, abs=1e-300)


@pytest.mark.parametrize(
    ("header", "wanted"),
    [
        ("wrap_angle_deg", ("wrap_angle", "deg")),
        ("Force (kN)", ("Force", "kN")),
        ("Force [kN]", ("Force", "kN")),
        ("Time.(s)", ("Time", "s")),
        ("linear_density_g_m", ("linear_density", "g/m")),
        ("speed_m_s", ("speed", "m/s")),
        ("file", ("file", "")),
        ("_mm", ("_mm", "")),
    ],
)
def test_headers_give_up_their_units(header, wanted):
    assert split_unit_suffix(header) == wanted


def test_every_suffix_is_a_unit_that_pint_knows():
    for unit in SUFFIX_UNITS.values():
        if unit == "degC":
            continue
        assert any(
            _converts(unit, si)
            for si in ("N", "m", "rad", "s", "Hz", "V", "kg", "Pa", "m/s", "kg/m", "N/m", "N/s")
        )


def _converts(unit, si_unit):
    try:
        return unit_factor(unit, si_unit) > 0
    except InputError:
        return False


@pytest.mark.parametrize(
    ("unit", "si_unit"), [(unit, si_unit) for si_unit, units in quantities._USUAL.items() for unit in units]
)
def test_the_usual_factors_are_pints_own(unit, si_unit):
    assert quantities._USUAL[si_unit][unit] == quantities._factor_by_pint(unit, si_unit)
