"""Sweeps of a velocity or an acceleration: a linear resonance read by another sensor is the same resonance."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.errors import UserError

FREQUENCY = np.linspace(40.0, 60.0, 81)
PART = FREQUENCY / 50.0
DISPLACEMENT = 3e-3 / (1 - PART**2 + 1j * PART / 40) / 40
NOISE = 1e-4  # of the largest reading


def _write(path, header: str, order: int, factor: float = 1.0, second: float | None = None):
    """A sweep at 2 N whose reading is a derivative of the displacement, with noise of that reading."""
    rate = (2j * np.pi * FREQUENCY) ** order
    clean = DISPLACEMENT * rate
    noise = NOISE * np.max(np.abs(clean)) * np.random.default_rng(3).standard_normal((2, len(clean)))
    read = clean + noise[0] + 1j * noise[1]
    names, columns = (
        ["f (Hz)", "drive (N)", header, "phase (deg)"],
        [FREQUENCY, np.full(81, 2.0), factor * np.abs(read)],
    )
    columns.append(np.degrees(np.angle(read)))
    if second is not None:
        names.append("2f (m/s^2)")
        columns.append(second * (2 * np.pi * 2 * FREQUENCY) ** order)
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=",".join(names), comments="", fmt="%.12g")


@pytest.mark.parametrize(
    ("header", "order", "factor", "output"),
    [
        ("amplitude (mm/s)", 1, 1e3, "m"),
        ("amplitude (m/s^2)", 2, 1.0, "m"),
        ("accelerance (m/s^2/N)", 2, 0.5, "m"),
        ("amplitude (rad/s)", 1, 1.0, "rad"),
        ("amplitude (rpm)", 1, 30 / np.pi, "rad"),
    ],
)
def test_it_is_the_same_resonance(header, order, factor, output, tmp_path):
    """It had been refused, with advice to change the device, which had been refused too."""
    _write(tmp_path / "a.csv", header, order, factor)
    campaign = read_campaign(tmp_path / "a.csv")
    (sweep,) = campaign.sweeps
    assert campaign.device.output == output  # type: ignore[union-attr]
    np.testing.assert_allclose(sweep.amplitude, np.abs(DISPLACEMENT), atol=10 * NOISE * np.max(sweep.amplitude))
    turned = np.angle(np.exp(1j * sweep.phase) / np.exp(1j * np.angle(DISPLACEMENT)))
    assert np.max(np.abs(turned)) < 0.02
    assert any("those of the displacement" in note for note in campaign.notes)


def test_its_noise_is_that_of_the_reading(tmp_path):
    """A reading whose noise is the same everywhere makes a displacement that is noisier at low frequencies."""
    device = 'device = { kind = "oscillator", output = "m", input = "N" }\n\n[defaults]\nmeasures = "acceleration"\n'
    _write(tmp_path / "a.csv", "amplitude (m/s^2)", 2, second=1e-5)
    (tmp_path / "campaign.toml").write_text(device + 'noise = "2 m/s^2"\n\n[[record]]\nfile = "a.csv"\n')
    (sweep,) = read_campaign(tmp_path).sweeps
    np.testing.assert_allclose(sweep.deviation, 2.0 / (2 * np.pi * FREQUENCY) ** 2, rtol=1e-9)
    np.testing.assert_allclose(sweep.overtones[0].amplitude, 1e-5, rtol=1e-6)


def test_what_to_write_is_said(tmp_path):
    device = 'device = { kind = "oscillator", output = "m", input = "N" }\n\n[[record]]\nfile = "a.csv"\n'
    _write(tmp_path / "a.csv", "accelerance (m/s^2/N)", 2, 0.5)
    (tmp_path / "campaign.toml").write_text(device)
    with pytest.raises(UserError, match='write measures = "acceleration"'):
        read_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_text(device + 'measures = "acceleration"\n')
    np.testing.assert_allclose(
        read_campaign(tmp_path).sweeps[0].amplitude[40], np.abs(DISPLACEMENT[40]), rtol=10 * NOISE
    )


def test_half_a_peak_to_peak_value_of_a_rate_is_none_of_the_displacement(tmp_path):
    _write(tmp_path / "a.csv", "amplitude (mm/s)", 1, 1e3)
    with pytest.raises(UserError, match="does not tell that of the displacement"):
        read_campaign(tmp_path / "a.csv", quantity="half-peak-to-peak")


def test_an_output_in_g_is_an_acceleration(tmp_path):
    """Of the Earth: nobody reads grams."""
    _write(tmp_path / "a.csv", "amplitude (g)", 2, 1 / 9.80665)
    (tmp_path / "campaign.toml").write_text(
        'device = { kind = "oscillator", output = "g", input = "N" }\n\n[[record]]\nfile = "a.csv"\n'
    )
    campaign = read_campaign(tmp_path)
    assert campaign.device.output == "m"  # type: ignore[union-attr]
    np.testing.assert_allclose(campaign.sweeps[0].amplitude[40], np.abs(DISPLACEMENT[40]), rtol=10 * NOISE)


def test_a_platform_moves_no_metres(tmp_path):
    _write(tmp_path / "a.csv", "amplitude (m/s)", 1)
    (tmp_path / "campaign.toml").write_text('[[record]]\nfile = "a.csv"\nmeasures = "velocity"\n'
                                            'columns = { level = "drive" }\nunits = { level = "V" }\n')  # fmt: skip
    with pytest.raises(UserError, match="cannot be right for a platform"):
        read_campaign(tmp_path)
