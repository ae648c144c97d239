"""The nominal device, and what ident says that it does under settled sines."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ident.campaign import Channel, NoiseFloor, Platform, Trace
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.effects.library.pzt_hysteresis import PztHysteresis
from ident.effects.library.residual_stress import ResidualStress
from ident.fit.reading import read
from ident.mechanics import Closure
from ident.model import Model
from ident.runtime import configure

_TOLD: dict[str, Any] = tomllib.loads((Path(__file__).parent / "nominal.toml").read_text(encoding="utf-8"))
PARAMETERS: Mapping[str, float] = _TOLD["parameters"]
CLOSURE: Closure = _TOLD["closure"]
STRESSES = tuple(f"residual-stress.{name}" for name in ("sigma12", "sigma23", "sigma2"))

NO_STRESS = {"residual-stress.restraint": 0.0, "residual-stress.voltage_force": 0.0}
NO_HYSTERESIS = {"pzt-hysteresis.eta": 0.0, "pzt-hysteresis.zeta": 0.0}

POINTS = 128
"""Samples per period."""
_TIMES = 14.0  # decay times of the transient that are let pass: what is left of it is a millionth


class Sine(NamedTuple):
    """A drive: amplitude, V, frequency, Hz, and the load on the stage, kg."""

    volts: float
    hertz: float
    load: float = 0.0


def stressed(multiple: float) -> dict[str, float]:
    """The parameters of so many times the nominal stress."""
    return {name: multiple * PARAMETERS[name] for name in STRESSES}


def platform(closure: Closure = CLOSURE) -> Model:
    """The model of the paper: residual stress and hysteresis, and the stiffening of large deformations."""
    device = Platform()
    return Model(device, (ResidualStress(device, {"closure": closure}), CubicStiffness(), PztHysteresis()))


def settled(
    sines: Sequence[Sine], changed: Mapping[str, float] | None = None, closure: Closure = CLOSURE
) -> list[np.ndarray]:
    """One period of the settled motion for each drive, (POINTS,) m from the drive's zero; NaN where a beam buckles.

    **Arguments:** `changed`: parameters that are not the nominal ones, by full name.
    """
    configure()
    model, told = platform(closure), {**PARAMETERS, **(changed or {})}
    values = np.array([told[p.name] if p.fitted else told.get(p.name, p.value) for p in model.parameters])
    records = [_record(sine, told) for sine in sines]
    periods = [reading[-POINTS:] for reading in read(model, values, records)]
    return [z if np.max(np.abs(z)) < _LOST else np.full(POINTS, np.nan) for z in periods]


_LOST = 150e-6  # m; twice the motion at resonance under 9 V


def _record(sine: Sine, told: Mapping[str, float]) -> Trace:
    decay = told["platform.quality"] / (np.pi * told["platform.frequency"]) * (1 + sine.load / Platform().stage_mass)
    periods = int(np.ceil(_TIMES * decay * sine.hertz)) + 1
    time = np.arange(periods * POINTS) / (POINTS * sine.hertz)
    drive = sine.volts * np.sin(2 * np.pi * sine.hertz * time)
    channels = Channel("V", 1.0), Channel("um", 1e-6)
    return Trace("", time, drive, np.zeros_like(time), *channels, NoiseFloor(1e-9), "rest", load=sine.load)


class Harmonics(NamedTuple):
    """Mean, amplitudes of the first two harmonics, and half the peak-to-peak of a period, m."""

    mean: float
    first: float
    second: float
    swing: float

    @property
    def offset(self) -> float:
        """What an odd motion has none of, over its amplitude: √(mean² + second²/2) √2/first."""
        return float(np.sqrt(2 * self.mean**2 + self.second**2) / self.first)


def harmonics(period: np.ndarray) -> Harmonics:
    """Of one period (n,)."""
    series = np.fft.rfft(period) / len(period)
    return Harmonics(float(series[0].real), *(2 * np.abs(series[1:3])).tolist(), float(np.ptp(period)) / 2)


def without_offset(period: np.ndarray) -> np.ndarray:
    """The part of a period that is odd under a shift by half of it: what symmetric physics would leave."""
    return (period - np.roll(period, len(period) // 2)) / 2
