"""Mains hum: lines that stand out of what a model leaves, at the frequency of the mains while a record was taken."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.noise.floor import noise_floor
from ident.campaign.noise.hum import HUMS, Line, hum_lines, mains_of, standing, told_apart, tuned, tuned_beside_level
from ident.campaign.period import find_period

STEP, N = 1 / 256, 3000


@pytest.mark.parametrize("seed", range(4))
def test_of_two_mains_lines_that_a_short_record_does_not_tell_apart_none_is_hum(seed):
    """100 and 120 Hz in 26 ms: noise alone gave each up to an eighth of its power, which the other took away."""
    step = 1 / 230e3
    left = np.random.default_rng(seed).standard_normal(6000)
    assert standing(left, step, [Line(hz, hz) for hz in (100.0, 120.0, 150.0, 180.0)]) == [0.0] * 4
    hum = np.sin(2 * np.pi * 50.0 * 10 * step * np.arange(6000))
    powers = standing(left + 0.5 * hum, 10 * step, [Line(hz, hz) for hz in (50.0, 60.0, 100.0, 120.0)])
    assert powers[0] == pytest.approx(0.125, rel=0.2) and powers[1:] == [0.0] * 3


def _read(driven: float, hum: float, mains: float, seed: int = 8900) -> tuple[np.ndarray, ...]:
    """Time, drive and response of 12 s: a motion at the frequency at which it is `driven`, Hz, white noise of rms one,
    and a line of rms `hum`."""
    rng, time = np.random.default_rng(seed), STEP * np.arange(N)
    drive = np.sin(2 * np.pi * driven * time)
    line = hum * np.sqrt(2) * np.sin(2 * np.pi * mains * time + 0.7)
    return time, drive, 30 * np.sin(2 * np.pi * driven * time - 0.4) + line + rng.standard_normal(N)


@pytest.mark.parametrize("mains", [49.83, 49.97, 50.0, 50.03, 50.2, 59.85])
def test_hum_beside_its_nominal_frequency_is_in_the_floor(mains):
    """Of a line 0.03 Hz beside 50 Hz a floor knew two thirds."""
    time, drive, response = _read(3.0, 0.8, mains)
    floor = noise_floor(time, drive, response, find_period(drive))
    assert floor.sigma == pytest.approx(np.sqrt(1.64), rel=0.04)
    assert floor.lines == (HUMS,)
    nearest = min(mains_of(floor), key=lambda hz: abs(hz - mains))
    assert nearest == pytest.approx(mains, abs=0.01)


@pytest.mark.parametrize("seed", range(8900, 8904))
def test_without_hum_a_floor_knows_none(seed):
    time, drive, response = _read(3.0, 0.0, 50.0, seed)
    floor = noise_floor(time, drive, response, find_period(drive))
    assert floor.sigma == pytest.approx(1.0, rel=0.05) and not floor.lines and not floor.heard


def test_noise_is_called_hum_as_seldom_as_at_one_frequency():
    """Of 600 records six lines each, of which noise alone is called hum once in 3000 times."""
    rng, apart, called = np.random.default_rng(8904), lambda rates: told_apart(rates, None, 1000), 0
    for _ in range(600):
        left = rng.standard_normal(1000)
        for line in hum_lines(tuned(left, 0.004, apart, np.zeros(501)), 1000, 0.004):
            rate = 2 * np.pi * line.hz * 0.004
            power = 2e-3 * abs(left @ np.exp(-1j * rate * np.arange(1000))) ** 2
            called += bool(apart(np.array([rate]))[0] and power > line.least)
    assert called <= 4


def test_what_is_driven_near_the_mains_is_no_hum():
    time, drive, response = _read(50.1, 0.0, 50.0)
    floor = noise_floor(time, drive, response, find_period(drive))
    assert floor.sigma == pytest.approx(1.0, rel=0.05) and not floor.lines
    apart = lambda rates: told_apart(rates, 2 * np.pi * 50.1 * STEP, N)
    mains = tuned_beside_level(0.1 * response, STEP, apart)  # a model that misses a tenth of it
    lines = [line for line in hum_lines(mains, N, STEP) if apart(np.array([2 * np.pi * line.hz * STEP]))[0]]
    assert standing(0.1 * response, STEP, lines) == [0.0] * len(lines)
    assert abs(mains[0] - 50.1) >= 1.5 / (N * STEP) - 1e-3


def test_a_short_record_is_asked_at_the_nominal_frequency():
    rng = np.random.default_rng(8905)
    apart = lambda rates: told_apart(rates, None, 2000)
    assert tuned(rng.standard_normal(2000), 2e-4, apart, np.zeros(1001)) == (50.0, 60.0)
    assert {line.least for line in hum_lines((50.0, 60.0), 2000, 2e-4)} == {Line(50.0, 50.0).least}


def _short(seed: int) -> tuple[np.ndarray, np.ndarray, list[Line]]:
    """White noise, time from -1 to 1, and the lines of a record of 40 ms, two periods of the mains."""
    return np.random.default_rng(seed).standard_normal(1600), np.linspace(-1, 1, 1600), hum_lines((50, 60), 1600, 25e-6)


@pytest.mark.parametrize("seed", range(8906, 8910))
def test_two_periods_of_hum_are_hum_and_a_level_that_bends_is_none(seed):
    """Beside a level that bends as much nobody tells two periods of a line, and floors lacked two fifths of the power.
    A sensor that creeps or drifts is described better by the level."""
    white, time, lines = _short(seed)
    rng = np.random.default_rng(seed)
    hum = 1.2 * np.sin(2 * np.pi * time + rng.uniform(0, 6)) + 0.6 * np.sin(6 * np.pi * time + rng.uniform(0, 6))
    powers = dict(zip([line.nominal for line in lines], standing(white + hum, 25e-6, lines), strict=True))
    assert powers[50.0] == pytest.approx(0.72, rel=0.2) and powers[150.0] == pytest.approx(0.18, rel=0.4)
    assert powers[60.0] == powers[120.0] == powers[180.0] == 0.0
    for level in (2 * time, 2 * time**2, 3 * np.exp(-3 * (1 + time)), 2 * np.log(1.01 + time), np.cumsum(white) / 20):
        assert max(standing(white[::-1] + level, 25e-6, lines)) < 0.05


@pytest.mark.parametrize("mains", [49.91, 50.03])
def test_loud_hum_is_found_where_it_is(mains):
    """An autoregression of it has its peak, and took it for noise: it was sought a quarter of a resolution aside."""
    rng, time = np.random.default_rng(8911), STEP * np.arange(N)
    left = 5 * np.sin(2 * np.pi * mains * time + 0.3) + rng.standard_normal(N)
    found = tuned_beside_level(left, STEP, lambda rates: told_apart(rates, None, N))
    assert found[0] == pytest.approx(mains, abs=1e-3)


def test_samples_that_are_days_apart_show_no_mains():
    rng = np.random.default_rng(1)
    drive = np.sin(0.3 * np.arange(160))
    noise_floor(1e5 * np.arange(160.0), drive, drive + 0.01 * rng.normal(size=160), 2 * np.pi / 0.3)
    assert hum_lines((50.0, 60.0), 160, 1e5)[0].least == hum_lines((50.0, 60.0), 160, 1e-4)[0].least
