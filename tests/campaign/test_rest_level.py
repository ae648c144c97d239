"""From where free decays are counted, alone and beside driven records of the same sensor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign.propose import propose
from ident.campaign.quality.rest_level import level_before, rest_level
from ident.campaign.read import read_campaign

OFFSET = 0.6e-6


def campaign(folder: Path, driven_offset: float | None, bias: float = 0.0) -> Path:
    """A decay whose sensor has an offset, and a driven record about a level of its own, if there is one."""
    t, rng = np.arange(3000) / 2000.0, np.random.default_rng(1)
    decay = 3e-6 * np.exp(-6 * t) * np.cos(2 * np.pi * 85 * t) + OFFSET + 1e-8 * rng.normal(size=len(t))
    np.savetxt(folder / "free.csv", np.c_[t, 1e6 * decay], delimiter=",", header="t_s,y_um", comments="")
    files = ["free.csv"]
    if driven_offset is not None:
        u = bias + np.sin(2 * np.pi * 60 * t)
        y = 1e-6 * np.sin(2 * np.pi * 60 * t - 0.3) + driven_offset + 1e-8 * rng.normal(size=len(t))
        np.savetxt(folder / "sine.csv", np.c_[t, u, 1e6 * y], delimiter=",", header="t_s,u_V,y_um", comments="")
        files.append("sine.csv")
    records = "".join(f'\n[[record]]\nfile = "{file}"\nstart = "unknown"\n' for file in files)
    (folder / "campaign.toml").write_text(f'device = {{ kind = "oscillator", output = "um" }}\n{records}')
    return folder


@pytest.mark.parametrize(("driven", "rest"), [(None, 0.0), (0.0, 0.0), (OFFSET, OFFSET)])
def test_decays_are_counted_from_rest_unless_driven_records_have_the_same_level(tmp_path, driven, rest):
    """A fork with a capacitive probe: its decay was counted from rest, the offset of the probe that the driven records
    showed was added to it all the same, and a support that relaxes and a creep made good the difference."""
    told = read_campaign(campaign(tmp_path, driven))
    decay = next(trace for trace in told.traces if trace.name == "free.csv")
    assert np.mean(decay.response[-500:]) == pytest.approx(rest, abs=2e-9)
    assert any("counted from" in note for note in told.notes) == (rest == 0.0)


def test_a_level_that_a_biased_drive_makes_is_no_offset(tmp_path):
    told = read_campaign(campaign(tmp_path, OFFSET, bias=1.0))
    decay = next(trace for trace in told.traces if trace.name == "free.csv")
    assert np.mean(decay.response[-500:]) == pytest.approx(0.0, abs=2e-9)


@pytest.mark.parametrize(("pause", "moving", "start"), [(40, 0.0, "rest"), (40, 0.3, "unknown"), (3, 0.0, "unknown")])
def test_nothing_that_moves_before_the_drive_begins_is_a_rest_whatever_the_sensors_zero(tmp_path, pause, moving, start):
    """Oscilloscope files of a platform that rested at 1.2 µm were begun with a motion of that size."""
    t, rng = np.arange(2000) / 8000.0, np.random.default_rng(2)
    u = np.where(np.arange(2000) < pause, 0.0, np.sin(2 * np.pi * 300 * (t - pause / 8000)))
    y = 1.2 + u + moving * np.cos(2 * np.pi * 500 * t) + 0.01 * rng.normal(size=2000)
    np.savetxt(tmp_path / "a.csv", np.c_[t, u, y], delimiter=",", header="t_s,u_V,y_um", comments="")
    [trace] = read_campaign(tmp_path / "a.csv").traces
    level = level_before(trace)
    assert (level is not None) == (start == "rest") and trace.start == "unknown"
    assert level is None or level == pytest.approx(1.2e-6, abs=1e-8)
    assert f'start = "{start}"' in propose([tmp_path / "a.csv"], tmp_path)


def test_a_level_is_followed_to_where_nothing_moves():
    """An optical probe with a bent characteristic moved the mean of a cantilever's decays by one or two noise floors
    in their later halves, and what that left was said to be another law."""
    rng = np.random.default_rng(3)
    t = np.arange(12000) / 600.0
    z = 4.0 * np.exp(-0.13 * t) * np.cos(2 * np.pi * 38.2 * t)
    noise = 0.004 * rng.normal(size=len(t))
    plain, bent = rest_level(z + OFFSET + noise), rest_level(z + 0.011 * z**2 + OFFSET + noise)
    assert plain == pytest.approx(OFFSET, abs=5e-4) and bent == pytest.approx(OFFSET, abs=5e-4)


@pytest.mark.parametrize("lasting", [1.0, 0.5])
def test_a_level_is_not_followed_from_far_away(lasting: float):
    """Where the motion lasts, a drift of the mean that is none of its own leads anywhere."""
    rng, t = np.random.default_rng(4), np.arange(12000) / 600.0
    z = 4.0 * np.exp(np.log(lasting) * t / t[-1]) * np.cos(2 * np.pi * 38.2 * t)
    drift = 0.01 * np.cumsum(rng.normal(size=len(t))) / np.sqrt(len(t))
    assert rest_level(z + drift + 0.004 * rng.normal(size=len(t))) == pytest.approx(0.0, abs=0.02)
