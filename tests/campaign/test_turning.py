"""Rates of turning: they have the dimension of a frequency, and are the velocity of an angle."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import Oscillator, Platform, read_campaign
from ident.errors import UserError
from tests.campaign.strangers import DRIVE, RESPONSE, TIME, rows


@pytest.mark.parametrize(
    ("header", "factor"), [("n_rpm", np.pi / 30), ("omega (rad/s)", 1.0), ("rate [deg/s]", np.pi / 180)]
)
def test_a_rate_of_turning_is_the_velocity_of_an_angle(header, factor, tmp_path):
    """It has the dimension of a frequency, and a platform was asked for its micrometres."""
    (tmp_path / "a.csv").write_text(f"t_s,i_A,{header}\n" + rows(TIME, DRIVE, RESPONSE))
    campaign = read_campaign(tmp_path / "a.csv")
    assert isinstance(campaign.device, Oscillator) and (campaign.device.output, campaign.device.input) == ("rad", "A")
    (record,) = campaign.traces
    assert record.measures == "velocity"
    np.testing.assert_allclose(record.response, factor * RESPONSE, atol=2e-5)


def test_a_sweep_in_rad_per_s_or_rpm_is_in_hertz(tmp_path):
    """The frequencies of a platform in rad/s had been those of another device."""
    hertz, amplitude = np.linspace(400.0, 600.0, 41), 1e-6 / (1 + ((np.linspace(400.0, 600.0, 41) - 500) / 10) ** 2)
    for unit, per in (("rad/s", 2 * np.pi), ("rpm", 60.0), ("Hz", 1.0)):
        lines = [f"{per * f:.9g},3,{1e6 * a:.9g}" for f, a in zip(hertz, amplitude, strict=True)]
        (tmp_path / "a.csv").write_text("\n".join([f"omega ({unit}),drive (V),amplitude (um)", *lines]) + "\n")
        campaign = read_campaign(tmp_path / "a.csv")
        assert isinstance(campaign.device, Platform)
        np.testing.assert_allclose(campaign.sweeps[0].frequency, hertz, rtol=1e-7)


def test_a_rate_of_turning_of_an_angle_is_told_what_to_write(tmp_path):
    (tmp_path / "a.csv").write_text("t_s,i_A,speed_rpm\n" + rows(TIME, DRIVE, RESPONSE))
    (tmp_path / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "rad", input = "A" }\n\n[[record]]\nfile = "a.csv"\n'
    )
    with pytest.raises(UserError, match='write measures = "velocity"'):
        read_campaign(tmp_path)
