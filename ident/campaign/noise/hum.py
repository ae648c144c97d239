"""Mains hum: lines at known frequencies that no model explains, and that therefore are noise.

The frequency of the mains wanders. A line looked for 0.03 Hz beside it sees two thirds of its power in 12 s, and in
half a minute nothing. It is sought where it was while a record was taken, all overtones in proportion, once for each
record: its noise floor says where, and whoever takes the lines out of what a model leaves takes them there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander

from ..record import NoiseFloor
from .autoregression import (
    MAX_ORDER,
    Autoregression,
    ar_spectrum,
    fit_autoregression,
    leverage_of,
    levinson,
    variance_of,
)
from .signal_basis import beside, dies

MAINS = (50.0, 60.0)
"""Hz; hum is a nuisance of the laboratory, never a property of the device."""

ORDERS = (1, 2, 3)  # of its overtones
HUM = tuple(hz * order for hz in MAINS for order in ORDERS)
"""Hz, with its overtones."""

WANDERS = 0.2
"""Hz by which the mains is off where it should be, at most.
Source: Commission Regulation (EU) 2017/1485, Annex III (the steady-state deviation, 200 mHz)."""

Apart = Callable[[np.ndarray], np.ndarray]
"""Of some rates (rad per sample) whether a line there is told from the drive, and from what rings."""

_STANDS = 16.0  # times the noise beside it: a line of noise alone has as much power once in 3000 times
_SEEN = 0.3  # of a line, at least, beside all else: of less the record is too short to tell it from the rest
HUMS, SURROUNDINGS = "mains hum", "a line of the surroundings"  # the lines of a floor, in words
PERIODS = 2.5  # that a record holds of a line, at least: of fewer it may be a level that bends
FEWEST = 1.5  # periods of a line from which it holds less than a tenth of a constant, 2/(π periods)²
_HIGHEST = 3.0  # rad per sample, of a line that is told: at π it has one phase only
_ABOUT = 0.02 * np.pi  # rad per sample on either side of a line: so narrow is its peak in an autoregression
_FINE = 4096  # frequencies from which covariances are read
_GRID = 0.25
"""Of a record's resolution, of the highest overtone: between two such places a line keeps 95 % of its power."""
_FINER = 32  # times: what a line then loses is no more than a noise has, up to ten thousand times as much power


def told_apart(lines: np.ndarray, rate: float | None, n: int, periods: float = PERIODS) -> np.ndarray:
    """Of some lines whether n samples tell each from a level and from the drive, whose harmonics lie `rate` apart (rad
    per sample, as the lines); of each there are more than so many `periods`."""
    width = 2 * np.pi / n
    long_enough = (periods * width < lines) & (lines < _HIGHEST)
    return long_enough if rate is None else long_enough & (abs(lines - np.round(lines / rate) * rate) >= 1.5 * width)


def mains_of(noise: NoiseFloor) -> tuple[float, ...]:
    """Hz of each of `MAINS` while a record was taken, as far as its noise floor knows."""
    at = dict(noise.heard)
    found = [[at[hz * order] / order for order in ORDERS if hz * order in at] for hz in MAINS]
    return tuple(own[0] if own else hz for hz, own in zip(MAINS, found, strict=True))


def bands(step: float) -> list[tuple[float, float]]:
    """Lowest and highest rate (rad per sample) at which each line of hum may be."""
    at = 2 * np.pi * step
    return [(at * order * (hz - WANDERS), at * order * (hz + WANDERS)) for hz in MAINS for order in ORDERS]


def tuned(left: np.ndarray, step: float, apart: Apart, leverage: np.ndarray) -> tuple[float, ...]:
    """Hz of each of `MAINS` that its lines, told `apart`, stand out most of what is `left` (n,) of a record beside its
    signal; as they should be where the record is too short to say another.

    **Arguments:** `step`: s; `leverage`: (n//2 + 1,) of the columns of the signal.
    """
    count, finest = _places(len(left), step)
    if not count:
        return MAINS
    at, near = np.linspace(0, np.pi, len(leverage)), 2 * 2 * np.pi / len(left)
    hidden = np.any([(low - near < at) & (at < high + near) for low, high in bands(step)], axis=0)
    spectrum = fit_autoregression(left, leverage, excluded=hidden).spectrum  # else loud hum counts as its own noise
    return tuple(_strongest(left, step, apart, spectrum, hz, count, finest) for hz in MAINS)


