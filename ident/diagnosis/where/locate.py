"""Where a model fails: the residual in noise floors by record, time, phase, motion, level, harmonic and frequency.

Everything is counted on residuals whitened by the colour of each record's own noise floor, so that coloured noise is no
misfit. A part of the records is named only if noise does not reach so high there and it is distinctly worse than the
rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...campaign.device import drive_unit
from ...campaign.drive import drive_frequency
from ...campaign.record import Sweep, same_level
from ...fit import Fit
from ...model import QUALITY
from ..linearised.regression import Regression
from .views import View, chance_of, from_sums, view
from .whiteness import Correlation, drive_correlation, whiteness

ALARMS = 0.001  # probability with which noise alone would be called a misfit, per question asked


class RecordView(NamedTuple):
    """One record: error ÷ noise floor of its white residual, χ² above noise, its probability by chance, and where it
    was driven.

    **Arguments:** `error`: error ÷ noise floor as its fit says it; `level` and `travel`: largest |drive| and
    |response|, in the units in which a fit keeps them; `frequency`: of the drive, Hz.
    """

    name: str
    holdout: bool
    ratio: float
    error: float
    excess: float
    p_value: float
    level: float
    travel: float
    frequency: float


class Where(NamedTuple):
    """Where a model fails.

    **Arguments:**

    - `records`: fitted ones first, then held-out ones; `misfit`: χ² above noise of the fitted ones; `p_value`: by
      chance.
    - `time`, `phase`, `displacement`, `velocity`, `spectrum`: pooled over the fitted records; `harmonics`: of the
      drive, 0 is the constant part, and alone where no record is periodic; `phase` is then None. Of sweeps both are.
    - Of curves alone `time` is the frequency, Hz, `displacement` the amplitude, and `velocity` how far from the largest
      amplitude of its level a point lies, in half-power widths.
    - `error`: error ÷ noise floor of the fitted records as their fit says it, and `excerpts`, whether only excerpts of
      them were looked at.
    - `drive_unit`: of the levels of records.
    - `whiteness`: autocorrelation of the residual; `drive`: its cross-correlation with the drive, if there is one.
    """

    records: tuple[RecordView, ...]
    misfit: float
    p_value: float
    time: View
    phase: View | None
    displacement: View
    velocity: View
    harmonics: View | None
    spectrum: View
    whiteness: Correlation
    drive: Correlation | None
    resonance: float
    error: float
    drive_unit: str
    excerpts: bool = False

    @property
    def white_error(self) -> float:
        """Error ÷ noise floor of the white residual of the fitted records, of which all that follows is counted."""
        return float(np.sqrt(np.mean([r.ratio**2 for r in self.records if not r.holdout])))

    @property
    def fails(self) -> bool:
        """Whether anything beyond noise is left at all."""
        drive = 1.0 if self.drive is None else self.drive.p_value
        return min(self.p_value, self.whiteness.p_value, drive) < ALARMS

    @property
    def of_curves(self) -> bool:
        """Whether only curves were fitted."""
        return self.harmonics is None


_BINS = 12  # of time, motion and phase
_HARMONICS = 8  # of the drive
_FLANKS = 4.0  # half-power widths from the peak, beyond which a curve is its flank
_LAGS = np.arange(-16, 49) / 16  # of the resonance's period
_BANDS = np.concatenate([np.arange(0.0, 1.5, 0.1), [1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0]])


class _Samples(NamedTuple):
    """Counted samples of one record: white residual and where each was taken, all (n,).

    **Arguments:** `known`: false where a sample says nothing, and `white` is zero; `time`: 0 to 1 of the record; `z`,
    `v`: −1 to 1 of their largest; `phase`: of the drive, 0 to 360°, and `turns`, its periods since the first sample;
    None if the drive is not periodic; `frequency`: of the drive at each point of a sweep, whose `step` is 0.
    """

    white: np.ndarray
    known: np.ndarray
    time: np.ndarray
    z: np.ndarray
    v: np.ndarray
    phase: np.ndarray | None
    turns: np.ndarray | None
    step: float
    frequency: np.ndarray | None = None


def locate(regression: Regression, whole: Fit | None = None) -> Where:
    """Look at the residual of a fit along every axis.

    **Arguments:** `whole`: the fit to all samples, where the regression is of excerpts; its errors are the ones told.

    Source: L. Ljung, System Identification: Theory for the User, 1999, §16.6 (residual analysis).
    """
    records = (*regression.fit.campaign.fitted, *regression.fit.campaign.fitted_sweeps)
    samples = _all_samples(regression)
    floor_error = float(np.sqrt(np.mean([r.noise.relative_error**2 for r in records])))
    squares = np.concatenate([s.white[s.known] for s in samples]) ** 2

    def pooled(axis: str, field: str, low: float, high: float) -> View:
        place = np.concatenate([getattr(s, field)[s.known] for s in samples])
        return view(axis, place, np.linspace(low, high, _BINS + 1), squares, floor_error)

    def axes() -> tuple[View, View, View]:
        if regression.fit.campaign.fitted:
            return (pooled("part of the record", "time", 0, 1), pooled("displacement ÷ its largest", "z", -1, 1),
                    pooled("velocity ÷ its largest", "v", -1, 1))  # fmt: skip
        band = np.concatenate([s.frequency for s in samples if s.frequency is not None])
        return (pooled("frequency (Hz)", "frequency", float(np.min(band)), float(np.max(band))),
                pooled("amplitude ÷ its largest", "z", 0, 1),
                pooled("half-power widths", "v", -_FLANKS, _FLANKS))  # fmt: skip

    resonance = 1.0 / regression.fit.scales.period
    time, displacement, velocity = axes()
    freedom = float(regression.n - regression.absorbed.shape[1])
    white = [s.white for s in samples]
    said = regression.fit if whole is None else whole
    return Where(
        _by_record(regression, samples, {score.name: score.error_over_noise for score in said.scores}),
        regression.chi2 - freedom,
        chance_of(regression.chi2, freedom, floor_error),
        time,
        _by_phase(samples, floor_error),
        displacement,
        velocity,
        _by_harmonic(samples, resonance, float(regression.fit.values[QUALITY])),
        _by_frequency(samples, resonance, floor_error),
        whiteness(white, [len(r.noise.ar) for r in records]),
        drive_correlation(
            [s.white for s in samples if s.step],
            [r.drive[r.skip :] for r in regression.fit.campaign.fitted],
            [r.step for r in regression.fit.campaign.fitted],
            _LAGS / resonance,
        ),
        resonance,
        said.fitted.error_over_noise,
        drive_unit(said.campaign.device),
        said is not regression.fit and any(r.excerpt for r in regression.fit.campaign.fitted),
    )


def _all_samples(regression: Regression) -> list[_Samples]:
    trajectories, found = regression.trajectories, []
    places = regression.places[: len(trajectories.paths)]
    for record, span, path, own in zip(
        regression.fit.campaign.fitted, trajectories.tape.spans, trajectories.paths, places, strict=True
    ):
        n, stride = span.samples, 2 * span.substeps
        z, v = (x[stride * record.skip :: stride] for x in path)
        z = z - np.mean(z)
        turns = None if record.period is None else np.arange(record.skip, n) / float(record.period)
        found.append(
            _Samples(
                regression.residual[own],
                record.counted[record.skip :],
                np.arange(n - record.skip) / (n - record.skip),
                z / (float(np.max(np.abs(z))) or 1.0),
                v / (float(np.max(np.abs(v))) or 1.0),
                None if turns is None else _phase(record.drive[record.skip :], turns),
                turns,
                record.step,
            )
        )
    return found + _all_points(regression)


def _all_points(regression: Regression) -> list[_Samples]:
    """The numbers of each sweep that count: its amplitudes, then its phases; of those that were run fast first."""
    found = _all_passed(regression)
    if regression.plane is None:
        return found
    curves = regression.plane.curves
    places = regression.places[len(regression.places) - len(curves.sweeps) :]
    for sweep, own, points in zip(curves.sweeps, places, curves.slices, strict=True):
        count, many = own.stop - own.start, (own.stop - own.start) // (points.stop - points.start)
        twice = lambda x, many=many: np.tile(x, many)
        frequency, amplitude = curves.points.frequency[points], curves.measured[points]
        speed = amplitude * frequency
        aside = (
            speed / np.max(speed)
            if regression.fit.campaign.fitted
            else _from_peak(regression, frequency, curves.points.level[points], amplitude)
        )
        found.append(
            _Samples(
                regression.residual[own],
                np.ones(count, dtype=bool),
                np.linspace(0, 1, count, endpoint=False),
                twice(amplitude / np.max(sweep.amplitude)),
                twice(aside),
                None,
                None,
                0.0,
                twice(frequency),
            )
        )
    return found


def _all_passed(regression: Regression) -> list[_Samples]:
    """The same of the sweeps that were run fast."""
    passes, found = regression.passes, []
    for k, sweep in enumerate(() if passes is None else passes.sweeps):
        own = regression.places[len(regression.trajectories.paths) + k]
        count, many = own.stop - own.start, 1 + (sweep.phase is not None)
        speed = sweep.amplitude * sweep.frequency
        aside = speed / np.max(speed)
        if not regression.fit.campaign.fitted:
            aside = _from_peak(regression, sweep.frequency, sweep.level, sweep.amplitude)
        found.append(
            _Samples(
                regression.residual[own], np.ones(count, bool), np.linspace(0, 1, count, endpoint=False),
                np.tile(sweep.amplitude / np.max(sweep.amplitude), many), np.tile(aside, many), None, None, 0.0,
                np.tile(sweep.frequency, many),
            )
        )  # fmt: skip
    return found


def _from_peak(regression: Regression, frequency: np.ndarray, level: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """How far points of curves lie above the largest amplitude of their level, in half-power widths."""
    found = np.zeros(len(frequency))
    for rows in same_level(level):
        top = frequency[rows][np.argmax(amplitude[rows])]
        found[rows] = (frequency[rows] - top) / top * float(regression.fit.values[QUALITY])
    return found


def _phase(drive: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Phase of each sample, degrees, in V = V₁ sin(phase): the drive rises through its mean at 0."""
    fundamental = np.sum((drive - np.mean(drive)) * np.exp(-2j * np.pi * turns))
    return np.degrees(2 * np.pi * turns + np.angle(1j * fundamental)) % 360


