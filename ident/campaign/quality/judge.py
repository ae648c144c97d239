"""What can be said of a time record before any model: its drive, its sampling, its noise, its start."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..drive import drive_frequency
from ..period import fourier_basis, least_squares
from ..record import NoiseFloor, Trace


@dataclass(frozen=True)
class Judgement:
    """One record, judged alone (SI units).

    **Arguments:**

    - `samples`, `duration` (s), `rate` (Hz): how much was recorded.
    - `frequency`: of the drive, Hz, rms(V̇)/rms(V)/2π; `periods`: of the drive in the record, or None.
    - `amplitude`: half the peak-to-peak drive, V; `distortion`: rms of the drive's harmonics over its fundamental
      (for a drive that has one fundamental), else None.
    - `samples_per_period`; `clipped`: share of the response that stuck to its limits as it was
      recorded, before aliases were filtered out of it; 0 where only a few samples did.
    - `drift`: change of the mean response over the record, m; `size`: rms of the response, m.
    - `noise`: the noise floor, with its method and relative error.
    - `start_fits`: whether the data agree with the start that is claimed (None: nothing to test); `remarks`: in words.
    """

    name: str
    samples: int
    duration: float
    rate: float
    frequency: float
    periods: float | None
    amplitude: float
    distortion: float | None
    samples_per_period: float
    clipped: float
    drift: float
    size: float
    noise: NoiseFloor
    start_fits: bool | None
    remarks: tuple[str, ...]


@lru_cache(maxsize=256)  # asked for by every part of a check
def judge(record: Trace) -> Judgement:
    """Judges a time record by its data alone."""
    n = len(record.time)
    rate = 1.0 / record.step
    frequency = drive_frequency(record) / (2 * math.pi)
    size = float(np.std(record.response))
    fits, words = _start(record)
    drift = _slow_change(record.response)
    distortion = _distortion(record)
    remarks = [words] if words else []
    if drifts(record, drift, size):
        remarks.append(f"the mean response drifts by {abs(drift) / size:.0%} of its rms: sensor, temperature or load?")
    if distortion is not None and distortion > 0.02:
        remarks.append(f"the drive is not a pure sine: its harmonics are {distortion:.1%} of its fundamental")
    if record.outliers:
        count = len(record.outliers)
        remarks.append(f"{count} outlier{'s' if count > 1 else ''}, replaced by what the neighbours say")
    if record.noise.relative_error > 0.25:
        remarks.append("the noise floor is uncertain: give it in the campaign if it is known")
    if size < 3 * record.noise.sigma:
        remarks.append("there is hardly any response above the noise")
    return Judgement(
        name=record.name,
        samples=n,
        duration=record.step * (n - 1),
        rate=rate,
        frequency=frequency,
        periods=None if record.period is None else n / record.period,
        amplitude=float(np.ptp(record.drive)) / 2,
        distortion=distortion,
        samples_per_period=rate / frequency if frequency > 0 else math.inf,
        clipped=record.stuck,
        drift=drift,
        size=size,
        noise=record.noise,
        start_fits=fits,
        remarks=tuple(remarks),
    )


def _distortion(record: Trace) -> float | None:
    """rms of harmonics 2…10 over the fundamental, if the fundamental dominates."""
    period = record.period
    if period is None or period < 3:
        return None
    count = min(10, int(period / 2 - 0.5))
    if count < 2 or len(record.drive) < 4 * count:
        return None
    weights = least_squares(fourier_basis(len(record.drive), period, count), record.drive)
    power = weights[1::2] ** 2 + weights[2::2] ** 2
    if power[0] < 0.5 * float(np.var(record.drive)):
        return None
    return math.sqrt(float(np.sum(power[1:])) / float(power[0]))


def _slow_change(signal: np.ndarray) -> float:
    """Change of the mean over a record, as if it were a ramp: twice the difference of the means of its halves.

    The means are taken under a Hann window, which lets a thousandth of a vibration of four cycles pass, so that neither
    the start-up transient nor an unfinished cycle is taken for a change.

    Source: F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978) 51, §V.
    """
    half = len(signal) // 2
    window = np.hanning(half + 2)[1:-1]
    window = window / np.sum(window)
    return 2.0 * float(window @ signal[-half:] - window @ signal[:half])


def _whole_quarter(record: Trace) -> int:
    quarter = max(len(record.time) // 4, 1)
    if record.period is None or record.period > quarter:
        return quarter
    return max(1, round(int(quarter / record.period) * record.period))


_DRIFT = 0.1  # of the rms response: rectified transients of the clean campaigns in data/ reach half of it


def drifts(record: Trace, drift: float, size: float) -> bool:
    """Whether the mean moves by more than noise, the drive's own mean, and what the vibration's size explains."""
    noise = 12.0 * record.noise.sigma * math.sqrt(_longest_memory(record.noise) / len(record.response))
    spread = float(np.std(record.drive))
    driven = 0.0 if spread == 0.0 else 3.0 * size * abs(_slow_change(record.drive)) / spread
    return abs(drift) > max(noise, _DRIFT * size) + driven and not _rectified(record.response)


def _rectified(signal: np.ndarray) -> bool:
    """Whether the mean follows the square of the vibration better than time, as a spring or a sensor with a quadratic
    part makes it: over quarters of the record a + b·(local mean square) leaves less than a + b·t.

    z̈ + ω²z + a z² = 0 has the mean −a A²/2ω², and its well ends at z = −ω²/a: half of the way there the mean is a
    quarter of the amplitude, which bounds b. Source: A. H. Nayfeh, D. T. Mook, "Nonlinear Oscillations" (1979), §2.3.
    `experiments.faulty_records.drifts` (seeds 740–769): 2 of 900 sound records are said to drift, one of them by creep,
    and all 90 ramps are.
    """
    length = max(len(signal) // 4, 1)
    window = np.hanning(length + 2)[1:-1] / np.sum(np.hanning(length + 2))
    parts = [signal[k : k + length] for k in range(0, len(signal) - length + 1, max(length // 3, 1))]
    mean = np.array([window @ part for part in parts])
    power = np.array([window @ (part - m) ** 2 for part, m in zip(parts, mean, strict=True)])

    def left(by: np.ndarray, most: float) -> float:
        x, y = by - np.mean(by), mean - np.mean(mean)
        slope = float(np.clip(x @ y / max(float(x @ x), 1e-300), -most, most))
        return float(np.sum((y - slope * x) ** 2))

    amplitude = math.sqrt(2.0 * float(np.max(power)))
    return left(power, 0.5 / max(amplitude, 1e-300)) < left(np.arange(len(mean), dtype=float), math.inf)


def _longest_memory(noise: NoiseFloor) -> float:
    """Samples of coloured noise that count as one, at the lowest frequencies."""
    return min(1.0 / max(1.0 - sum(noise.ar), 1e-2) ** 2, 1e4)


def _start(record: Trace) -> tuple[bool | None, str]:
    """Whether the claimed start agrees with the data, and a sentence if it does not."""
    response, sigma = record.response, record.noise.sigma
    size = float(np.max(np.abs(response - np.mean(response))))
    if record.start == "rest":
        first = float(np.mean(response[:2]))
        if abs(first) > 5 * sigma + 0.05 * size:
            return False, 'start = "rest", but the response does not begin at zero'
        typical = float(np.sqrt(np.mean(np.diff(response) ** 2)))
        slope = float(np.mean(np.diff(response[:3])))
        if abs(slope) > 4 * sigma + 0.7 * typical:
            return False, 'start = "rest", but the response is moving at the first sample'
        return True, ""
    if record.start == "steady":
        if record.period is None:
            return False, 'start = "steady", but the drive is not periodic'
        quarter = _whole_quarter(record)
        early, late = (float(np.std(part)) for part in (response[:quarter], response[-quarter:]))
        allowed = 0.03 * late + 4 * sigma / math.sqrt(quarter)
        if abs(early - late) > allowed:
            return False, 'start = "steady", but the amplitude of the response still changes'
        return True, ""
    return None, ""
