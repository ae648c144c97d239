"""What lies in laboratories rather than in devices: mains, an input that passes no constant, a device that warms up or
is read at another spot, late, by another clock or by a sensor that wanders, an amplifier at its limit, a drive with a
dead zone, a damper that works one way, noise of the force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter

from .lab import Lab, Signal, device, multisine, oscillator, sine, solve

_HEAD = "time (s),drive (V),displacement (um)"
_RATE = 30.0  # samples per period of the resonance


def _drives(rng: np.random.Generator, f: float, size: float) -> list[Signal]:
    """Two sines, and two sums of sines."""
    tones = [sine(2 * size, 0.62 * f), sine(size, 0.985 * f)]
    return [
        *tones,
        multisine(rng, size, 0.3 * f, 2 * f, 0.05 * f),
        multisine(rng, 0.8 * size, 0.3 * f, 2 * f, 0.05 * f),
    ]


def _records(
    lab: Lab, rng: np.random.Generator, force: Callable[..., float], read: Callable[..., np.ndarray] | None = None,
    push: Callable[[np.ndarray], np.ndarray] = lambda u: u, warmer: Sequence[float] = (0.0,) * 4,
    rumble: float = 0.0,
) -> None:  # fmt: skip
    """Records of an oscillator of 120 to 180 Hz, 8 μm at 1 V and resonance, under noise of `rumble` times the drive;
    the last is held out."""
    f, quality = rng.uniform(120, 180), 40.0
    w, t = 2 * np.pi * f, np.arange(1800) / (_RATE * f)
    for i, (u, own) in enumerate(zip(_drives(rng, f, 2.0), warmer, strict=True)):
        sprung: Any = lambda z, v, u, t, own=own: -own * w * w * z + force(w, z, v)
        noise = rumble * np.std(u(t)) * rng.standard_normal(t.size) if rumble else np.zeros(t.size)
        beside = CubicSpline(t, noise)
        drive: Signal = lambda at, u=u, beside=beside: push(np.asarray(u(at))) + beside(at)
        z = solve(oscillator(f, quality, 0.2 * w * w, drive, sprung), t, [0, 0])[0]
        reading = z if read is None else read(i, t, z)
        lab.write(f"run{i}", _HEAD, t, np.asarray(u(t)), reading, noise=0.004, digits=8, held=i == 3)


def _drag(w: float, z: float, v: float) -> float:
    return -0.0009 * v * abs(v)


def _hardening(w: float, z: float, v: float) -> float:
    return -1.5e-4 * w * w * z**3


def _at(when: np.ndarray, t: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The motion at other times; before the first sample there was none, after the last it goes on as a curve."""
    return np.where(when < 0, 0.0, CubicSpline(t, z)(when))


@device(floor=False)
def rumbling(lab: Lab, rng: np.random.Generator) -> None:
    """Nothing but noise of the force, 1 % of the drive."""
    _records(lab, rng, lambda w, z, v: 0.0, rumble=0.01)


@device("cubic-stiffness|residual-stress", floor=False)
def rumbling_spring(lab: Lab, rng: np.random.Generator) -> None:
    """A hardening spring under noise of the force, 1 % of the drive."""
    _records(lab, rng, _hardening, rumble=0.01)


@device("quadratic-damping|power-law-damping")
def mains(lab: Lab, rng: np.random.Generator) -> None:
    """Drag, under hum of 50 Hz in a phase of its own in every record."""
    _records(lab, rng, _drag, lambda i, t, z: z + 0.4 * np.sin(2 * np.pi * 50 * t + rng.uniform(0, 2 * np.pi)))


@device("quadratic-stiffness", "ac-coupling")
def ac_coupled(lab: Lab, rng: np.random.Generator) -> None:
    """A spring that is not symmetric, read through an input that passes nothing below 2.5 Hz."""
    high = lambda i, t, z: np.asarray(lfilter(*butter(1, 2.5, "high", fs=1 / t[1]), z))
    _records(lab, rng, lambda w, z, v: -0.008 * w * w * z * z, high)


@device("quadratic-damping|power-law-damping")
def warm(lab: Lab, rng: np.random.Generator) -> None:
    """Drag, on a device whose spring is another one in every record."""
    _records(lab, rng, _drag, warmer=0.004 * rng.standard_normal(4))


@device("cubic-stiffness")
def spot(lab: Lab, rng: np.random.Generator) -> None:
    """A spring that hardens, read at another spot of the stage in every record."""
    times = 1 + 0.02 * rng.standard_normal(4)
    _records(lab, rng, _hardening, lambda i, t, z: times[i] * z)


@device("cubic-stiffness")
def triggered(lab: Lab, rng: np.random.Generator) -> None:
    """A spring that hardens; the recorder has a trigger of its own, up to 1.5 samples off in every record."""
    late = rng.uniform(-1.5, 1.5, 4)
    _records(lab, rng, _hardening, lambda i, t, z: _at(t - late[i] * t[1], t, z))


@device("quadratic-damping|power-law-damping")
def two_clocks(lab: Lab, rng: np.random.Generator) -> None:
    """Drag; generator and recorder run by clocks of their own, which drift apart."""
    fast = 3e-4 * rng.standard_normal(4)
    _records(lab, rng, _drag, lambda i, t, z: _at(t * (1 - fast[i]), t, z))


@device("cubic-stiffness")
def unsettled(lab: Lab, rng: np.random.Generator) -> None:
    """A spring that hardens, read by a sensor whose zero wanders otherwise in every record."""
    drifts = rng.normal(0, [[1.0], [0.5]], (2, 4))
    wander = lambda i, t: drifts[0, i] * t / t[-1] + drifts[1, i] * (t / t[-1]) ** 2
    _records(lab, rng, _hardening, lambda i, t, z: z + wander(i, t))


@device("drive-saturation")
def amplifier(lab: Lab, rng: np.random.Generator) -> None:
    """An amplifier at its limit behind the point where the drive is measured."""
    _records(lab, rng, lambda w, z, v: 0.0, push=lambda u: 3 * np.tanh(u / 3))


@device(beyond=True, floor=False)
def dead_zone(lab: Lab, rng: np.random.Generator) -> None:
    """A drive that does nothing below 0.6 V."""
    _records(lab, rng, lambda w, z, v: 0.0, push=lambda u: np.sign(u) * np.maximum(np.abs(u) - 0.6, 0.0))


@device("quadratic-damping")
def in_a_current(lab: Lab, rng: np.random.Generator) -> None:
    """Drag in a current; what it leans at rest is taken for its place."""
    u = 2000.0
    _records(lab, rng, lambda w, z, v: -0.003 * ((v - u) * abs(v - u) + u * u))


@device("coulomb-friction", "sensor-nonlinearity")
def flat_scale(lab: Lab, rng: np.random.Generator) -> None:
    """A pivot with dry friction, read by a beam of light on a flat scale, as a tangent."""
    rubs = lambda w, z, v: -0.15 * w * w * np.tanh(v / (0.1 * w))
    _records(lab, rng, rubs, lambda i, t, z: 30 * np.tan(z / 30))


@device("asymmetric-damping")
def one_way_damper(lab: Lab, rng: np.random.Generator) -> None:
    """A damper that is stronger one way."""
    _records(lab, rng, lambda w, z, v: -0.3 * w / 40 * abs(v))