def _by_record(regression: Regression, samples: list[_Samples], errors: Mapping[str, float]) -> tuple[RecordView, ...]:
    """Error ÷ noise floor of every record; fitted ones are judged on the white residual. `errors`: as a fit says
    them."""
    white = iter(s.white[s.known] for s in samples)
    found = []
    settled = lambda record: isinstance(record, Sweep) and not record.fast
    place = lambda pair: (isinstance(pair[0], Sweep), settled(pair[0]))
    # The traces first, then what was run fast, as on the regression.
    pairs = sorted(zip(regression.fit.campaign.records, regression.fit.scores, strict=True), key=place)
    for record, scored in pairs:
        if record.holdout:
            n, chi2 = scored.n, scored.n * scored.error_over_noise**2
        else:
            own = next(white)
            n, chi2 = len(own), float(own @ own)
        ratio = float(np.sqrt(chi2 / n))
        p = chance_of(chi2, n, record.noise.relative_error)
        error = errors.get(record.name, scored.error_over_noise)
        if isinstance(record, Sweep):
            top = int(np.argmax(record.amplitude))
            at = float(record.level[top]), float(record.amplitude[top]), float(record.frequency[top])
            found.append(RecordView(record.name, record.holdout, ratio, error, chi2 - n, p, *at))
            continue
        level, travel = (float(np.max(np.abs(x[record.skip :]))) for x in (record.drive, record.response))
        frequency = drive_frequency(record) / (2 * np.pi)
        found.append(RecordView(record.name, record.holdout, ratio, error, chi2 - n, p, level, travel, frequency))
    return tuple(sorted(found, key=lambda r: r.holdout))


