"""Files straight from the instrument become a campaign by one command, without a line of TOML written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.device import Oscillator
from ident.campaign.propose import propose
from tests.campaign.instruments import COUNT, DRIVE, KINDS, RATE, RESPONSE, TIME
from tests.end_to_end.user import assert_one_line, ident


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_from_the_instrument_becomes_a_campaign(kind, tmp_path):
    write, library = KINDS[kind]
    if library:
        pytest.importorskip(library)
    data = tmp_path / "data"
    data.mkdir()
    assert ident("new", tmp_path / "mine", *write(data)).code == 0
    (record,) = read_campaign(tmp_path / "mine").traces
    assert len(record.time) == COUNT
    np.testing.assert_allclose(1 / record.step, RATE, rtol=1e-6)
    np.testing.assert_allclose(record.drive, DRIVE, atol=3e-4)
    np.testing.assert_allclose(record.response / record.response_channel.factor, _in(record, RESPONSE), atol=3e-4)


def _in(record, values):
    return 1e-6 * values if record.response_channel.unit == "m" else values


def test_the_time_of_a_scope_file_is_seconds(tmp_path):
    write, _ = KINDS["PicoScope"]
    (record,) = read_campaign(write(tmp_path), {"time": "Time", "drive": "Channel A", "response": "Channel B"}).traces
    assert abs(record.step - 1 / RATE) < 1e-12


def test_a_drive_told_in_words_or_by_another_file(tmp_path):
    rows = "".join(f"{t:.9g},{z:.9g}\n" for t, z in zip(TIME, RESPONSE, strict=True))
    (tmp_path / "z.csv").write_text("time (s),z (um)\n" + rows, encoding="utf-8")
    rows = "".join(f"{t:.9g},{u:.9g}\n" for t, u in zip(TIME, DRIVE, strict=True))
    (tmp_path / "u.csv").write_text("time (s),drive (V)\n" + rows, encoding="utf-8")
    head = '[defaults]\nfile = "z.csv"\n'
    (tmp_path / "shunt.csv").write_text("time (s),shunt (V),spare (V)\n" + rows.replace("\n", ",0\n"), encoding="utf-8")
    named = 'drive_file = "shunt.csv"\ncolumns = { drive = "shunt (V)", response = "z (um)" }'
    for told in ('drive = "sine 4 V 500 Hz"', 'drive = "sine 8 Vpp 0.5 kHz"', 'drive_file = "u.csv"', named):
        (tmp_path / "campaign.toml").write_text(
            f'[defaults]\nstart = "steady"\n[[record]]\nfile = "z.csv"\n{told}\n', encoding="utf-8"
        )
        (record,) = read_campaign(tmp_path).traces
        assert record.start == "steady"
        np.testing.assert_allclose(record.drive, DRIVE, atol=1e-4)
    for told, says in (
        ('drive = "square 4 V"', "drive"),
        ('drive = "sine 4 um 500 Hz"', "voltage"),
        ('drive_file = "no.csv"', "no.csv"),
        ('drive_file = "u.csv"\ndrive = "sine 4 V 500 Hz"', "already"),
    ):
        (tmp_path / "campaign.toml").write_text(f'[[record]]\nfile = "z.csv"\n{told}\n', encoding="utf-8")
        assert_one_line(ident("check", tmp_path), says)
    (tmp_path / "campaign.toml").write_text(head + "[[record]]\n", encoding="utf-8")
    assert_one_line(ident("check", tmp_path), "line 2", "belongs to one record")


def test_the_drive_of_another_recording_is_refused(tmp_path):
    for name, values in (("z", RESPONSE), ("u", DRIVE[:-10])):
        rows = "".join(f"{t:.9g},{v:.9g}\n" for t, v in zip(TIME, values, strict=False))
        (tmp_path / f"{name}.csv").write_text(f"time (s),{name} ({'V' if name == 'u' else 'um'})\n{rows}")
    (tmp_path / "campaign.toml").write_text('[[record]]\nfile = "z.csv"\ndrive_file = "u.csv"\n', encoding="utf-8")
    assert_one_line(ident("check", tmp_path), "u.csv", "1990 samples")


def test_columns_told_on_the_command_line(tmp_path):
    rows = "".join(f"{t:.9g},{u},{z}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
    (tmp_path / "a.csv").write_text("when,ping (V),pong (um)\n" + rows, encoding="utf-8")
    told = "time=when,drive=ping (V),response=3"
    assert ident("check", tmp_path / "a.csv", "--columns", told).code == 0
    assert ident("new", tmp_path / "mine", tmp_path / "a.csv", "--columns", told).code == 0
    np.testing.assert_allclose(read_campaign(tmp_path / "mine").traces[0].drive, DRIVE)
    assert_one_line(ident("check", tmp_path / "a.csv", "--columns", "when=time"), "ROLE=COLUMN")
    assert_one_line(ident("check", tmp_path / "mine", "--columns", told), "campaign.toml", "says itself")
    assert_one_line(ident("new", tmp_path / "mine", tmp_path / "a.csv"), "exists already")


def test_channels_that_were_exchanged_in_one_file_are_told(tmp_path):
    rng, time = np.random.default_rng(2), np.arange(400) / 4000
    drive = np.sin(2 * np.pi * 90 * time)
    response = 0.3 * np.sin(2 * np.pi * 90 * time - 0.8) + 0.01 * rng.standard_normal(400)
    for k in range(3):
        pair = (response, drive) if k == 1 else (drive, response)
        rows = "\n".join(f"{t:.6f},{a:.5f},{b:.5f}" for t, a, b in zip(time, *pair, strict=True))
        (tmp_path / f"run{k}.csv").write_text(f"Temps (s),CH1 (V),CH2 (V)\n{rows}\n", encoding="utf-8")
    text = propose([tmp_path / f"run{k}.csv" for k in range(3)], tmp_path)
    assert text.count('drive = "CH1 (V)"') == 3, "one instrument writes one channel into one column"
    assert text.count('but here "CH2 (V)" is the smoother: were the channels exchanged?') == 1


@pytest.mark.parametrize("header", ["t_s,Voltage_V,x_mm", "time (s),Force [N],Displacement [mm]"])
def test_what_moves_millimetres_is_no_platform(header, tmp_path):
    """A loudspeaker, and a mass that is pushed: the columns say what drives them."""
    rows = "".join(f"{t:.9g},{u},{z}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
    (tmp_path / "a.csv").write_text(f"{header}\n{rows}", encoding="utf-8")
    assert np.ptp(RESPONSE) > 2  # mm
    assert ident("new", tmp_path / "mine", tmp_path / "a.csv").code == 0
    assert "doubt" not in (tmp_path / "mine" / "campaign.toml").read_text(encoding="utf-8")
    campaign = read_campaign(tmp_path / "mine")
    assert isinstance(campaign.device, Oscillator) and campaign.device.input == ("N" if "Force" in header else "V")
    np.testing.assert_allclose(campaign.traces[0].drive, DRIVE)


def test_one_record_within_the_others_is_held_out_and_the_load_read_from_its_name(tmp_path):
    files = []
    for name, level in (("a_40mg", 1.0), ("b", 0.5), ("c", 0.25)):
        rows = "".join(f"{t:.9g},{level * u},{level * z}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
        files.append(tmp_path / f"{name}.csv")
        files[-1].write_text("time (s),drive (V),z (um)\n" + rows, encoding="utf-8")
    text = propose(files, tmp_path)
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    campaign = read_campaign(tmp_path)
    assert [record.name for record in campaign.heldout] == ["b.csv"]
    np.testing.assert_allclose([record.load for record in campaign.traces], [40e-6, 0.0, 0.0])
    assert "# doubt: the load is read from the name" in text


def test_a_file_that_is_left_out_is_told_at_once(tmp_path):
    rows = "".join(f"{t:.9g},{u},{z}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
    (tmp_path / "a.csv").write_text("time (s),drive (V),z (um)\n" + rows, encoding="utf-8")
    (tmp_path / "empty.csv").write_text("", encoding="utf-8")
    outcome = ident("new", tmp_path / "mine", tmp_path / "empty.csv", tmp_path / "a.csv")
    assert outcome.code == 0 and "ident: left out: empty.csv" in outcome.err
    text = (tmp_path / "mine" / "campaign.toml").read_text(encoding="utf-8")
    assert "# left out: empty.csv" in text


def test_where_a_platform_is_assumed_the_line_of_another_device_is_there(tmp_path):
    rows = "".join(f"{t:.9g},{u},{z / 1000}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
    (tmp_path / "a.csv").write_text("time (s),drive (V),z (um)\n" + rows, encoding="utf-8")
    text = propose([tmp_path / "a.csv"], tmp_path)
    line = next(one for one in text.splitlines() if 'kind = "oscillator"' in one)
    (tmp_path / "campaign.toml").write_text(text.replace(line, line.removeprefix("# ")), encoding="utf-8")
    assert isinstance(read_campaign(tmp_path).device, Oscillator)


@pytest.mark.parametrize("device", ['device = { kind = "oscillator", output = "um", input = "V" }\n', ""])
def test_a_response_in_volts_is_told_of_the_scale(tmp_path, device):
    rows = "".join(f"{t:.9g},{u},{z}\n" for t, u, z in zip(TIME, DRIVE, RESPONSE, strict=True))
    (tmp_path / "a.csv").write_text("time (s),drive (V),response (V)\n" + rows, encoding="utf-8")
    record = '[[record]]\nfile = "a.csv"\n'
    (tmp_path / "campaign.toml").write_text(device + record, encoding="utf-8")
    error = ident("check", tmp_path).err
    assert 'scale = { response = "0.5 um/V" }' in error and 'kind = "oscillator", output = "V" }' in error
    (tmp_path / "campaign.toml").write_text(device + record + 'scale = { response = "0.5 um/V" }\n', encoding="utf-8")
    assert ident("check", tmp_path).code == 0
