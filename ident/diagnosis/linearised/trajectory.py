"""The trajectory that the stage really took, as far as a record tells: the model's own, corrected by the smoothed
residual.

A missing force is evaluated where the stage was, not where the wrong model puts it. The model's state carries the fast
motion exactly; only the slowly varying misfit needs smoothing, so that velocities stay clean at 3 % noise. Of a model
that stands at the noise floor nothing but noise would be followed: the less a residual stands above it, the less of it
is.

What a sensor adds is evaluated on the model's own motion: if the sensor is what differs, the stage moved as the model
says and the readings are not its path. (The cube of a reading that saturates has no third harmonic left.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import jax
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

from ...campaign.record import Trace
from ...fit import Fit
from ...fit.result import Solved
from ...model import FREQUENCY, GAIN, QUALITY
from ...response import Tape, lay_path
from .columns import Dynamics, Motion, linearised

_SLOWER, _FASTER = 4.0, 6.0  # periods and frequencies of the resonance: what is integrated lies between
_NOISE = 1.5  # residual over noise, squared, up to which a residual may be noise whose floor is not well known


class Diverged(ArithmeticError):
    """A model has no motion on a record, or one without bound: nothing can be compared with it."""


class Path(NamedTuple):
    """Displacement and velocity on the half-step grid of a record, (points,), m and m/s."""

    z: np.ndarray
    v: np.ndarray


@dataclass(frozen=True, eq=False)
class Trajectories:
    """A fit laid out for diagnosis: its arrays, and the trajectories in its fitted records.

    **Arguments:** `residuals`: per record (n,), measured − model, m; `paths`: per record, the corrected trajectory;
    `own`: the model's. The steps of its `tape` are not those of the fit (`lay_path`).
    """

    solved: Solved
    tape: Tape
    paths: tuple[Path, ...]
    own: tuple[Path, ...]
    residuals: tuple[np.ndarray, ...]

    @cached_property
    def histories(self) -> np.ndarray:
        """What the fit says that came before the records: additions to the hidden states of its model, (records, h)."""
        solved = self.solved
        found = solved.found.starts[:, 2:]
        return found if found.shape[1] else np.zeros((len(found), len(solved.static.equation.history_units)))

    @cached_property
    def moved(self) -> tuple[Motion, ...]:
        """The corrected trajectories as programs take them."""
        return _motions(self.tape, self.paths)

    @cached_property
    def seen(self) -> tuple[Motion, ...]:
        """What the sensors read of the model's own."""
        return _motions(self.tape, self.read(self.own))

    @cached_property
    def dynamics(self) -> tuple[Dynamics, ...]:
        """The model linearised along the corrected trajectories."""
        solved = self.solved
        seen = _motions(self.tape, self.read(self.paths))
        return linearised(solved.static.equation, self.tape, solved.found.values, self.moved, seen, self.histories)

    def read(self, paths: Sequence[Path]) -> tuple[Path, ...]:
        """What the sensors read of motions along the records, and its rate: displacement, velocity or acceleration."""
        found, solved = [], self.solved
        model, values = solved.static.equation.model, solved.found.values
        # An accelerometer that rides on a body feels the acceleration of its base too.
        base = float(values[GAIN]) * model.linear.force_per_gain / model.linear.mass if model.form == "shaken" else 0.0
        for path, lane in zip(paths, self.tape.lanes, strict=True):
            if lane.order:
                at = 0.5 * lane.step * np.arange(len(path.v))
                speed, order = make_interp_spline(at, path.v, k=5), int(lane.order)
                path = Path(speed(at, order - 1) + base * lane.voltage, speed(at, order) + base * lane.rate)
            found.append(path)
        return tuple(found)


def _motions(tape: Tape, paths: tuple[Path, ...]) -> tuple[Motion, ...]:
    both = (tape.windows([path[k] for path in paths]) for k in range(2))
    return tuple(Motion(*jax.device_put(pair)) for pair in zip(*both, strict=True))


