"""Drive signals with exact values and exact rates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Tones:
    """A sum of sines Σ a sin(2π f t + p): a sine or a multisine, volts and seconds.

    **Arguments:**

    - `amplitudes` V, `frequencies` Hz, `phases` rad: arrays of one length; `bias`: constant part, V.
    """

    amplitudes: np.ndarray
    frequencies: np.ndarray
    phases: np.ndarray
    bias: float = 0.0

    def value(self, t: np.ndarray) -> np.ndarray:
        """Voltage at times `t` (s), V."""
        angle = 2 * np.pi * np.outer(t, self.frequencies) + self.phases
        return np.sin(angle) @ self.amplitudes + self.bias

    def rate(self, t: np.ndarray) -> np.ndarray:
        """Rate of the voltage at times `t` (s), V/s."""
        angle = 2 * np.pi * np.outer(t, self.frequencies) + self.phases
        return np.cos(angle) @ (2 * np.pi * self.frequencies * self.amplitudes)


@dataclass(frozen=True)
class Chirp:
    """A linear chirp a sin(2π (f_a t + (f_b − f_a) t²/(2T))), volts and seconds."""

    amplitude: float
    start: float
    stop: float
    duration: float

    def _angle(self, t: np.ndarray) -> np.ndarray:
        return 2 * np.pi * (self.start * t + (self.stop - self.start) * t**2 / (2 * self.duration))

    def value(self, t: np.ndarray) -> np.ndarray:
        """Voltage at times `t` (s), V."""
        return self.amplitude * np.sin(self._angle(t))

    def rate(self, t: np.ndarray) -> np.ndarray:
        """Rate of the voltage at times `t` (s), V/s."""
        speed = 2 * np.pi * (self.start + (self.stop - self.start) * t / self.duration)
        return self.amplitude * speed * np.cos(self._angle(t))


@dataclass(frozen=True, eq=False)
class Played:
    """A voltage (V) at times (s) as a generator of waveforms plays it: straight lines between its samples."""

    t: np.ndarray
    volts: np.ndarray

    def value(self, t: np.ndarray) -> np.ndarray:
        """Voltage at times `t` (s), V."""
        return np.interp(t, self.t, self.volts)

    def rate(self, t: np.ndarray) -> np.ndarray:
        """Rate of the voltage at times `t` (s), V/s: of the line that begins there."""
        at = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        return (np.diff(self.volts) / np.diff(self.t))[at]


Drive = Tones | Chirp | Played


def sine(amplitude: float, frequency: float) -> Tones:
    """A sine from zero phase, V and Hz."""
    return Tones(np.array([amplitude]), np.array([frequency]), np.zeros(1))


def multisine(peak: float, frequencies: np.ndarray, seed: int) -> Tones:
    """Equal tones with random phases, scaled to a peak of `peak` volts."""
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(frequencies))
    flat = Tones(np.ones(len(frequencies)), frequencies, phases)
    spacing = np.gcd.reduce(np.round(frequencies).astype(int))
    t = np.linspace(0, 1 / spacing, 40 * int(max(frequencies) / spacing))
    return Tones(np.full(len(frequencies), peak / np.max(np.abs(flat.value(t)))), frequencies, phases)


def reference_rate(drive: Drive, t: np.ndarray) -> float:
    """The drive's own angular frequency, rad/s: rms(V̇)/rms(V − mean V); ω itself for whole periods of a sine."""
    value, rate = drive.value(t), drive.rate(t)
    return float(np.sqrt(np.mean(rate**2)) / np.std(value))
