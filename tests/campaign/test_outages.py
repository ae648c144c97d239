"""A recorder that stops on the way: the stretches of a driven record, and what was said of the whole."""

import numpy as np
import pytest

from ident.campaign import read_campaign

STEP = 1e-3
TIME = np.arange(400) * STEP
DRIVE = np.sin(2 * np.pi * 31.7 * TIME) + 0.5 * np.sin(2 * np.pi * 83.1 * TIME)
LOST = range(100, 140)


def _campaign(folder, said="", response=None):
    response = np.convolve(DRIVE, np.hanning(9), "same") if response is None else response
    rows = [f"{TIME[k]:.6f},{DRIVE[k]:.6f},{response[k]:.6f}" for k in range(len(TIME)) if k not in LOST]
    (folder / "a.csv").write_text("\n".join(["time (s),drive (V),z (um)", *rows]) + "\n", encoding="utf-8")
    text = f'[device]\nkind = "oscillator"\n\n[[record]]\nfile = "a.csv"\n{said}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return read_campaign(folder)


@pytest.mark.parametrize("skip", ['"30 ms"', "30"])
def test_what_is_skipped_ends_in_the_first_stretch(tmp_path, skip):
    first, second = _campaign(tmp_path, f"skip = {skip}").traces
    assert (len(first.time), len(second.time)) == (100, 260)
    assert (first.skip, second.skip) == (30, 0) and second.begins_in_motion


@pytest.mark.parametrize("skip", ['"160 ms"', "160"])
def test_what_is_skipped_goes_on_in_the_second_stretch(tmp_path, skip):
    campaign = _campaign(tmp_path, f"skip = {skip}")
    (second,) = campaign.traces
    assert second.name == "a.csv, stretch 2" and second.skip == 20
    assert any("1 of them is left out" in note for note in campaign.notes)


def test_a_stretch_in_which_the_sensor_was_off_shows_nothing(tmp_path):
    response = np.where(np.arange(400) < 140, 0.25, np.convolve(DRIVE, np.hanning(9), "same"))
    (second,) = _campaign(tmp_path, response=response).traces
    assert second.name == "a.csv, stretch 2" and second.into == 0.0