def _strongest(
    left: np.ndarray, step: float, apart: Apart, spectrum: np.ndarray, hz: float, count: int, finest: float
) -> float:
    """The frequency, of `count` on either side of one, `finest` apart, and then of some between these, at which all
    overtones together stand out most."""
    levels = _level(spectrum, 2 * np.pi * step * hz * np.array(ORDERS))
    for places, between in ((count, finest), (_FINER, finest / _FINER)):
        tried, heard = hz + between * np.arange(-places, places + 1), 0.0
        for order, level in zip(ORDERS, levels, strict=True):
            rates = 2 * np.pi * step * order * tried
            power = np.abs(_at_rates(left, rates[0], rates[1] - rates[0], len(rates))) ** 2
            heard = heard + np.where(apart(rates), power / level, 0.0)
        hz = float(tried[np.argmax(heard)]) if np.any(heard) else hz
    return hz


def _at_rates(left: np.ndarray, first: float, between: float, count: int) -> np.ndarray:
    """(count,) Fourier sums of samples (n,) at rates that lie evenly `between` one another, rad per sample.

    Source: L. I. Bluestein, 1970, IEEE Trans. Audio Electroacoust. 18, 451 (jk = (j² + k² − (j − k)²)/2).
    """
    n, k = len(left), np.arange(max(len(left), count))
    chirp, size = np.exp(-0.5j * between * k**2), 1 << (len(left) + count).bit_length()
    turned = left * np.exp(-1j * first * k[:n]) * chirp[:n]
    back = np.conj(np.concatenate([chirp[n - 1 : 0 : -1], chirp[:count]]))
    both = np.fft.ifft(np.fft.fft(turned, size) * np.fft.fft(back, size))
    return chirp[:count] * both[n - 1 : n - 1 + count]


def _places(n: int, step: float) -> tuple[int, float]:
    """How many places on either side of the mains frequency n samples tell apart, and Hz between two of them; none of
    samples too far apart to show a line."""
    finest = _GRID / (ORDERS[-1] * n * step)
    return (int(WANDERS / finest) if 2 * np.pi * MAINS[0] * step < _HIGHEST else 0), finest


class Line(NamedTuple):
    """A line that may be hum: its `nominal` frequency and where it is, Hz; and how many times the noise it has where it
    stands out, at the `least`."""

    nominal: float
    hz: float
    least: float = _STANDS


def hum_lines(mains: Sequence[float], n: int, step: float) -> list[Line]:
    """The lines of hum in n samples, `step` s apart, where they are as the `mains` was, Hz.

    The largest of all frequencies within which a line is sought exceeds a level so many times as often as one does: it
    is asked to stand higher, as improbable by noise as one that is not sought.
    Source: R. V. Baluev, 2008, Mon. Not. R. Astron. Soc. 385, 1279."""
    found = []
    for nominal, hz in zip(MAINS, mains, strict=True):
        for order in ORDERS:
            cells = 2 * WANDERS * order * n * step if _places(n, step)[0] else 0.0
            sought = 2 * float(np.log(1 + cells * np.sqrt(np.pi / 3 * _STANDS / 2)))
            found.append(Line(nominal * order, hz * order, _STANDS + sought))
    return found


def _level(spectrum: np.ndarray, rates: np.ndarray) -> np.ndarray:
    return np.interp(rates, np.linspace(0, np.pi, len(spectrum)), spectrum)


