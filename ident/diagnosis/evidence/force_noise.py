"""Noise of the force beside that of the sensor: what the column of the drive does not show, or the surroundings push.

White noise w of the force comes through the device. Near a sharp resonance it stands far above the noise s of the
sensor, and no autoregression of few numbers has that colour; it takes one number ρ more than white noise:

    A e = B w + A s = C ε,    S(ω) = σ² (1 + ρ |B/A|²),

A and B of the oscillator at the frequency and quality of the fit, C the factor of A A* + ρ B B* that has its zeros
inside the unit circle.

Source: P. Whittle, "Estimation and information in stationary time series", Ark. Mat. 2 (1953) 423 (the likelihood);
P. J. Brockwell, R. A. Davis, Time Series: Theory and Methods, 1991, §4.4 (spectral densities of ARMA processes).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...campaign.noise.recursive import recursive_filter
from ...fit.linear.stretches import oscillator_filter
from ...model import FREQUENCY, GAIN, QUALITY

if TYPE_CHECKING:
    from ..linearised.regression import Regression

_SHARES = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 17)])  # ρ, with |B/A|² one in the mean
_SEEN = 2.0  # standard deviations: where less of it is seen, the search for its size is spared
_NO_LINE = 7.0  # above ln n: noise has a line as loud once in a thousand records
_NEARER = np.geomspace(0.4, 2.5, 9)  # times the best of them


class ForceNoise(NamedTuple):
    """A filter that whitens what noise of force and sensor leave, A/C; `ratio`: of the power that the force has to that
    of the sensor, ρ with |B/A|² one in the mean."""

    numerator: np.ndarray
    denominator: np.ndarray
    ratio: float
    begins: int = 2  # samples: a whole one of the filter's memory

    def whiten(self, values: np.ndarray) -> np.ndarray:
        """Values (n,) or (n, columns), whitened along the first axis."""
        return recursive_filter(self.numerator, self.denominator, values)


@dataclass(frozen=True, eq=False)
class _Device:
    """A and B, as a record's floor whitens it; the `gain` |B/A|² at the frequencies of n samples, (n//2,), divided by
    its mean `size`, as B is by the root of that."""

    a: np.ndarray
    b: np.ndarray
    gain: np.ndarray
    size: float


class Pushed(NamedTuple):
    """What a model leaves, taken as noise of sensor and force: its `level`, in noise floors, and the `share` that the
    force's is of the drive's rms in the record that shows it most; zero where nothing drives."""

    level: float
    share: float


def pushed_by_noise(regression: Regression) -> Pushed | None:
    """What is left of all records as noise of sensor and force, the sensor's as the floors say; None where a line
    stands out of that in one of them, or the model is no oscillator."""
    if not regression.whitenings:
        return None
    fit, square, most = regression.fit, 0.0, (-1.0, 0.0)
    records, linear = fit.campaign.fitted, fit.model.linear
    mass = float(fit.model.mass_of(fit.values))
    per_volt = abs(float(fit.values[GAIN])) * linear.force_per_gain / mass  # m/s² for a volt
    for k, own in enumerate(regression.places):
        left = regression.residual[own]
        noise = force_noise(regression, k, left, level=1.0)
        if noise is None:
            return None
        white = noise.whiten(left)
        if np.max(np.abs(np.fft.rfft(white)) ** 2) / len(white) > np.log(len(white)) + _NO_LINE:
            return None
        square += float(white @ white)
        size = _through_the_device(regression, k, len(left)).size
        pushed = regression.whitenings[k].scale * np.sqrt(noise.ratio / size)  # m/s²
        most = max(most, (noise.ratio, pushed / (per_volt * float(np.std(records[k].drive)) or np.inf)))
    return Pushed(float(np.sqrt(square / regression.n)), float(most[1]))


def force_noise(regression: Regression, k: int, left: np.ndarray, level: float | None = None) -> ForceNoise | None:
    """The noise that describes best what is left (n,) of the k-th record, whitened by its floor; `level`: of the white
    part, if that is known. None if the model is no oscillator, k counts beyond the traces, or none is seen."""
    if k >= len(regression.whitenings) or regression.fit.model.form != "oscillator":
        return None
    device = _through_the_device(regression, k, len(left))
    power = np.abs(np.fft.rfft(left))[1:] ** 2 / len(left)
    if level is None and _score(power, device.gain) < _SEEN:
        return None
    best = None
    for _ in range(2):
        shares, whitening, heights = _spectra(device, best)
        white = whitening @ power / len(power)
        costs = heights + (np.log(white) if level is None else white / level**2)
        best = float(shares[np.argmin(costs)])
    assert best is not None  # after two rounds
    return _filter(device, best)


@lru_cache(maxsize=64)  # many candidates ask for few of them
def _spectra(device: _Device, best: float | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The shares ρ of the first round, or around its `best`; one over each one's spectrum, (ρ, n//2); and the means of
    the logarithms of these spectra, (ρ,)."""
    shares = _SHARES if best is None else best * _NEARER
    spectra = 1 + shares[:, None] * device.gain
    return shares, 1 / spectra, np.mean(np.log(spectra), axis=1)


@lru_cache(maxsize=64)
def _filter(device: _Device, rho: float) -> ForceNoise:
    return ForceNoise(device.a, _factor(device.a, device.b, rho), rho)


def _score(power: np.ndarray, gain: np.ndarray) -> float:
    """How many standard deviations the slope of the likelihood lies above zero where the force has no noise."""
    return float(gain @ (power / np.mean(power) - 1)) / float(np.linalg.norm(gain))


def _through_the_device(regression: Regression, k: int, n: int) -> _Device:
    fit, record = regression.fit, regression.fit.campaign.fitted[k]
    taps = tuple(float(tap) for tap in regression.whitenings[k].filter)
    return _device(float(fit.values[FREQUENCY]), float(fit.values[QUALITY]), record.step, record.order, taps, n)


@lru_cache(maxsize=64)  # every candidate asks for it
def _device(frequency: float, quality: float, step: float, order: int, taps: tuple[float, ...], n: int) -> _Device:
    b, a = oscillator_filter(frequency, quality, step, order)
    b = np.convolve(b, taps)
    turning = np.exp(-2j * np.pi / n * np.arange(1, n // 2 + 1))
    gain = np.abs(np.polyval(b[::-1], turning) / np.polyval(a[::-1], turning)) ** 2
    size = float(np.mean(gain))
    return _Device(a, b / np.sqrt(size), gain / size, size)


def _factor(a: np.ndarray, b: np.ndarray, rho: float) -> np.ndarray:
    """The polynomial C, C_0 = 1, of which C C* is A A* + ρ B B* but for a factor, its zeros inside the unit circle."""
    if rho == 0.0:
        return a
    long = max(len(a), len(b))
    both = [np.pad(x, (0, long - len(x))) for x in (a, b)]
    product = np.convolve(both[0], both[0][::-1]) + rho * np.convolve(both[1], both[1][::-1])
    zeros = np.roots(np.trim_zeros(product))
    inside = zeros[np.argsort(np.abs(zeros))][: len(zeros) // 2]
    return np.real(np.poly(inside))
