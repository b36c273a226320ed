"""Quantities as text: numbers against hand conversions, and an InputError for everything else."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ropefric.errors import InputError
from ropefric.quantities import parse_any_quantity, parse_fraction, parse_quantity, si_unit_of


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("490.9 mm^2", 490.9e-6), ("3 bar", 3e5), ("1 lbf", 4.4482216152605), ("2 kN/mm", 2e6), ("5 min", 300.0),
        ("0.5", 0.5), ("-1.5e-3 V", -1.5e-3), ("9.80665 m/s^2", 9.80665), ("180 deg", math.pi), ("12 %", 0.12),
        ("2 1/min", 1 / 30), ("1 N*mm", 1e-3), ("3 µm", 3e-6),
    ],
)  # fmt: skip
def test_any_unit_to_si(text, expected):
    assert parse_any_quantity(text) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    "text", ["20 degC", "1 mol", "1 kn", "1 n", "x", "", "1 2", "1 m m m (", "1,5 mm", "nan", "1e999"]
)
def test_refused_units(text):
    with pytest.raises(InputError) as caught:
        parse_any_quantity(text)
    assert caught.value.code == "RF130"


@pytest.mark.parametrize(
    ("text", "expected"),
    [("0.02 %FS", 2e-4), ("0.02 % FS", 2e-4), ("0.02%", 2e-4), ("1 % of full scale", 0.01), ("0 %F.S.", 0.0)],
)
def test_fractions(text, expected):
    assert parse_fraction(text) == expected


@pytest.mark.parametrize("text", ["0.02", "0.02 FS", "%", "x %", "0.02 %XY"])
def test_no_fractions(text):
    with pytest.raises(InputError):
        parse_fraction(text)


units = st.text("mNkgsVPabrdeµ%^*/ ()-+0123456789._~'\"", max_size=12) | st.text(max_size=6)


@given(number=st.sampled_from(["1", "-2.5", "1e5", ".", "", "1e-99999999999999999999"]), unit=units)
def test_any_text_is_read_or_refused(number, unit):
    for read in (lambda text: parse_quantity(text, "m"), parse_any_quantity, parse_fraction):
        try:
            value = read(f"{number} {unit}")
        except InputError:
            continue
        assert math.isfinite(value)


@given(units)
def test_any_unit_is_known_or_refused(unit):
    try:
        si_unit = si_unit_of(unit)
    except InputError:
        return
    assert isinstance(si_unit, str)
