"""The noise floor of a record, from the data alone: what neither repeats with the drive nor dies away."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..quality.clipping import across_gaps
from ..quality.gaps import missed_across
from ..record import NoiseFloor
from .autoregression import Autoregression, fit_autoregression, leverage_of
from .flicker import or_flicker
from .hum import HUMS, bands, told_apart, with_hum
from .signal_basis import Pole, beside, find_transient, harmonic_columns, orthonormal, transient_columns

HARMONICS = 12  # of the drive, which are signal
LONGEST = 8192  # samples that are asked; twice as many where frequencies tell that the drive leaves free
_SURER = 1.5
"""Times: doubts are themselves estimates. Of 1044 sines of the hidden-effect generator 7 had floors 7 to 89 times too
high, few periods near a sharp resonance; with this 6 of them are within 40 %, and 7 others change, none by more."""
EXTRAPOLATED = 0.1  # relative error, at least, of a floor that is read off the free frequencies
NUMBERS = 2  # coefficients, at most, or the share of flicker noise: more carry what they see too far below
_LOUD = 0.03  # of the response: a floor below is not asked whether the record's parts agree
_SHORT = 200  # samples of a part at least: the series and the transient take some fifty numbers
_FAR_BELOW = 0.5  # of the floor of the whole: parts that agree with it scatter by a tenth
_SETTLES = 1.5  # times the power of the last third: an earlier one with more is bent to by many columns
_DIVIDED = 600  # samples at least of a record whose first third may be left out
_PER_NUMBER = 1.5  # energy, in units of the noise, that a column of a higher level takes if there is nothing in it
_BESIDES = 6.0  # that all of these together may take besides
_ALIVE = 1.4  # times the energy of the later periods: the first has a transient that is worth leaving it out
_RINGS = 3.0  # energy that each number of a transient between periods takes, where it is one
_RINGS_BESIDES = 20.0  # that all of these together take besides
_RINGING_ERROR = 0.3  # relative, of a floor beside a transient whose products with the drive are not described
_MULTIPLES = (1.3, 2.2, 3.3, 5.0, 7.5, 11.0)
"""Of the drive's highest frequency, from which on the response may be noise alone."""
_HIGHEST = 0.8  # of all frequencies: above it there are too few
_BEARS = 5.0  # times the noise that is seen, as a whole: more than an extrapolation can bear
_UNBEARABLE_ERROR = 0.7  # relative, of a floor that is taken as white instead
_PLATEAU = 1.15  # times what still higher frequencies say: by less than that the motion adds nothing
_STOOD = 1.5  # times the error of a fit that was chosen because it stood on a plateau
_MANY = 50  # frequencies at least that tell a floor without a plateau
_FAR = 3  # times the drive's highest frequency, at least, where these begin
_NO_PLATEAU_ERROR = 0.5  # relative, of a floor without a plateau
_CLIPPED_ERROR = 0.5  # relative, of the floor of a clipped record: found 1.0 to 2.5 times too high, once 8.5


class _Found(NamedTuple):
    """The noise of a record that is scaled to its size, the `method` by which it was found, its `lines`, and nominal
    and own Hz of those that were `heard`."""

    fit: Autoregression
    method: str
    lines: tuple[str, ...] = ()
    heard: tuple[tuple[float, float], ...] = ()


