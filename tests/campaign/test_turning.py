"""Rates of turning: they have the dimension of a frequency, and are the velocity of an angle."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import Oscillator, Platform, read_campaign
from ident.errors import UserError
from ident.units import find_unit, hertz_of, kept_unit, parse_frequency
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


@pytest.mark.parametrize(
    ("unit", "hertz"),
    [("rpm", 1 / 60), ("RPM", 1 / 60), ("krpm", 1e3 / 60), ("rps", 1.0), ("dps", 1 / 360), ("cycles/s", 1.0),
     ("turn/s", 1.0), ("revolution/min", 1 / 60), ("rad/s", 0.5 / np.pi), ("1/s*rad", 0.5 / np.pi), ("Hz", 1.0),
     ("1/min", 1 / 60)],
)  # fmt: skip
def test_turns_are_counted_wherever_a_frequency_is_asked(unit, hertz):
    """A unit of turns is one by its radian, however it is written: that decides whether 2π is in it."""
    assert hertz_of(unit) == pytest.approx(hertz, rel=1e-12)
    assert parse_frequency(f"30 {unit}") == pytest.approx(30 * hertz, rel=1e-12)
    assert kept_unit(unit) == ("Hz" if unit in ("Hz", "1/min") else "rad/s")


def test_a_word_that_is_a_unit_in_brackets_only():
    """A column of the way back is none of revolutions."""
    assert find_unit("rev", rare=False) is None and find_unit("cycle", rare=False) is None
    assert find_unit("rev").factor == find_unit("rev/s", rare=False).factor == pytest.approx(2 * np.pi)  # type: ignore[union-attr]


def test_a_drive_file_of_another_recorder(tmp_path):
    """Two recorders call all their columns alike; what the campaign says of the drive's is told by its own name."""
    (tmp_path / "z.csv").write_text("time_s,CH1\n" + rows(TIME, RESPONSE))
    (tmp_path / "u.csv").write_text("time_s,CH1,CH2\n" + rows(TIME, 1e3 * DRIVE, 0 * DRIVE))
    said = 'file = "z.csv"\ndrive_file = "u.csv"\ncolumns = { drive = "CH1", response = "CH1" }\n'
    campaign = tmp_path / "campaign.toml"
    campaign.write_text(f'device = {{ kind = "oscillator", output = "m" }}\n\n[[record]]\n{said}units.drive = "mA"\n')
    read = read_campaign(tmp_path)
    assert read.device.input == "A"  # type: ignore[union-attr]
    np.testing.assert_allclose(read.traces[0].drive, DRIVE, atol=2e-5)
    (tmp_path / "u.csv").write_text("time_s,i (mA),spare (mA)\n" + rows(TIME, 1e3 * DRIVE, 0 * DRIVE))
    campaign.write_text(
        'device = { kind = "oscillator", output = "m" }\n\n[[record]]\nfile = "z.csv"\ndrive_file = "u.csv"\n'
        'columns = { drive = "i" }\nunits = { i = "A", CH1 = "mm" }\n'
    )
    read = read_campaign(tmp_path)
    assert read.device.input == "A"  # type: ignore[union-attr]
    np.testing.assert_allclose(read.traces[0].drive, 1e3 * DRIVE, atol=2e-5)
    np.testing.assert_allclose(read.traces[0].response, 1e-3 * RESPONSE, atol=2e-8)
    (tmp_path / "u.csv").write_text("time_s,CH1 (mA)\n" + rows(TIME, 1e3 * DRIVE))
    campaign.write_text(
        'device = { kind = "oscillator", output = "m", input = "A" }\n\n[[record]]\nfile = "z.csv"\n'
        'drive_file = "u.csv"\ncolumns = { drive = "CH1", response = "CH1" }\nunits = { CH1 = "mm" }\n'
    )
    read = read_campaign(tmp_path)  # the name is that of the response's column
    np.testing.assert_allclose(read.traces[0].drive, DRIVE, atol=2e-5)
    np.testing.assert_allclose(read.traces[0].response, 1e-3 * RESPONSE, atol=2e-8)


def test_a_noise_or_a_level_of_turning_is_one_of_the_column(tmp_path):
    """They had been taken for frequencies, 6.28 times too small, and the column had not."""
    (tmp_path / "a.csv").write_text("t_s,i_A,speed (rad/s)\n" + rows(TIME, DRIVE, RESPONSE))
    (tmp_path / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "rad", input = "A" }\n\n'
        '[[record]]\nfile = "a.csv"\nmeasures = "velocity"\nnoise = "0.01 rad/s"\n'
    )
    assert read_campaign(tmp_path).traces[0].noise.sigma == pytest.approx(0.01, rel=1e-12)
    (tmp_path / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "rad", input = "rad/s" }\n\n'
        '[[record]]\nfile = "b.csv"\nmeasures = "velocity"\ndrive = "sine 3 rad/s 600 rpm"\n'
    )
    (tmp_path / "b.csv").write_text("t_s,speed (rad/s)\n" + rows(TIME, RESPONSE))
    assert np.max(read_campaign(tmp_path).traces[0].drive) == pytest.approx(3.0, rel=0.1)