def with_hum(
    residual: np.ndarray, basis: np.ndarray, step: float, apart: Apart, fit: Autoregression
) -> tuple[Autoregression, float, tuple[tuple[float, float], ...]]:
    """The noise with the mains lines that stand out of it, the share of its power that is hum, and nominal and own Hz
    of these lines.

    **Arguments:** `residual` (n,) of a fit of the orthonormal `basis` (n, M), `step`: s; lines are told `apart`, `fit`:
    the noise without regard to hum.
    """
    n, mains = len(residual), tuned(residual, step, apart, leverage_of(basis))
    lines = hum_lines(mains, n, step)
    rates = _rates(lines, step)
    told, at_lines = apart(rates), _level(fit.spectrum, rates)
    power, covariance = 0.0, np.zeros(MAX_ORDER + 1)
    rest, own, heard, waves = residual, [], [], _waves(rates, n)
    alone = beside(basis, waves)
    for k in np.flatnonzero(told):
        columns, inside = waves[:, 2 * k : 2 * k + 2], alone[:, 2 * k : 2 * k + 2]
        seen = np.sum(inside**2) / np.sum(columns**2)
        if seen < _SEEN:
            continue
        weights = np.linalg.lstsq(inside, rest, rcond=None)[0]
        level = float(at_lines[k])
        gain = float(np.sum((inside @ weights) ** 2)) / level
        amplitude = float(np.sum(weights**2)) / 2 - 2 * level / (n * seen)
        if gain > lines[k].least and amplitude > 0:
            rest = rest - inside @ weights
            own.append(inside)
            heard.append(lines[k][:2])
            power += amplitude
            covariance += _covariance(amplitude, rates[k])
    if power == 0.0:
        return fit, 0.0, ()
    leverage = leverage_of(basis) + leverage_of(np.linalg.qr(np.column_stack(own))[0])
    below = fit_autoregression(rest, leverage)
    share = power / (power + below.sigma**2)
    total = float(np.sqrt(power + below.sigma**2))
    below_covariance = np.fft.irfft(below.spectrum, n)[: MAX_ORDER + 1]
    ar, innovation = levinson(below_covariance + covariance, MAX_ORDER)
    error = float(np.hypot(below.relative_error * (1 - share), 0.3 * share / np.sqrt(len(own))))
    spectrum = ar_spectrum(ar, innovation, n)
    noise = replace(below, sigma=total, ar=tuple(float(a) for a in ar), relative_error=error, spectrum=spectrum)
    return noise, share, tuple(heard)


def _waves(lines: np.ndarray, n: int) -> np.ndarray:
    """Cosine and sine of each line, (n, 2 lines)."""
    turning = [np.exp(1j * line * np.arange(n)) for line in lines]
    return np.array([part for wave in turning for part in (np.real(wave), np.imag(wave))]).reshape(-1, n).T


def _covariance(power: float, line: float) -> np.ndarray:
    return power * np.cos(line * np.arange(MAX_ORDER + 1))


def tuned_beside_level(left: np.ndarray, step: float, apart: Apart) -> tuple[float, ...]:
    """Hz of each of `MAINS`, `tuned` in what a model leaves, (n,), beside a level that bends."""
    level = _bent_level(len(left))
    rest = left - level @ np.linalg.lstsq(level, left, rcond=None)[0]
    return tuned(rest, step, apart, _evenly(len(rest), level.shape[1]))


def standing(left: np.ndarray, step: float, lines: Sequence[Line]) -> list[float]:
    """The mean square of each line that stands out of what a model leaves, (n,), and does not die; zero of the others.

    It leaves a level too, that bends: a sensor that drifts does not hum. Of `PERIODS` or less a line is told from that
    only where the lines of one mains describe what is left better beside a constant than a level does, alone or beside
    them, each number at its price: what drifts at random leaves a level beside any line.
    Source: G. Schwarz, 1978, Ann. Stat. 6, 461."""
    n = len(left)
    long_enough = [line for line in lines if line.hz * n * step > PERIODS]
    bent, constant = _bent_level(n), np.ones((n, 1))
    ways = [(long_enough, bent)]
    if len(long_enough) < len(lines):
        of_one = [[line for line in lines if line.nominal % hz == 0] for hz in MAINS]
        ways += [(own, level) for own in of_one if own for level in (constant, bent)]

    def criterion(way: tuple[list[Line], np.ndarray]) -> float:
        columns = np.column_stack([_waves(_rates(way[0], step), n), way[1]])
        rest = left - columns @ np.linalg.lstsq(columns, left, rcond=None)[0]
        return n * float(np.log(max(float(np.mean(rest**2)), 1e-300))) + columns.shape[1] * float(np.log(n))

    best = min(ways, key=criterion)
    heard, level = best if best[1] is constant else ways[0]
    powers = dict(zip(heard, _beside_level(left, step, heard, level), strict=True))
    return [powers.get(line, 0.0) for line in lines]