def noise_floor(
    time: np.ndarray,
    drive: np.ndarray,
    response: np.ndarray,
    period: float | None = None,
    masked: np.ndarray | None = None,
    lost: bool = False,
) -> NoiseFloor:
    """Standard deviation and colour of the measurement noise of a record.

    A periodic drive: the noise is what is left of the response beside a Fourier series, a transient and their products.
    A long period with many harmonics: the differences between its repeats. Any other drive, and
    where these are in doubt: the frequencies that the signal leaves free.

    **Arguments:** `time` (n,) s, `drive` (n,) V, `response` (n,) m, `period`: samples per period of the drive or None,
    `masked` (n,): samples that say nothing; a smooth curve takes their place, which is counted as without noise. It may
    miss what a limit cut off, nobody knows by how much; `lost`: they are missing instead, and curves across gaps like
    these elsewhere tell.
    """
    if masked is not None:
        floor = noise_floor(time, drive, across_gaps(response, masked), period)
        sigma = floor.sigma / math.sqrt(1.0 - float(np.mean(masked)))
        if lost:  # what the curve misses adds to the variance as often as a sample is missing
            added = 0.5 * float(np.mean(masked)) * (missed_across(response, masked) / sigma) ** 2
            error = max(floor.relative_error, min(added, 1.0))
            return replace(floor, sigma=sigma, relative_error=error)
        method = f"{floor.method}; rather too high, for the curve beyond the limit is not known"
        return replace(floor, sigma=sigma, method=method, relative_error=max(floor.relative_error, _CLIPPED_ERROR))
    response = response - np.mean(response)
    size = float(np.sqrt(np.mean(response**2)))
    if size == 0.0:
        return NoiseFloor(1e-300, method="none: the response is constant", relative_error=1.0)
    response = response / size
    n = len(response)
    step = float(time[-1] - time[0]) / (n - 1)
    free = False
    if np.ptp(drive) == 0:
        found = _short_period(response[:LONGEST], None, step)
    elif period is None:
        found, free = _free_frequencies(latest(drive), latest(response)), True
    elif period <= 8 * HARMONICS or _highest_harmonic(drive, period) <= HARMONICS // 3:
        found = _of_parts(response[-LONGEST:], period, step, _short_period(response[-LONGEST:], period, step))
    else:
        found = _repeats(response, period)
    if np.ptp(drive) > 0 and found.fit.relative_error > _SURER * EXTRAPOLATED:
        far_above = _free_frequencies(latest(drive), latest(response))
        if _SURER * far_above.fit.relative_error < found.fit.relative_error:
            found, free = far_above, True  # a motion beyond description adds to what is left, but hardly so high
    fit = found.fit
    quantum = _resolution(response)
    sigma = max(fit.sigma, quantum / math.sqrt(12.0), 1e-12)
    if sigma > fit.sigma:
        return NoiseFloor(sigma * size, method="the resolution of the response column", relative_error=0.5)
    unseen = float(np.argmax(fit.used > 0)) / len(fit.used) if free else 0.0
    error = float(fit.relative_error)
    return NoiseFloor(float(sigma * size), fit.ar, found.method, error, unseen, found.lines, found.heard)


