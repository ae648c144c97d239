"""A campaign from TOML, from a folder, from CSVs: everything in it arrives in SI."""

from __future__ import annotations

import hashlib
import subprocess
import sys

import numpy as np
import pytest

from ident.campaign import Oscillator, Platform, read_campaign
from ident.campaign.quality.judge import judge
from ident.errors import UserError
from tests.broken import csv_text, signals

CAMPAIGN = """
title  = "device 12, 8 V"
device = "device.toml"
[model]
effects = ["residual-stress", "pzt-hysteresis"]
effect_files = ["my_effect.py"]
[effect.residual-stress]
closure = "axial-force"
sigma12 = "80 MPa"
restraint = 1.5
fixed = ["sigma23"]
[priors]
"residual-stress.sigma12" = { normal = [80, 20], unit = "MPa" }
creep.strength = { normal = [0.1, 0.05] }
[[record]]
file = "a.csv"
kind = "trace"
start = "steady"
load = "40 mg"
noise = "12 nm"
skip = "2 ms"
[[record]]
file = "b.csv"
holdout = true
skip = 7
columns = { time = "t", drive = "CH1", response = "CH2" }
units = { response = "um" }
[[record]]
file = "sweep.csv"
kind = "sweep"
direction = "down"
quantity = "half-peak-to-peak"
"""
DEVICE = """
kind = "platform"
width = "900 um"
silicon_modulus = "160 GPa"
stage_mass = 55e-6
beam_end = ["0 mm", "-1.5 mm"]
in_plane = "clamped"
"""
SWEEP = "frequency (kHz),drive (Vpp),amplitude (µm),phase (deg)\n" + "".join(
    f"{0.4 + 0.01 * k},6,{1 + 0.1 * k},{-9 * k}\n" for k in range(20)
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (tmp_path / "device.toml").write_text(DEVICE, encoding="utf-8")
    (tmp_path / "my_effect.py").write_text("", encoding="utf-8")
    (tmp_path / "a.csv").write_text(csv_text("time (ms),drive (mV),z (nm)", signals() * 1e3), encoding="utf-8")
    (tmp_path / "b.csv").write_text(csv_text("t;CH1;CH2", separator=";"), encoding="utf-8")
    (tmp_path / "sweep.csv").write_text(SWEEP, encoding="utf-8")
    return tmp_path


def test_everything_arrives_in_si(folder):
    campaign = read_campaign(folder)
    first, second = campaign.traces
    np.testing.assert_allclose(first.time, signals()[:, 0], atol=1e-9)
    np.testing.assert_allclose(first.drive, signals()[:, 1], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(first.response, signals()[:, 2] * 1e-6, rtol=1e-5)
    assert (first.start, first.load, first.skip) == ("steady", pytest.approx(40e-6), 40)
    assert first.noise.sigma == pytest.approx(12e-9) and first.noise.relative_error == 0 and not first.noise.ar
    assert (first.response_channel.unit, first.response_channel.factor) == ("nm", 1e-9)
    assert first.period == 40 and first.step == pytest.approx(5e-5)
    assert (second.start, second.holdout, second.skip) == ("unknown", True, 7)
    assert second.noise.sigma == pytest.approx(10e-9, rel=0.15) and second.noise.relative_error > 0
    assert campaign.fitted == (first,) and campaign.heldout == (second,)


def test_a_sweep(folder):
    (sweep,) = read_campaign(folder).sweeps
    np.testing.assert_allclose(sweep.frequency, 400 + 10 * np.arange(20))
    np.testing.assert_allclose(sweep.level, 3.0)
    np.testing.assert_allclose(sweep.amplitude, 1e-6 * (1 + 0.1 * np.arange(20)))
    np.testing.assert_allclose(sweep.phase, -np.pi / 20 * np.arange(20))
    assert not sweep.up.any() and sweep.quantity == "half-peak-to-peak" and sweep.noise.sigma > 0


def test_the_rest_of_the_campaign(folder):
    campaign = read_campaign(folder / "campaign.toml")
    assert campaign.title == "device 12, 8 V" and campaign.path == folder / "campaign.toml"
    assert campaign.effects == ("residual-stress", "pzt-hysteresis")
    assert campaign.effect_files == (folder / "my_effect.py",)
    settings = campaign.settings["residual-stress"]
    assert settings["closure"] == "axial-force" and settings["fixed"] == ("sigma23",)
    assert settings["sigma12"] == pytest.approx(80e6) and settings["restraint"] == 1.5
    prior = campaign.priors["residual-stress.sigma12"]
    assert (prior.mean, prior.deviation) == (pytest.approx(80e6), pytest.approx(20e6))
    assert campaign.priors["creep.strength"].mean == pytest.approx(0.1)
    device = campaign.device
    assert isinstance(device, Platform)
    assert (device.width, device.stage_mass) == (pytest.approx(9e-4), 55e-6)
    assert device.beam_end == (0.0, pytest.approx(-1.5e-3)) and device.in_plane == "clamped"
    assert set(campaign.checksums) == {"campaign.toml", "device.toml", "my_effect.py", "a.csv", "b.csv", "sweep.csv"}
    assert campaign.checksums["a.csv"] == hashlib.sha256((folder / "a.csv").read_bytes()).hexdigest()
    assert any("b.csv" in note and "V is assumed" in note for note in campaign.notes)


def test_a_csv_alone(folder):
    campaign = read_campaign(folder / "a.csv")
    assert isinstance(campaign.device, Platform) and campaign.traces[0].start == "unknown"
    assert any("nominal platform" in note for note in campaign.notes)
    assert any("initial state is fitted" in note for note in campaign.notes)


def test_volts_alone_are_an_oscillator(tmp_path):
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(csv_text("t_s,u_V,y_mV"), encoding="utf-8")
    campaign = read_campaign([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert campaign.device == Oscillator("V", "V") and len(campaign.traces) == 2
    np.testing.assert_allclose(campaign.traces[0].response, signals()[:, 2] * 1e-3, rtol=1e-5)
    assert any("oscillator" in note for note in campaign.notes)


def _oscillator(tmp_path, header, device, record=""):
    (tmp_path / "a.csv").write_text(csv_text(header), encoding="utf-8")
    text = f'device = {device}\n[[record]]\nfile = "a.csv"\n{record}\n'
    (tmp_path / "c.toml").write_text(text, encoding="utf-8")
    return read_campaign(tmp_path / "c.toml")


def test_an_oscillator_keeps_base_units(tmp_path):
    campaign = _oscillator(tmp_path, "t_s,u_V,y_mV", '{ kind = "oscillator", output = "mV" }', 'noise = "5 mV"')
    assert campaign.device == Oscillator("V", "V")
    assert campaign.traces[0].response_channel.factor == 1e-3
    assert campaign.traces[0].noise.sigma == pytest.approx(5e-3)


def test_an_oscillator_in_a_unit_of_its_own(tmp_path):
    device = '{ kind = "oscillator", output = "counts", input = "A" }'
    campaign = _oscillator(tmp_path, "t (s),i drive (mA),y (counts)", device, 'noise = "2 counts"')
    trace = campaign.traces[0]
    assert trace.response_channel.unit == "counts" and trace.response_channel.factor == 1.0
    assert trace.drive_channel.factor == 1e-3 and trace.noise.sigma == 2.0


@pytest.mark.parametrize(
    ("header", "output", "source", "factors"),
    [
        ("t (s),u (mV),y (um)", "m", "V", (1e-3, 1e-6)),
        ("t (s),force (N),speed (mm/s)", "m", "N", (1.0, 1e-3)),
        ("t (s),u,y", "V", "V", (1.0, 1.0)),
    ],
)
def test_an_oscillator_takes_the_units_that_its_device_leaves_open_from_its_columns(
    tmp_path, header, output, source, factors
):
    campaign = _oscillator(tmp_path, header, '{ kind = "oscillator" }')
    assert (campaign.device.output, campaign.device.input) == (output, source)
    trace = campaign.traces[0]
    assert (trace.drive_channel.factor, trace.response_channel.factor) == factors
    assert any("taken from its columns" in note for note in campaign.notes) == (header != "t (s),u,y")


def test_a_rate_stands_in_for_time(tmp_path):
    text = csv_text("u_V,y_V", signals()[:, 1:])
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    campaign = '[[record]]\nfile = "a.csv"\nrate = "20 kHz"\n'
    (tmp_path / "c.toml").write_text('device = { kind = "oscillator" }\n' + campaign, encoding="utf-8")
    assert read_campaign(tmp_path / "c.toml").traces[0].step == pytest.approx(5e-5)


def test_directions_come_from_a_column_or_from_the_order(tmp_path):
    rows = [(f, 3, 1.0, d) for d, steps in (("up", range(20)), ("down", range(20, 0, -1))) for f in steps]
    text = "f (Hz),u (V),amplitude (um),dir\n" + "".join(f"{400 + f},{u},{a},{d}\n" for f, u, a, d in rows)
    (tmp_path / "s.csv").write_text(text, encoding="utf-8")
    given = read_campaign(tmp_path / "s.csv").sweeps[0].up
    assert given.sum() == 20
    (tmp_path / "s.csv").write_text(text.replace(",dir", ",note"), encoding="utf-8")
    campaign = read_campaign(tmp_path / "s.csv")
    np.testing.assert_array_equal(campaign.sweeps[0].up, given)
    assert any("both directions" in note for note in campaign.notes)


def test_a_judgement(folder):
    first = judge(read_campaign(folder).traces[0])
    assert first.frequency == pytest.approx(500, rel=1e-6) and first.amplitude == pytest.approx(8, rel=1e-3)
    assert first.distortion is not None and first.distortion < 1e-3
    assert first.samples_per_period == pytest.approx(40) and first.periods == pytest.approx(10)
    assert first.start_fits is True and first.clipped == 0 and not first.remarks


def test_a_judgement_of_a_false_start(folder):
    text = CAMPAIGN.replace('start = "steady"', 'start = "rest"')
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    verdict = judge(read_campaign(folder).traces[0])
    assert verdict.start_fits is False and "rest" in verdict.remarks[0]


def test_reading_needs_no_heavy_library(folder):
    code = (
        "import sys; from ident.campaign import read_campaign; read_campaign(sys.argv[1]);"
        "print([m for m in ('pandas', 'pint', 'jax', 'h5py', 'pyarrow', 'nptdms', 'matplotlib') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(folder)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_campaigns_and_data_do_not_mix(folder):
    with pytest.raises(UserError, match="cannot be mixed"):
        read_campaign([folder / "a.csv", folder / "campaign.toml"])
    with pytest.raises(UserError):
        read_campaign([])


@pytest.mark.parametrize("response", ["z (um)", "z (V)", "gain (dB)"])
def test_empty_columns_are_too_few_samples(response):
    empty = {name: np.zeros(0) for name in ("time (s)", "drive (V)", response)}
    with pytest.raises(UserError, match="too few|no column|instantaneous"):
        read_campaign(empty)
