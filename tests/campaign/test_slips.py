"""Slips of a sensor are found; what devices do is none: stops, blows, jumps that stay, corners of a drive."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import read_campaign
from ident.campaign.quality.slips import find_slips
from tests.end_to_end.user import DATA

TIME = np.arange(3000) / 100.0
NOISE = 2e-4 * np.random.default_rng(3).standard_normal(len(TIME))
DECAY = np.exp(-TIME / 20) * np.cos(8.4 * TIME)
STILL = np.zeros(len(TIME))


def slipped(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """A decay whose sensor slips five times, and where."""
    random, reading = np.random.default_rng(4), DECAY + NOISE
    where = np.zeros(len(reading), dtype=bool)
    for k in (300, 711, 1240, 1555, 2250):
        there = slice(k, k + int(random.integers(3, 12)))
        where[there] = True
        reading[there] = {
            "zero": 0.7,
            "held": reading[k - 1] + 0.2,
            "wild": reading[there] + 0.3 * random.choice([-1, 1], there.stop - there.start),
        }[kind]
    return reading, where


@pytest.mark.parametrize("kind", ["zero", "held", "wild"])
def test_slips_are_found_and_little_else(kind):
    reading, where = slipped(kind)
    found = find_slips(reading, STILL)
    assert found is not None
    far = where & (np.abs(reading - DECAY) > 0.15)
    assert np.all(found[far])
    assert np.count_nonzero(found & ~where) <= 8 * 5


def test_what_a_body_does_is_no_slip():
    hit = lambda t, y: [y[1], -70 * y[0] - 0.1 * y[1] - 1e5 * max(y[0] - 0.7, 0.0)]
    stopped = solve_ivp(hit, (0, 30), [1.0, 0.0], t_eval=TIME, max_step=0.002, rtol=1e-9, atol=1e-12).y[0]
    motions = {
        "decay": DECAY,
        "stop": stopped,
        "blow": DECAY + np.where(TIME > 12, np.sin(8.4 * (TIME - 12)), 0.0),
        "jump that stays": DECAY + 0.3 * (TIME > 12),
        "square": np.sign(np.sin(TIME)) * 1.0,
        "corners": np.abs(DECAY),
    }
    for name, motion in motions.items():
        assert find_slips(motion + NOISE, STILL) is None, name


def test_what_the_drive_does_at_once_the_response_may():
    pulse = 0.5 * ((TIME > 12) & (TIME < 12.05))
    assert find_slips(DECAY + pulse + NOISE, pulse) is None
    assert find_slips(DECAY + pulse + NOISE, STILL) is not None


def test_many_are_no_accident():
    reading = DECAY + NOISE
    reading[::40] = reading[1::40] = 0.9
    assert find_slips(reading, STILL) is None


@pytest.mark.parametrize("name", ["platform_clean", "platform_317hz", "platform_fe", "mystery_platform", "oscillator"])
def test_sound_records_have_none(name):
    for record in read_campaign(DATA / name).traces:
        assert find_slips(record.response, record.drive) is None


def test_a_slipping_sensor_is_said_and_moves_neither_floor_nor_level(tmp_path):
    lines = lambda reading: "time_s,x_m\n" + "".join(f"{t:.2f},{x:.6f}\n" for t, x in zip(TIME, reading, strict=True))
    (tmp_path / "sound.csv").write_text(lines(DECAY + NOISE))
    (tmp_path / "slips.csv").write_text(lines(slipped("zero")[0]))
    records = "".join(f'[[record]]\nfile = "{name}.csv"\n' for name in ("sound", "slips"))
    (tmp_path / "campaign.toml").write_text(f'device = {{ kind = "oscillator", output = "m" }}\n{records}')
    campaign = read_campaign(tmp_path)
    sound, slips = campaign.traces
    assert sound.masked is None and slips.masked is not None
    assert any("the sensor slips" in note and note.startswith("slips.csv") for note in campaign.notes)
    assert 0.8 < slips.noise.sigma / sound.noise.sigma < 1.5
    there = ~slips.masked
    np.testing.assert_allclose(slips.response[there], sound.response[there], atol=4 * sound.noise.sigma)  # one level
