"""Rates of turning: they have the dimension of a frequency, and are the velocity of an angle."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import Oscillator, read_campaign
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


def test_a_rate_of_turning_of_an_angle_is_told_what_to_write(tmp_path):
    (tmp_path / "a.csv").write_text("t_s,i_A,speed_rpm\n" + rows(TIME, DRIVE, RESPONSE))
    (tmp_path / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "rad", input = "A" }\n\n[[record]]\nfile = "a.csv"\n'
    )
    with pytest.raises(UserError, match='write measures = "velocity"'):
        read_campaign(tmp_path)
