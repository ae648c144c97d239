"""Devices with hidden effects, measured by stepped sines at several levels, up and down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from experiments.hidden_effects.generator import Device
from experiments.hidden_effects.laws import INDEX, LAWS

from .sweeps import READ, sweep

LEVELS = np.array([1 / 3, 5 / 9, 7 / 9, 1.0])
DWELL = 4  # times the quality, in periods: a ring-down has fallen to 4e-6 then


@dataclass(frozen=True, eq=False)
class Curve:
    """One pass: drive level (V), direction, frequencies (Hz) in the order of the sweep, responses as measured.

    `response`: (k,) complex amplitudes relative to the phase of the drive, m or V; `clean`: without noise.
    """

    level: float
    up: bool
    frequency: np.ndarray
    response: np.ndarray
    clean: np.ndarray


@dataclass(frozen=True, eq=False)
class Case:
    """A device, its curves, and what is true about it."""

    device: Device
    curves: list[Curve]
    truth: dict[str, object]


@dataclass(frozen=True)
class Noise:
    """Of an amplitude: constant (fraction of the largest amplitude of all curves) and relative; of the phase, rad."""

    constant: float = 1e-3
    relative: float = 2e-3
    phase: float = 2e-3


def frequencies(quality: float) -> np.ndarray:
    """(40,) frequencies over ω0: 4.5 points within the half-power width near the resonance, few far from it."""
    below, near, above = np.linspace(-10, -2.5, 8), np.linspace(-2.2, 3.5, 26), np.linspace(4, 12, 6)
    return 1 + np.concatenate([below, near, above]) / quality


def measure(
    device: Device, level: float, c: np.ndarray, s: np.ndarray, coarse: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """(80,) frequencies over ω0, first up and then down again, and the complex amplitudes there, dimensionless.

    `coarse`: every other frequency, only up, and settled to a part in a thousand: enough to size an effect.
    """
    rising = frequencies(device.quality)
    ratios = rising[::2] if coarse else np.concatenate([rising, rising[::-1]])
    periods = int(np.ceil((2.2 if coarse else DWELL) * device.quality)) + READ
    return ratios, sweep(ratios, level, periods, device.gain, device.quality, c, s, device.geometry)


def misfit(device: Device, c: np.ndarray, s: np.ndarray) -> float:
    """Of the best linear oscillator to the curves of the weakest and the strongest drive, as a fraction of their rms.

    Each level counts alike, as its noise does; infinite where a motion has no bound or hardly any is left.
    """
    ratios, parts = np.empty(0), []
    for level in (LEVELS[0], LEVELS[-1]):
        ratios, found = measure(device, level, c, s, coarse=True)
        if not np.all(np.isfinite(found)) or np.max(np.abs(found)) < 0.25 * level:
            return np.inf
        parts.append(found / level)
    together = np.concatenate(parts)
    both = np.tile(ratios, 2)

    def linear(p: np.ndarray) -> np.ndarray:
        return p[2] / (p[0] ** 2 - both**2 + 1j * both * p[0] / p[1])

    def residual(p: np.ndarray) -> np.ndarray:
        return np.concatenate([np.real(together - linear(p)), np.imag(together - linear(p))])

    scale = float(np.sqrt(np.mean(np.abs(together) ** 2)))
    start = [ratios[int(np.argmax(np.abs(parts[1])))], device.quality, device.gain]
    found = least_squares(residual, start, x_scale=[1 / device.quality, device.quality, device.gain])
    return float(np.sqrt(2 * found.cost / len(together))) / scale


def coefficient(device: Device, name: str, s: np.ndarray, size: float) -> tuple[float, float]:
    """The coefficient at which the misfit is closest to `size`, and that misfit; some effects cannot get there."""
    c, value = np.zeros(len(LAWS)), 0.03
    tried: list[tuple[float, float, float]] = []
    low, high = 0.0, np.inf
    for _ in range(12):
        c[INDEX[name]] = value
        now = misfit(device, c, s)
        tried.append((abs(np.log(max(now, 1e-12) / size)) if np.isfinite(now) else np.inf, value, now))
        if tried[-1][0] < 0.05:
            break
        low, high = (value, high) if now < size else (low, value)
        value *= float(np.clip(size / max(now, 1e-12), 0.2, 8.0)) if np.isfinite(now) else 0.3
        if not low < value < high:
            value = np.sqrt(low * high) if low > 0 and np.isfinite(high) else (2 * low if low > 0 else 0.3 * high)
    return min(tried)[1:]


def draw(
    seed: int,
    effects: tuple[str, ...],
    *,
    size: float = 0.08,
    noise: Noise = Noise(),  # noqa: B008  (frozen)
    kind: Literal["platform", "oscillator"] = "platform",
    detail: Literal["own", "plain"] = "own",
) -> Case:
    """One device with hidden effects and its curves at four levels; `size`: misfit that each effect alone gives."""
    rng = np.random.default_rng([seed, 19])
    quality = rng.uniform(20, 60)
    if kind == "platform":
        frequency, unit, volts = rng.uniform(450, 550), rng.uniform(8e-6, 30e-6), 9.0
    else:
        frequency, unit, volts = 10 ** rng.uniform(0.7, 3.7), 10 ** rng.uniform(-2, 1), 10 ** rng.uniform(-1, 1)
    device = Device(kind, frequency, quality, 1 / quality, unit, volts, 1.0)
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    for name in effects:
        s[INDEX[name]] = LAWS[INDEX[name]].shape(rng, detail == "own")
    alone = {name: coefficient(device, name, s, size) for name in effects}
    for name, (value, _) in alone.items():
        c[INDEX[name]] = value
    curves, found = [], [(level, *measure(device, level, c, s)) for level in LEVELS]
    if not all(np.all(np.isfinite(response)) for *_, response in found):
        raise ValueError("The motion has no bound; draw another device.")
    floor = noise.constant * max(float(np.max(np.abs(response))) for *_, response in found)
    for level, ratios, response in found:
        half = len(ratios) // 2
        for part, up in ((slice(0, half), True), (slice(half, None), False)):
            noisy = _measured(rng, response[part], floor, noise)
            curves.append(Curve(level * volts, up, ratios[part] * frequency, noisy * unit, response[part] * unit))
    truth: dict[str, object] = {
        "effects": list(effects), "seed": seed, "detail": detail, "device": kind,
        "laws": {n: {"coefficient": c[INDEX[n]], "shape": list(s[INDEX[n]]), "size": alone[n][1]} for n in effects},
        "parameters": device.parameters, "sigma": floor * unit, "relative": noise.relative, "phase": noise.phase,
        "unit": unit, "volts": volts,
    }  # fmt: skip
    return Case(device, curves, truth)


def _measured(rng: np.random.Generator, clean: np.ndarray, floor: float, noise: Noise) -> np.ndarray:
    """What the lock-in shows: noise of its input in both parts, of its gain along, of its reference across."""
    n = len(clean)
    added = floor * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
    turned = np.exp(1j * noise.phase * rng.standard_normal(n))
    return clean * (1 + noise.relative * rng.standard_normal(n)) * turned + added