def lay_out(fit: Fit) -> Trajectories:
    """The trajectories of a fit: its model's states, corrected by the smoothed residual of each record.

    **Raises:** Diverged if the model's motion has no bound.
    """
    solved, paths, own, residuals = fit.solved, [], [], []
    response = solved.found.response
    fastest = max(1.0 / fit.scales.period, float(fit.values[FREQUENCY]))
    tape = lay_path(fit.campaign.fitted, fastest, float(fit.values[QUALITY]), fit.model, solved.data.tape)
    for record, part, span, lane in zip(fit.campaign.fitted, tape.slices, tape.spans, tape.lanes, strict=True):
        residual = record.across(record.response - response.readings[part])
        if not np.all(np.isfinite(residual)):
            raise Diverged(record.name)
        z, v = response.z[part], response.v[part]
        rolls = fit.model.form == "no-spring"
        correction, rate = _trusted(residual, record) * _moved(residual, record, fit.scales.period, rolls)
        inside = np.minimum(record.time[0] + 0.5 * lane.step * np.arange(span.points), record.time[-1])
        for found, at in ((paths, (z + correction, v + rate)), (own, (z, v))):
            spline = CubicHermiteSpline(record.time, *at)
            found.append(Path(spline(inside), spline(inside, 1)))
        residuals.append(residual)
    return Trajectories(solved, tape, tuple(paths), tuple(own), tuple(residuals))


def _trusted(residual: np.ndarray, record: Trace) -> float:
    """Share of a residual that is followed."""
    excess = float(np.mean(residual[record.skip :] ** 2)) / record.noise.sigma**2
    noise = _NOISE * (1.0 + 2.0 * record.noise.relative_error) ** 2
    return max(0.0, 1.0 - (noise / excess) ** 2)


def _moved(residual: np.ndarray, record: Trace, period: float, rolls: bool) -> np.ndarray:
    """Displacement and velocity, (2, n), that a residual means: itself and its rate, smoothed, or what it is integrated
    from, without what is slower than a few periods of the resonance. What `rolls` without a spring may go on as slowly
    as it likes, and its velocity, if that was read, is known as it was read, the sensor's zero too."""
    if not record.order:
        return _smooth(residual, record.step, period)
    if rolls and record.order == 1:
        rate = _smooth(residual, record.step, period)[0]
        return np.array([cumulative_simpson(rate, dx=record.step, initial=0.0), rate])
    omega = 2 * np.pi * np.fft.rfftfreq(len(residual), record.step)
    slowest = 2 * np.pi / (_SLOWER * period)
    kept = np.where(omega > 0, omega**4 / (omega**4 + slowest**4), 0.0) * (omega < _FASTER * 2 * np.pi / period)
    seen = np.fft.rfft(residual - np.mean(residual)) * kept
    turned = 1j * np.where(omega > 0, omega, 1.0)
    return np.array([np.fft.irfft(seen / turned**k, len(residual)) for k in (record.order, record.order - 1)])


def _smooth(residual: np.ndarray, step: float, period: float) -> np.ndarray:
    """Residual and its rate, (2, n), smoothed over about a sixth of the resonance's period by local cubics.

    Source: A. Savitzky, M. J. E. Golay, 1964, Analytical Chemistry 36, 1627, doi:10.1021/ac60214a047.
    """
    window = max(int(period / step / 6) // 2 * 2 + 1, 5)
    if len(residual) <= window:
        return np.zeros((2, len(residual)))
    half = window // 2
    at = np.arange(-half, half + 1)
    cubics = np.linalg.pinv(np.vander(at, 4, increasing=True)) @ sliding_window_view(residual, window).T
    ends = np.vander(at, 4, increasing=True)  # what the first and the last cubic say of the ends
    value = np.concatenate([ends[:half] @ cubics[:, 0], cubics[0], ends[half + 1 :] @ cubics[:, -1]])
    slopes = np.vander(at, 3, increasing=True) * [1, 2, 3]
    rate = np.concatenate([slopes[:half] @ cubics[1:, 0], cubics[1], slopes[half + 1 :] @ cubics[1:, -1]])
    return np.array([value, rate / step])