def _rates(lines: Sequence[Line], step: float) -> np.ndarray:
    return 2 * np.pi * step * np.array([line.hz for line in lines])


def _beside_level(left: np.ndarray, step: float, lines: Sequence[Line], level: np.ndarray) -> list[float]:
    """`standing` beside a level (n, columns). A line counts by what it alone says beside all the others: of two that
    differ by half a period in a record each seems to say what both do."""
    n, found, rates = len(left), [], _rates(lines, step)
    waves = _waves(rates, n)
    all_of_them = np.column_stack([waves, level])
    weights = np.linalg.lstsq(all_of_them, left, rcond=None)[0]
    spread = np.linalg.pinv(all_of_them.T @ all_of_them)
    rest = left - all_of_them @ weights
    levels = _level(_spectrum_beside(rest, len(weights)), rates)
    for k, (line, rate) in enumerate(zip(lines, rates, strict=True)):
        its = slice(2 * k, 2 * k + 2)
        own, alone = waves[:, its] @ weights[its], np.linalg.pinv(spread[its, its])
        seen = float(np.trace(alone)) / n  # of the power of its two waves
        beside_it = float(levels[k])
        gain = float(weights[its] @ alone @ weights[its])
        stands = seen >= _SEEN and gain > line.least * beside_it and not dies(rest + own, rate)
        found.append(max(float(np.mean(own**2)) - 2 * beside_it / (n * seen), 0.0) if stands else 0.0)
    return found


def _bent_level(n: int) -> np.ndarray:
    """(n, columns) of a level that bends as a few periods of hum do."""
    return legvander(np.linspace(-1, 1, n), round(2 * PERIODS))


def _spectrum_beside(rest: np.ndarray, columns: int) -> np.ndarray:
    """(n//2 + 1,) of the noise that some fitted columns leave."""
    return fit_autoregression(rest, _evenly(len(rest), columns)).spectrum


def _evenly(n: int, columns: int) -> np.ndarray:
    """(n//2 + 1,) leverage of so many columns, if it were the same at all frequencies."""
    return np.full(n // 2 + 1, columns / n)


def knows(noise: NoiseFloor, power: float, line: float) -> bool:
    """Whether a noise floor already has most of the mean square `power` of a line (rad per sample) about it."""
    ar = np.array(noise.ar, float)[:MAX_ORDER]
    spectrum = ar_spectrum(ar, noise.sigma**2 / variance_of(ar, 1.0), _FINE)
    rates = np.linspace(0, np.pi, len(spectrum))
    return float(np.mean(spectrum * (np.abs(rates - line) < _ABOUT))) > 0.5 * power


def with_lines(noise: NoiseFloor, powers: Sequence[float], lines: Sequence[Line], step: float, what: str) -> NoiseFloor:
    """A noise floor with the mean squares `powers` of lines as a part of it, and the word for `what` they are; `step`:
    s."""
    white = np.array(noise.ar, float)[:MAX_ORDER]
    below = ar_spectrum(white, noise.sigma**2 / variance_of(white, 1.0), _FINE)
    covariance = np.fft.irfft(below, _FINE)[: MAX_ORDER + 1]
    covariance = covariance + sum(
        _covariance(power, line) for power, line in zip(powers, _rates(lines, step), strict=True)
    )
    total = float(noise.sigma**2 + sum(powers))
    share = sum(powers) / total
    method = f"{noise.method}; {what}, {share:.0%} of its power, is part of it".lstrip("; ")
    ar = tuple(float(a) for a in levinson(covariance, MAX_ORDER)[0])
    lines_in = tuple(dict.fromkeys([*noise.lines, what]))
    heard = (*noise.heard, *(line[:2] for line in lines))
    return NoiseFloor(float(np.sqrt(total)), ar, method, noise.relative_error * (1 - share), 0.0, lines_in, heard)
