"""Sensitivities of sensors and amplifiers, and the reference of a control loop."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Trace
from ident.errors import UserError

N = 400
T = np.arange(N) / 1000
DRIVE, READ = np.sin(2 * np.pi * 20 * T), 0.5 * np.sin(2 * np.pi * 20 * T - 0.3)


def record(folder: Path, more: str, output: str = "m", header: str = "t (s),drive (V),response (V)") -> Trace:
    columns = [T, DRIVE, READ, np.round(DRIVE)][: header.count(",") + 1]
    np.savetxt(folder / "a.csv", np.stack(columns, 1), "%.9g", ",", header=header, comments="")
    device = f'device = {{ kind = "oscillator", output = "{output}", input = "N" }}'
    (folder / "campaign.toml").write_text(f'{device}\n[[record]]\nfile = "a.csv"\n{more}\n')
    return read_campaign(folder).traces[0]


@pytest.mark.parametrize(
    ("response", "factor", "more"),
    [
        ("5 um/V", 5e-6, ""),
        ("0.2 V/um", 5e-6, ""),
        ("-20 nm/mV", -20e-6, ""),
        ("100 mV/g", 98.0665, 'measures = "acceleration"'),
        ("50 mV/(m/s)", 20.0, 'measures = "velocity"'),
    ],
)
def test_volts_become_what_the_sensor_says(tmp_path: Path, response: str, factor: float, more: str) -> None:
    found = record(tmp_path, f'scale = {{ response = "{response}", drive = "35 N/V" }}\n{more}')
    np.testing.assert_allclose(found.response, factor * READ, rtol=1e-7)
    np.testing.assert_allclose(found.drive, 35 * DRIVE, rtol=1e-7)
    assert found.response_channel.unit != "V"


@pytest.mark.parametrize(
    "response", ["5", "5 um", "um/V", "5 kg/V", "0 um/V", "5 um/bananas", "1.2.3 um/V", ". um/V", "1e999 um/V"]
)
def test_what_is_no_sensitivity_says_what_would_be(tmp_path: Path, response: str) -> None:
    with pytest.raises(UserError) as caught:
        record(tmp_path, f'scale = {{ response = "{response}", drive = "1 N/V" }}')
    assert "write for example" in caught.value.do and "campaign.toml, line" in caught.value.where


def test_the_reference_of_a_loop_is_neither_drive_nor_response(tmp_path: Path) -> None:
    header = "t (s),u (N),q (m),drive (N)"
    found = record(tmp_path, 'columns = { reference = "drive" }', header=header)
    np.testing.assert_allclose(found.drive, DRIVE, atol=1e-8)
    assert any("loop" in note for note in read_campaign(tmp_path).notes)


@pytest.mark.parametrize(("response", "unit"), [("5 um/V", "um"), ("100 mV/g", "g_n")])
def test_a_sensitivity_tells_the_units_that_a_device_leaves_open(tmp_path: Path, response: str, unit: str) -> None:
    rows = np.stack([T, DRIVE, READ], 1)
    np.savetxt(tmp_path / "a.csv", rows, "%.9g", ",", header="t (s),drive (A),response (V)", comments="")
    record = f'[[record]]\nfile = "a.csv"\nscale = {{ response = "{response}" }}'
    (tmp_path / "campaign.toml").write_text(f'device = {{ kind = "oscillator" }}\n{record}\n')
    campaign = read_campaign(tmp_path)
    assert isinstance(campaign.device, Oscillator)
    assert (campaign.device.input, campaign.traces[0].response_channel.unit) == ("A", unit)


@pytest.mark.parametrize(
    ("header", "factor"), [("response (V)", 1.0), ("response (mV)", 1e-3), ("response (V/s)", 1.0)]
)
def test_volts_of_a_velocity_need_no_other_unit(tmp_path: Path, header: str, factor: float) -> None:
    """A decoder's output is in V whatever it reads; only a unit of a rate says more."""
    found = record(tmp_path, 'measures = "velocity"\nscale = { drive = "1 N/V" }', "V", f"t (s),drive (V),{header}")
    np.testing.assert_allclose(found.response, factor * READ, rtol=1e-7)
    assert any("taken for V/s" in note for note in read_campaign(tmp_path).notes) == ("/s" not in header)


def test_a_decay_of_a_velocity_in_volts_needs_no_drive(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.csv", np.stack([T, READ], 1), "%.9g", ",", header="t (s),response (V)", comments="")
    device = 'device = { kind = "oscillator", output = "V", input = "V" }'
    (tmp_path / "campaign.toml").write_text(f'{device}\n[[record]]\nfile = "a.csv"\nmeasures = "velocity"\n')
    (found,) = read_campaign(tmp_path).traces
    assert not found.driven
    np.testing.assert_allclose(np.diff(found.response), np.diff(READ), atol=1e-9)  # whatever level it rests on
