"""Numbers as people read them."""

from __future__ import annotations

import pytest

from ident.campaign import Oscillator, Platform
from ident.report.words.quantity import display_unit, neat, show, significant
from ident.units import find_unit

PLATFORM, VOLTS = Platform(), Oscillator("V", "V")


@pytest.mark.parametrize(
    ("value", "error", "unit", "shown"),
    [
        (106.656e6, 0.2135e6, "Pa", "106.66 ± 0.21 MPa"),
        (9.2e3, 1e3, "Pa", "9.2 ± 1.0 kPa"),
        (6.399188e-11, 4.603e-15, "m/V", "63.9919 ± 0.0046 pm/V"),
        (2.19991e-23, 1.411e-26, "m^3/V^3", "(21.999 ± 0.014) 1e-24 m³/V³"),
        (498.5995, 0.00057, "Hz", "498.59950 ± 0.00057 Hz"),
        (31.0072, 0.0032, "1", "31.0072 ± 0.0032"),
        (1.2e10, 3.4e8, "N/m^3", "(12.00 ± 0.34) 1e9 N/m³"),
        (60e-6, 0.1e-6, "kg", "60.00 ± 0.10 mg"),
        (0.0, 0.013, "1", "0.000 ± 0.013"),
        (-1e-9, 4e-3, "1", "0.0000 ± 0.0040"),  # no minus zero
        (1.0, 0.0996, "1", "1.00 ± 0.10"),  # the rounding of the error decides
        (12346.0, 678.0, "1", "12350 ± 680"),
        (3e-6, None, "m", "3.000 µm"),
        (2.5e-3, 3e-5, "m/s^2", "2.500 ± 0.030 mm/s²"),
        (0.0, None, "Pa", "0 Pa"),
        (float("nan"), None, "Pa", "– Pa"),
    ],
)
def test_value_and_error_share_one_power_of_ten(value, error, unit, shown):
    assert str(show(value, error, unit, PLATFORM)) == shown


@pytest.mark.parametrize(
    ("unit", "platform", "volts", "plain"),
    [
        ("N/m^3", "N/m³", "1/(V²·s²)", "1/V^2/s^2"),
        ("N", "N", "V/s²", "V/s^2"),
        ("N/V", "N/V", "1/s²", "1/s^2"),
        ("N*s/m", "N·s/m", "1/s", "1/s"),
        ("N s^2/m^2", "N·s²/m²", "1/V", "1/V"),
        ("m^3/V^3", "m³/V³", "", "1"),
        ("Hz", "Hz", "Hz", "Hz"),
        ("1", "", "", "1"),
        ("s", "s", "s", "s"),
    ],
)
def test_an_oscillator_has_its_own_units(unit, platform, volts, plain):
    assert display_unit(unit, PLATFORM) == platform
    assert display_unit(unit, VOLTS) == volts
    assert display_unit(unit, VOLTS, plain=True) == plain
    assert find_unit(plain) is not None


def test_an_oscillator_in_a_unit_of_its_own_or_a_multiple():
    assert display_unit("N/m^3", Oscillator("counts_x", "V")) == "1/(counts_x²·s²)"
    assert display_unit("m/V", Oscillator("mV", "A")) == "V/A"  # numbers inside are in volts, not millivolts
    assert display_unit("m/s", Oscillator("m/s", "V")) == "m/s²"
    assert str(show(5.68e-3, None, "V", Oscillator("rad", "Nm"))) == "5.680 mNm"


def test_significant_digits():
    assert [significant(x) for x in (0.9788, 9.996, 139.2, 4066.0, 0.0, 1e-7)] == [
        "0.979", "10.0", "139", "4070", "0", "1.00e-07",
    ]  # fmt: skip
    assert neat(317.0) == "317"
    assert neat(100.0) == "100"
    assert neat(50.5) == "50.5"