def _by_phase(samples: list[_Samples], floor_error: float) -> View | None:
    periodic = [(s.phase[s.known], s.white[s.known]) for s in samples if s.phase is not None]
    if not periodic:
        return None
    phase, white = (np.concatenate(part) for part in zip(*periodic, strict=True))
    return view("phase of the drive (°)", phase, np.linspace(0, 360, _BINS + 1), white**2, floor_error)


def _by_harmonic(samples: list[_Samples], resonance: float, quality: float) -> View | None:
    """χ² that each harmonic of the drive explains of the residual, two degrees of freedom a record (constant: one, and
    all that a record has whose drive does not repeat).

    Free ringing at the resonance is taken out first: in a record driven at half the resonance it would pass for the
    second harmonic.
    """
    traces = [s for s in samples if s.step]
    if not traces:
        return None
    periodic = [None if s.turns is None or s.turns[-1] - s.turns[0] < 2 else s.turns for s in traces]
    count = 1 if all(turns is None for turns in periodic) else _HARMONICS
    total, freedom = np.zeros(count), np.zeros(count)
    for s, turns in zip(traces, periodic, strict=True):
        t = resonance * s.step * np.arange(len(s.white))
        decay = np.exp((2j * np.pi - np.pi / quality) * t)
        ringing = [part * slow for slow in (1.0, t / (t[-1] or 1.0)) for part in (np.real(decay), np.imag(decay))]
        basis, _ = np.linalg.qr(np.stack(ringing).T)
        without = lambda x, basis=basis: x - (x @ basis) @ basis.T
        left = without(s.white)
        for k in range(1 if turns is None else _HARMONICS):
            angle = np.zeros(len(left)) if turns is None else 2 * np.pi * k * turns
            rows = without(np.stack([np.cos(angle), np.sin(angle)])[: 2 if k else 1])
            along = rows @ left
            total[k] += float(along @ np.linalg.lstsq(rows @ rows.T, along, rcond=None)[0])
            freedom[k] += len(rows)
    return from_sums("harmonic of the drive", np.arange(count + 1) - 0.5, total, freedom, 0.0)


def _by_frequency(samples: list[_Samples], resonance: float, floor_error: float) -> View:
    """Power spectrum of the white residual in bands of the resonance frequency; a periodogram ordinate counts twice."""
    place, power = [], []
    for s in samples:
        n = len(s.white)
        if s.frequency is not None:  # of a sweep every point is a frequency
            power.append(s.white**2)
            place.append(s.frequency / resonance)
            continue
        power.append(np.abs(np.fft.rfft(s.white)[1:]) ** 2 / n)
        place.append(np.fft.rfftfreq(n, s.step)[1:] / resonance)
    where, mean = np.concatenate(place), np.concatenate(power)
    edges = _BANDS[: int(np.searchsorted(_BANDS, float(np.max(where)))) + 1]
    inside = where < edges[-1]
    number = np.searchsorted(edges, where[inside], side="right") - 1
    total = np.bincount(number, weights=2 * mean[inside], minlength=len(edges) - 1)
    count = 2.0 * np.bincount(number, minlength=len(edges) - 1)
    return from_sums("frequency ÷ resonance", edges, total, count, floor_error)
