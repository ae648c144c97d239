"""What devices of other laboratories have in common: signals, a solver, and how their records are written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfiltfilt

Signal = Callable[[np.ndarray | float], np.ndarray]


class Device(NamedTuple):
    """`write` makes its records; `hidden`: for each effect the names that are right; None: the library cannot have it.
    `floor`: whether the noise floor must be reached, on held-out records too."""

    write: Callable[[Lab, np.random.Generator], None]
    hidden: tuple[frozenset[str], ...] | None
    floor: bool


DEVICES: dict[str, Device] = {}


def device(*hidden: str, floor: bool = True, beyond: bool = False):
    """Registers a device: names of one effect that cannot be told apart are joined by `|`."""

    def register(write: Callable[[Lab, np.random.Generator], None]):
        names = tuple(frozenset(names.split("|")) for names in hidden)
        DEVICES[write.__name__] = Device(write, None if beyond else names, floor)
        return write

    return register


class Lab:
    """Writes the records of one device; those named in `held` are held out."""

    def __init__(self, folder: Path, rng: np.random.Generator):
        self.folder, self.rng, self.held = folder, rng, list[str]()

    def write(
        self, name: str, head: str, t: np.ndarray, drive: np.ndarray | None, y: np.ndarray, *, noise: float = 0.01,
        colour: float = 0.0, offset: float = 0.0, bits: int = 0, digits: int = 5, held: bool = False,
    ) -> None:  # fmt: skip
        """`noise`: of the reading's standard deviation; `colour`: its autoregression; `digits`: of the times."""
        e = np.asarray(lfilter([1.0], [1.0, -colour], self.rng.standard_normal(t.size + 500)))[500:]
        y = y + offset + noise * np.std(y) * e / np.std(e)
        if bits:
            step = 2.4 * np.max(np.abs(y)) / 2**bits
            y = step * np.round(y / step)
        columns, formats = ([t, y], [f"%.{digits}f", "%.6g"])
        if drive is not None:
            columns, formats = [t, drive, y], [formats[0], "%.5g", "%.6g"]
        path = self.folder / f"{name}.csv"
        np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt=formats)
        self.held += [path.name] if held else []


def sine(size: float, hertz: float) -> Signal:
    return lambda t: size * np.sin(2 * np.pi * hertz * np.asarray(t))


def chirp(size: float, low: float, high: float, length: float) -> Signal:
    return lambda t: size * np.sin(2 * np.pi * (low * t + (high - low) * np.asarray(t) ** 2 / (2 * length)))


def multisine(rng: np.random.Generator, size: float, low: float, high: float, step: float) -> Signal:
    t = np.linspace(0, 1 / step, int(64 * high / step) + 1)
    y = sum(np.cos(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi)) for f in np.arange(low, high, step))
    y = size * np.asarray(y) / np.std(y)
    y[-1] = y[0]
    curve = CubicSpline(t, y, bc_type="periodic")
    return lambda t: curve(np.mod(t, 1 / step))


def noise(rng: np.random.Generator, size: float, low: float, high: float, length: float) -> Signal:
    rate = 40 * high
    band = butter(3, [low, high], "band", fs=rate, output="sos")
    y = sosfiltfilt(band, rng.standard_normal(int(length * rate) + 2400))[1000:-1000]
    curve = CubicSpline((np.arange(y.size) - 200) / rate, size * y / np.std(y))
    return lambda t: curve(t)


def steps(levels: np.ndarray, length: float, rise: float) -> Signal:
    each = length / len(levels)

    def drive(t: np.ndarray | float) -> np.ndarray:
        k = np.clip((np.asarray(t) / each).astype(int), 0, len(levels) - 1)
        before = np.concatenate([[0.0], levels])[k]
        return before + (levels[k] - before) * np.clip((t - k * each) / rise, 0, 1)

    return drive


def solve(rates: Callable, t: np.ndarray, start: list[float], before: float = 0.0, most: float = np.inf) -> np.ndarray:
    """States (k, n), from `start` at `before` seconds ahead of the record."""
    found = solve_ivp(rates, (-before, t[-1]), start, "LSODA", t, rtol=1e-9, atol=1e-13, max_step=most)
    if not found.success or not np.all(np.isfinite(found.y)):
        raise RuntimeError(found.message)
    return found.y


def oscillator(hertz: float, quality: float, gain: float, drive: Signal | None, law: Callable | None = None):
    """z̈ + (ω/Q) ż + ω² z = g u + law(z, v, u, t)."""
    w = 2 * np.pi * hertz

    def rates(t: float, state: np.ndarray) -> list[float]:
        z, v = state
        u = 0.0 if drive is None else float(drive(t))
        return [v, gain * u - w * w * z - w / quality * v + (0.0 if law is None else law(z, v, u, t))]

    return rates