def _highest_harmonic(drive: np.ndarray, period: float) -> int:
    """Order of the highest harmonic of a periodic drive, but for a thousandth of its power."""
    whole = int(len(drive) // period)
    lines = np.abs(np.fft.rfft(drive[: int(round(whole * period))]))[::whole] ** 2
    power = np.cumsum(lines[1:])
    return 1 + int(np.searchsorted(power, 0.999 * power[-1]))


def _resolution(response: np.ndarray) -> float:
    """Smallest difference between two values of the response."""
    levels = np.unique(response)
    return float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0


@dataclass(frozen=True)
class _Removed:
    """A signal fit: the noise beside it, the orthonormal columns, their level, and what they leave."""

    fit: Autoregression
    basis: np.ndarray
    level: int
    residual: np.ndarray


def _short_period(response: np.ndarray, period: float | None, step: float, halvings: int = 2) -> _Found:
    """Fourier series, transient and products removed; as many products as the data ask for."""
    n = len(response)
    rate = None if period is None else 2 * np.pi / period
    harmonics = harmonic_columns(n, rate, HARMONICS)
    pole = find_transient(response, rate, HARMONICS, bands(step))
    removed = _removed(response, harmonics, rate, pole, (0, 1, 2, 3) if pole is not None else (0,))
    if removed.level == 3:
        removed = _removed(response, harmonics, rate, pole, (3, 4))
    white = np.convolve(removed.residual, np.append(1.0, -np.array(removed.fit.ar)))[:n] ** 2
    first, middle, last = (float(np.mean(part)) for part in np.array_split(white, 3))
    if max(first, middle) > _SETTLES * last and halvings and n >= _DIVIDED:  # many columns bend to what comes first
        later = _short_period(response[n // 3 :], period, step, halvings - 1)  # a transient beyond description dies
        if later.fit.sigma < removed.fit.sigma:
            return later
    apart = lambda lines: _apart(lines, rate, pole, n)
    fit, share, heard = with_hum(removed.residual, removed.basis, step, apart, removed.fit)
    beside = ["the Fourier series of the drive's period"] if period is not None else []
    beside += ["a transient"] if removed.level else []
    what = "a decay leaves" if period is None else f"{n / period:.0f} periods leave"
    numbers = f"{removed.basis.shape[1]} numbers fitted"
    method = f"what {what} beside {' and '.join(beside) or 'a constant'} ({numbers})"
    if share > 0:
        return _Found(fit, f"{method}; {HUMS}, {share:.0%} of its power, is part of it", (HUMS,), heard)
    return _Found(fit, method)


def _of_parts(response: np.ndarray, period: float, step: float, whole: _Found) -> _Found:
    """The floor of a record's thirds, where theirs is far below that of the whole: lost samples, or a jump, spoil the
    series of the whole record, and would hide themselves behind the floor that they make."""
    third = len(response) // 3
    if whole.fit.sigma < _LOUD or third < max(2.5 * period, _SHORT):
        return whole
    parts = [_short_period(response[k * third : (k + 1) * third], period, step) for k in range(3)]
    usual = sorted(parts, key=lambda part: part.fit.sigma)[1]
    if usual.fit.sigma > _FAR_BELOW * whole.fit.sigma:
        return whole
    where = "in a third of the record; over the whole of it the response does not stay in step"
    return usual._replace(method=f"{usual.method}, {where}")


def _apart(lines: np.ndarray, rate: float | None, pole: Pole | None, n: int) -> np.ndarray:
    """Of rates of mains hum whether the record can tell each from the drive and from the transient."""
    told = told_apart(lines, rate, n)
    return told if pole is None else told & (abs(lines - pole.rate) >= 3.0 * (2 * np.pi / n + pole.decay))


def _removed(
    response: np.ndarray, harmonics: np.ndarray, rate: float | None, pole: Pole | None, levels: tuple[int, ...]
) -> _Removed:
    """The lowest of `levels` whose columns leave no more than those of the highest do."""
    columns, level_of = harmonics, np.zeros(harmonics.shape[1])
    if pole is not None and levels[-1] > 0:
        decaying, own = transient_columns(len(response), rate, pole, levels[-1])
        room = len(response) // 2 - harmonics.shape[1]  # as many samples as numbers fitted are left to tell the noise
        levels = tuple(level for level in levels if np.sum(own <= level) <= room) or levels[:1]
        decaying, own = decaying[:, own <= levels[-1]], own[own <= levels[-1]]
        columns, level_of = np.hstack([harmonics, decaying]), np.concatenate([level_of, own])
    basis, kept = orthonormal(columns)
    level_of = level_of[kept]  # the columns stand in the order of their levels
    up_to = {level: int(np.sum(level_of <= level)) for level in levels}

    highest = levels[-1]
    left = beside(basis, response)
    fit = fit_autoregression(left, leverage_of(basis))
    least = _whitened_energy(left, fit)
    for level in levels[:-1]:
        inside = basis[:, : up_to[level]]
        rest = beside(inside, response)
        if _whitened_energy(rest, fit) - least < _PER_NUMBER * (len(level_of) - up_to[level]) + _BESIDES:
            return _Removed(fit_autoregression(rest, leverage_of(inside)), inside, level, rest)
    return _Removed(fit, basis, highest, left)


def _whitened_energy(residual: np.ndarray, fit: Autoregression) -> float:
    """Energy in units of the noise; per real number 1 is expected."""
    power = np.abs(np.fft.rfft(residual)) ** 2 / len(residual)
    return 2.0 * float(np.sum(power / fit.spectrum))


def _repeats(response: np.ndarray, period: float) -> _Found:
    """Few periods of a rich drive: noise is what differs between them, beside a transient that dies."""
    size = int(round(period))
    count = int(len(response) // period)
    starts = np.round(len(response) - period * np.arange(count, 0, -1)).astype(int)
    folded = np.array([response[start : start + size] for start in starts])
    dropped = 0
    while len(folded) > 2:  # periods in which the transient is alive are worth less than they cost
        energy = np.mean((folded - folded[1:].mean(axis=0)) ** 2, axis=1)
        later = float(np.mean(energy[1:])) * (len(folded) - 1) / max(len(folded) - 2, 1)
        if energy[0] < _ALIVE * later * (1 + 1 / (len(folded) - 1)):
            break
        folded, dropped = folded[1:], dropped + 1
    repeats = len(folded)

    def deflated(columns: np.ndarray) -> np.ndarray:
        """What differs between the periods, of columns (n, M)."""
        blocks = columns.reshape(repeats, size, -1)
        return (blocks - blocks.mean(axis=0)).reshape(columns.shape)

    joined = deflated(folded.reshape(-1, 1))[:, 0]
    leverage = np.zeros(len(joined) // 2 + 1)
    leverage[::repeats] = 1.0
    fit = fit_autoregression(joined, leverage)
    method = f"differences between {repeats} repeats of the drive's period"
    pole = find_transient(joined, None, 0)
    if pole is None or len(joined) > LONGEST:
        return _Found(fit, method)
    columns, level_of = transient_columns(len(joined), None, pole, 4)
    rings = False
    for highest in (1, 3, 4):
        basis, _ = orthonormal(deflated(columns[:, level_of <= highest]))
        rest = beside(basis, joined)
        better = fit_autoregression(rest, leverage + leverage_of(basis))
        gain = _whitened_energy(joined, better) - _whitened_energy(rest, better)
        if gain > _RINGS * basis.shape[1] + _RINGS_BESIDES and better.sigma < fit.sigma:
            fit, rings = better, True
    if rings:  # its products with the drive are not described
        fit = replace(fit, relative_error=max(fit.relative_error, _RINGING_ERROR if repeats > 2 or dropped else 1.0))
    return _Found(fit, f"{method}, beside a transient" if rings else method)


def extrapolated(floor: NoiseFloor) -> bool:
    """Whether a floor was read off frequencies beside those of the motion alone."""
    return floor.unseen > 0.0 and floor.relative_error >= EXTRAPOLATED


def latest(samples: np.ndarray) -> np.ndarray:
    """Those of a record that are asked for the frequencies that its drive leaves free."""
    return samples[-2 * LONGEST :]


def windowed(samples: np.ndarray) -> np.ndarray:
    """Samples as their spectrum is looked at: what is strong does not leak into what is weak."""
    window = np.hanning(len(samples) + 2)[1:-1]
    return (samples - samples.mean()) * window / np.sqrt(np.mean(window**2))


def exciting(drive: np.ndarray) -> np.ndarray:
    """(n//2 + 1,) power of a drive up to each frequency."""
    return np.cumsum(np.abs(np.fft.rfft(windowed(drive))) ** 2)


def _free_frequencies(drive: np.ndarray, response: np.ndarray) -> _Found:
    """Frequencies above the drive's, from where the response no longer shows its products: an extrapolation."""
    n, reached = len(response), exciting(drive)
    top = int(np.searchsorted(reached, 0.999 * reached[-1])) + 2
    last = n // 2
    seen = windowed(response)
    fits: list[tuple[int, Autoregression]] = []
    for multiple in _MULTIPLES:
        low = int(multiple * top)
        if low > _HIGHEST * last:
            break
        fit = or_flicker(fit_autoregression(seen, None, NUMBERS, np.arange(last + 1) < low), seen)
        if fit.sigma > _BEARS * float(np.sqrt(np.mean(fit.spectrum[low:]))):
            fit = fit_autoregression(seen, None, 0, np.arange(last + 1) < low)
            fit = replace(fit, relative_error=_UNBEARABLE_ERROR)
        fits.append((low, fit))
    for (low, fit), (next_low, above) in zip(fits, fits[1:], strict=False):
        if np.mean(fit.spectrum[next_low:]) < _PLATEAU * np.mean(above.spectrum[next_low:]):
            error = min(1.0, float(np.hypot(_STOOD * fit.relative_error, EXTRAPOLATED)))
            share = 1 - low / last
            fit = replace(fit, relative_error=error)
            return _Found(fit, f"extrapolated from the upper {share:.0%} of the frequencies")
    # No plateau: products of the drive, or a filter, reach up to the highest frequencies.
    if fits and last - fits[-1][0] > _MANY and fits[-1][0] > _FAR * top:
        highest = replace(fits[-1][1], relative_error=_NO_PLATEAU_ERROR)
        return _Found(highest, "extrapolated from the highest frequencies")
    low, high = min(int(1.03 * top), int(0.85 * last)), min(max(int(1.15 * top), int(1.03 * top) + 8), last)
    power = np.abs(np.fft.rfft(seen)) ** 2 / n
    sigma = math.sqrt(float(np.median(power[low:high])) / math.log(2.0))
    spectrum = np.full(last + 1, sigma**2)
    words = "the level just above the drive's band, taken as white (it holds distortion too, and may be filtered)"
    return _Found(Autoregression(sigma, (), _NO_PLATEAU_ERROR, spectrum, np.ones(last + 1)), words)
