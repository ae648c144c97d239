"""What the lab measured, as frozen values in SI units.

A record is one file: a trace (time, drive, response) or a sweep (frequency, level, amplitude). Numbers are SI inside;
`Channel.factor` turns them back into the unit in which the file was written.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

LEAST = 20
"""Samples of a trace, counted ones too."""

Start = Literal["rest", "steady", "unknown"]
Measures = Literal["displacement", "velocity", "acceleration"]
Between = Literal["auto", "smooth", "hold"]
Kind = Literal["stiffness", "damping", "sensitivity", "delay", "clock", "level", "baseline"]
"""Of numbers by which a record differs from the others; `apart.TOLD` says what they are."""
MEASURES: tuple[Measures, ...] = ("displacement", "velocity", "acceleration")
"""What a sensor reads, in the order of the derivatives of the displacement."""


@dataclass(frozen=True)
class Channel:
    """The unit of a column: value in SI = value in the file × `factor`."""

    unit: str
    factor: float


VAGUE = 0.3
"""Relative error of a noise floor from which it cannot judge a model: what is said of it then is that it is a bound."""


@dataclass(frozen=True)
class NoiseFloor:
    """Standard deviation and colour of the measurement noise of one record.

    The noise is modelled as autoregressive: e[k] = Σ_j ar[j] e[k−1−j] + white noise. `ar = ()` is white noise.

    **Arguments:**

    - `sigma`: total standard deviation of the noise (SI).
    - `ar`: autoregressive coefficients.
    - `method`: how it was found, in words ("given in the campaign", "repeats of 12 periods", …).
    - `relative_error`: standard error of `sigma` divided by `sigma`; 0 where the user gave it.
    - `unseen`: share of the frequencies, from zero on, at which it was not seen: there it is extrapolated.
    - `lines`: what of it stands at single frequencies, and was added to the rest (`noise.hum`).
    - `heard`: Hz of each of these lines, nominal and while the record was taken.
    """

    sigma: float
    ar: tuple[float, ...] = ()
    method: str = ""
    relative_error: float = 0.0
    unseen: float = 0.0
    lines: tuple[str, ...] = field(default=(), repr=False)  # keys of chains were made without (`posterior.result`)
    heard: tuple[tuple[float, float], ...] = field(default=(), repr=False)  # and without


@dataclass(frozen=True, eq=False)
class Trace:
    """A time record, uniformly sampled.

    **Arguments:**

    - `name`: the file as the campaign names it.
    - `time`: (n,) s, uniform; `drive`: (n,) V; `response`: (n,) m (an oscillator's columns: their own
      SI-prefixed-free unit).
    - `start`: "rest" (z = ż = 0 at the first sample), "steady", or "unknown" (initial state is fitted).
    - `load`: extra mass on the stage, kg.
    - `skip`: number of leading samples that are simulated but not counted.
    - `noise`: the noise floor; `period`: samples per period if the drive is periodic over the record, else None.
    - `outliers`: samples of the file that left the curve; in `response` the curve takes their place.
    - `masked`: (n,) whether a sample says nothing, as where the response sticks to the limit of a range; none if None.
    - `own`: None, or the kind of numbers by which it differs from the others, and these (see `apart`).
    - `floats`: whether a zero of its own is fitted with every model, beside the one by which it is read.
    - `stuck`: share of the samples that stick to a limit; others that say nothing are missing.
    - `measures`: what the response is; m stands for m/s or m/s² where it is no displacement.
    - `between`: what the campaign says of the drive between its samples; `edge`: None if it is a smooth curve, else it
      is held, and the value of a sample begins so many sampling intervals after it.
    - `excerpt`: a stretch of a longer record, cut out to compare models on it, which begins so many s `into` that; no
      estimate is reported from it. `begun`: the `start` of the whole record.
    """

    name: str
    time: np.ndarray
    drive: np.ndarray
    response: np.ndarray
    drive_channel: Channel
    response_channel: Channel
    noise: NoiseFloor
    start: Start = "unknown"
    holdout: bool = False
    load: float = 0.0
    skip: int = 0
    period: float | None = None
    excerpt: bool = False
    into: float = 0.0
    begun: Start | None = None
    outliers: tuple[int, ...] = ()
    measures: Measures = "displacement"
    masked: np.ndarray | None = None
    stuck: float = 0.0
    own: tuple[Kind, tuple[float, ...]] | None = None
    floats: bool = False
    between: Between = "auto"
    edge: float | None = None

    @property
    def differs(self) -> bool:
        """Whether it is known to differ from the others."""
        return self.own is not None

    def number(self, kind: Kind) -> float:
        """The first of its own numbers, where they are of that kind; else 0."""
        return self.own[1][0] if self.own is not None and self.own[0] == kind else 0.0

    @property
    def stiffer(self) -> float:
        """Share by which the device's own spring is stiffer in it than in the others."""
        return self.number("stiffness")

    @property
    def damped(self) -> float:
        """Share by which the device's own damper is stronger in it than in the others."""
        return self.number("damping")

    @property
    def counted(self) -> np.ndarray:
        """(n,) whether a sample counts in a fit."""
        late = np.arange(len(self.time)) >= self.skip
        return late if self.masked is None else late & ~self.masked

    def across(self, signal: np.ndarray) -> np.ndarray:
        """A signal (n,) with a straight line through its neighbours in place of masked samples."""
        if self.masked is None or np.all(self.masked):
            return signal
        index = np.arange(len(signal))
        return np.interp(index, index[~self.masked], signal[~self.masked])

    @property
    def order(self) -> int:
        """Which derivative of the displacement was measured."""
        return MEASURES.index(self.measures)

    @property
    def step(self) -> float:
        """Sampling interval, s."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))

    @property
    def driven(self) -> bool:
        """Whether the drive changes within the record; if not, it is a free decay."""
        return bool(np.ptp(self.drive) > 0)

    @property
    def begins_in_motion(self) -> bool:
        """Whether the drive had been on before the first sample, that of the whole record if this is a part of one."""
        return (self.begun or self.start) != "rest"


@dataclass(frozen=True)
class Run:
    """One pass of a sweep over the frequencies, at one drive level (median, V) and in one direction.

    `rows`: (k,) the points of the record in the order in which they were passed.
    """

    level: float
    up: bool
    rows: np.ndarray

    @property
    def rising(self) -> np.ndarray:
        """(k,) its points in the order of rising frequency."""
        return self.rows if self.up else self.rows[::-1]

    def is_back_of(self, other: Run) -> bool:
        """Whether it passes the level of another the other way."""
        return self.up != other.up and abs(self.level / other.level - 1) < SAME_LEVEL - 1


class Overtone(NamedTuple):
    """A harmonic of a sweep: its `order`, and (n,) its `amplitude`, m, and the standard deviation of the `noise` of its
    real part, m."""

    order: int
    amplitude: np.ndarray
    noise: np.ndarray

    def only(self, rows: np.ndarray) -> Overtone:
        """Some of the points."""
        return Overtone(self.order, self.amplitude[rows], self.noise[rows])


@dataclass(frozen=True, eq=False)
class Sweep:
    """An amplitude-frequency curve; rows stand as in the file, `runs` orders them.

    **Arguments:**

    - `frequency`: (n,) Hz; `level`: (n,) drive amplitude (peak of the sine), V; `amplitude`: (n,) amplitude of the
      response (half its peak-to-peak value for the quantity "half-peak-to-peak"), m.
    - `phase`: (n,) rad by which the response leads the drive, z = a sin(ωt + φ) for V = V0 sin ωt, unwrapped along each
      run up to a multiple of 2π; or None.
    - `up`: (n,) bool, whether the frequency was rising.
    - `dwell`: (n,) s between the previous point of the run and this one, where table or campaign tell; `swept`: whether
      the frequency glided from one to the next, instead of being held for that time; `averaging`: s over which the
      instrument averaged before it read a point, at least a period. `fast`: whether points had not settled, so that
      the sweep is simulated as it was run.
    - `overtones`: the harmonics that were measured too, of a settled response.
    - `noise`: its `sigma` is the part of the amplitude noise that is the same at every point.
    - `relative_noise`: the part that grows with the amplitude, a fraction of it.
    - `phase_noise`: rad, what the phase scatters beyond sigma/amplitude.
    - `own_noise`: (3, n) these three at each point, where levels differ in them (a range of the instrument for each);
      None: they are the same at all.
    - `stronger`: (n,) share by which the drive that acted is larger than the one that the table tells, where levels
      differ in that; None: it is as told.
    """

    name: str
    frequency: np.ndarray
    level: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray | None
    up: np.ndarray
    quantity: Literal["fundamental", "half-peak-to-peak"]
    drive_channel: Channel
    response_channel: Channel
    noise: NoiseFloor
    holdout: bool = False
    load: float = 0.0
    dwell: np.ndarray | None = None
    relative_noise: float = 0.0
    phase_noise: float = 0.0
    own_noise: np.ndarray | None = None
    stronger: np.ndarray | None = None
    swept: bool = False
    averaging: float = 0.0
    fast: bool = False
    overtones: tuple[Overtone, ...] = ()

    @property
    def differs(self) -> bool:
        """Whether its levels are known to differ in their drives."""
        return self.stronger is not None

    @property
    def acting(self) -> np.ndarray:
        """(n,) drive amplitude that acted, V."""
        return self.level if self.stronger is None else self.level * (1 + self.stronger)

    @property
    def deviation(self) -> np.ndarray:
        """(n,) standard deviation of the amplitudes, m: √(σ² + (r a)²)."""
        constant, relative, _ = self.noises
        return np.hypot(constant, relative * self.amplitude)

    @property
    def phase_deviation(self) -> np.ndarray:
        """(n,) standard deviation of the phases, rad: √((σ/a)² + σ_φ²), at most that of a phase nobody knows."""
        smallest = np.maximum(self.amplitude, 1e-300)
        constant, _, phase = self.noises
        return np.minimum(np.hypot(constant / smallest, phase), np.pi / np.sqrt(3.0))

    @property
    def noises(self) -> np.ndarray:
        """(3, n) constant (m), relative, and phase noise (rad) of each point."""
        if self.own_noise is not None:
            return self.own_noise
        same = np.array([self.noise.sigma, self.relative_noise, self.phase_noise])
        return np.repeat(same[:, None], len(self.frequency), axis=1)

    def turns_read(self, frequency: float) -> int:
        """Whole turns of a drive of a frequency, Hz, over which a point is read, one at the least."""
        return max(int(self.averaging * frequency + 1e-9), 1)  # 0.29 s at 100 Hz are 29, whatever their product

    def only(self, rows: np.ndarray) -> Sweep:
        """Some of the points, in the order given."""
        names = ("frequency", "level", "amplitude", "up", "phase", "dwell", "stronger", "own_noise")
        some = {name: value[..., rows] for name in names if (value := getattr(self, name)) is not None}
        return replace(self, **some, overtones=tuple(one.only(rows) for one in self.overtones))

    @property
    def runs(self) -> tuple[Run, ...]:
        """The passes over the frequencies, weakest level first, up before down."""
        found = []
        for rows in same_level(self.level):
            for up in (True, False):
                here = rows[self.up[rows] == up]
                if len(here):
                    order = np.argsort(self.frequency[here] if up else -self.frequency[here], kind="stable")
                    found.append(Run(float(np.median(self.level[here])), up, here[order]))
        return tuple(found)


SAME_LEVEL = 1.05
"""Ratio of neighbouring drive levels up to which they count as one: a monitored level sags by that at resonance."""


def same_level(level: np.ndarray) -> tuple[np.ndarray, ...]:
    """The rows of each drive level, weakest first, in the order of the file."""
    order = np.argsort(level, kind="stable")
    ends = np.flatnonzero(level[order][1:] > SAME_LEVEL * level[order][:-1]) + 1
    return tuple(np.sort(rows) for rows in np.split(order, ends))


Record = Trace | Sweep


def common_order(records: Iterable[Record]) -> int:
    """Which derivative of the displacement all of some records are, 0, 1 or 2; 0 where they differ."""
    orders = {record.order if isinstance(record, Trace) else 0 for record in records}
    return orders.pop() if len(orders) == 1 else 0


class Same:
    """An array of a record as the key of what is known of it. Hypotheses about a record change its clock or its
    response; the drive stays the same array, and arrays of records never change."""

    def __init__(self, array: np.ndarray):
        self.array = array

    def __hash__(self) -> int:
        return id(self.array)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.array is other.array
