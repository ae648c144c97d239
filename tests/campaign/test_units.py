"""Units come in as texts and go on as SI floats; the fast table agrees with pint."""

from __future__ import annotations

import pint
import pytest

from ident.errors import UserError
from ident.units import (
    LENGTH,
    MASS,
    TIME,
    VOLTAGE,
    base_unit,
    find_unit,
    format_quantity,
    kept_unit,
    parse_quantity,
    to_si,
)

_pint = pint.UnitRegistry()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12 nm", 12e-9),
        ("40mg", 40e-6),
        ("20 ms", 0.02),
        (" 1.5e3  um ", 1.5e-3),
        ("80 MPa", 80e6),
        ("-3 mV", -3e-3),
        ("2 kg/s^2", 2.0),
        ("2 N/m^3", 2.0),
        ("5 µm", 5e-6),
        ("5 μm", 5e-6),
        ("7", 7.0),
        ("50 %", 0.5),
        ("180 deg", 3.141592653589793),
        ("1 inch", 0.0254),
        ("2 N.m", 2.0),
        ("2 mN-m", 2e-3),
        ("3 kg.m^2", 3.0),
        ("3 rad.s-1", 3.0),
        ("9.8 m.s-2", 9.8),
    ],
)
def test_quantities(text, value):
    assert parse_quantity(text) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "name",
    ["s", "ms", "us", "nm", "mm", "um", "g", "mg", "V", "mV", "kV", "Hz", "kHz", "N", "mN", "Pa", "MPa", "GPa", "rad",
     "deg", "N/m", "N/m^3", "kg/m", "m/s^2", "1/s", "V/m", "m^2*kg", "C/N", "J", "W", "F", "K", "min", "mA", "N*s/m"],
)  # fmt: skip
def test_the_table_agrees_with_pint(name):
    found = find_unit(name, rare=False)
    assert found is not None
    expected = _pint.Quantity(1.0, name.replace("^", "**")).to_base_units()
    assert found.factor == pytest.approx(expected.magnitude, rel=1e-12)
    powers = {str(unit): power for unit, power in expected.unit_items()}
    names = ("meter", "kilogram", "second", "ampere", "kelvin", "mole", "candela")
    assert found.dimension == tuple(powers.get(one, 0) for one in names)


@pytest.mark.parametrize(
    "text", ["nm", "12 parsnips", "12 nm nm2x", "", "nan V", "1e999 V", "3 degC", "--3 V", "1,5 V"]
)
def test_nonsense_is_refused(text):
    with pytest.raises(UserError) as caught:
        parse_quantity(text, where="c.toml, line 3")
    assert caught.value.where == "c.toml, line 3" and caught.value.do


def test_a_wrong_dimension_is_refused():
    with pytest.raises(UserError, match="voltage.*mass"):
        parse_quantity("3 V", MASS)
    with pytest.raises(UserError, match="no unit"):
        parse_quantity("3", LENGTH)
    assert to_si(3, "ms", TIME) == pytest.approx(3e-3)


def test_rare_units_need_to_be_asked_for():
    assert find_unit("t", rare=False) is None
    assert find_unit("furlong") is not None
    assert find_unit("CH1") is None


def test_base_units():
    assert base_unit(LENGTH) == "m" and base_unit(VOLTAGE) == "V" and base_unit(MASS) == "kg"
    assert base_unit((-2, 1, -2, 0, 0, 0, 0)) == "kg/m^2/s^2"


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.2e-8, "m", "12 nm"),
        (9.99999e-7, "m", "1 µm"),
        (4e-5, "kg", "40 mg"),
        (8e7, "Pa", "80 MPa"),
        (3e10, "N/m^3", "3e+10 N/m^3"),
        (0.0021, "m/s^2", "2.1 mm/s^2"),
        (0.0, "m", "0 m"),
        (0.25, "1", "0.25"),
        (-0.002, "V", "-2 mV"),
        (505.4, "Hz", "505.4 Hz"),
    ],
)
def test_values_for_people(value, unit, text):
    assert format_quantity(value, unit) == text


def test_two_digits_of_hundreds_take_no_exponent():
    assert format_quantity(8.99e-10, "m", 2) == "900 pm"


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("deg", "rad"),
        ("degrees", "rad"),
        ("°", "rad"),
        ("mrad", "rad"),
        ("um", "m"),
        ("%", "1"),
        ("rad/s", "rad/s"),
        ("rpm", "rad/s"),
        ("deg/s^2", "rad/s^2"),
        ("kHz", "Hz"),
    ],
)
def test_the_unit_in_which_numbers_are_kept(name: str, kept: str) -> None:
    assert kept_unit(name) == kept


def test_a_word_that_is_no_unit_is_kept_in_none_and_a_farad_is_no_angle() -> None:
    assert kept_unit("counts") is None and kept_unit("farad") != "rad"
