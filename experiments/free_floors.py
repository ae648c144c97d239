"""Noise floors beneath drives that do not repeat, how far off? `python -m experiments.free_floors [SEED] [CAMPAIGNS]`

Oscillators with a quadratic and a cubic spring, quality 0.6 to 2000, 8 to 100 samples per period of the resonance, read
as a displacement or a velocity: by one sensor a sine, a multisine that repeats and one that does not, steps, bursts and
a sweep. Its noise is white, autoregressive of first or second order, red or flicker noise beside white, or white with
mains hum. Printed: the median of floor / true
of the last four, half of them and nine in ten, each record alone, beside the others, and beside those that repeat too;
and how many floors are called coloured. The colours' criterion was set on seeds from 30000, the figures are of others.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from numba import njit

from experiments.hidden_noise import noise as noise_of
from ident.campaign.noise.floor import noise_floor
from ident.campaign.noise.of_others import beside_others
from ident.campaign.noise.one_sensor import of_one_sensor
from ident.campaign.noise.pool import pooled
from ident.campaign.period import find_period

DRIVES = ("sine", "periodic", "multisine", "steps", "bursts", "sweep")
FREE = DRIVES[2:]  # of which no period is known: floors are read off the frequencies above
KINDS = ("white", "ar1", "ar2", "both", "pink", "hum")
_LARGEST = 6.0  # times the rms of the linear motion
_INNER = 60  # steps of integration per period of the resonance, at least


def _ramp(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x * x)


def drive_of(rng: np.random.Generator, kind: str, length: float, highest: float) -> Callable[[np.ndarray], np.ndarray]:
    """A drive of a `length`, in periods of the resonance, none of it above `highest` times the resonance."""
    low = lambda a, b: min(float(rng.uniform(a, b)), highest)
    if kind == "sine":
        rate = low(0.3, 1.5)
        return lambda t: np.sin(2 * np.pi * rate * t)
    if kind == "periodic":
        lines, first = np.arange(1, int(rng.integers(8, 30))), length / float(rng.uniform(3, 6))
        lines = lines[lines / first < highest]
        phases = rng.uniform(0, 2 * np.pi, len(lines))
        return lambda t: np.cos(2 * np.pi * np.outer(t, lines / first) + phases).sum(axis=1)
    if kind == "multisine":
        lines = np.sort(rng.uniform(0.2, low(1.2, 3.0), int(rng.integers(4, 25))))
        phases, rise = rng.uniform(0, 2 * np.pi, len(lines)), 1 / lines[0]
        return lambda t: np.cos(2 * np.pi * np.outer(t, lines) + phases).sum(axis=1) * _ramp(t / rise)
    if kind == "steps":
        times = np.sort(rng.uniform(0, 0.95, int(rng.integers(3, 8)))) * length
        levels, rise = rng.uniform(-1, 1, len(times)), rng.uniform(0.1, 0.6)
        jumps = np.diff(levels, prepend=0.0)
        return lambda t: _ramp((t[:, None] - times) / rise) @ jumps
    if kind == "bursts":
        found = [
            (low(0.4, 2.0), at * length, float(rng.uniform(5, 16)), float(rng.uniform(0.3, 1)))
            for at in np.sort(rng.uniform(0, 0.8, int(rng.integers(2, 5))))
        ]

        def bursts(t: np.ndarray) -> np.ndarray:
            sum_ = np.zeros(len(t))
            for rate, at, cycles, size in found:
                x = (t - at) * rate / cycles
                inside = np.sin(np.pi * x) ** 2 * ((x > 0) & (x < 1))
                sum_ += size * inside * np.sin(2 * np.pi * rate * (t - at))
            return sum_

        return bursts
    a, b = low(0.2, 0.8), low(1.2, 3.0)
    a, b = (b, a) if rng.random() < 0.4 else (a, b)
    edge = length / 40
    return lambda t: (
        np.sin(2 * np.pi * (a + (b - a) / 2 * t / length) * t) * _ramp(t / edge) * _ramp((length - t) / edge)
    )


@njit
def _moved(push: np.ndarray, step: float, quality: float, even: float, odd: float) -> np.ndarray:
    """(m, 2) place and speed, by Runge and Kutta's method; the push (2m − 1,) is told at every half step, and time is
    counted in radians of the resonance."""
    found = np.zeros((len(push) // 2 + 1, 2))
    z, v, half = 0.0, 0.0, 0.5 * step
    for i in range(len(push) // 2):
        p, q, r = push[2 * i], push[2 * i + 1], push[2 * i + 2]
        a1 = p - z - even * z * z - odd * z**3 - v / quality
        z2, v2 = z + half * v, v + half * a1
        a2 = q - z2 - even * z2 * z2 - odd * z2**3 - v2 / quality
        z3, v3 = z + half * v2, v + half * a2
        a3 = q - z3 - even * z3 * z3 - odd * z3**3 - v3 / quality
        z4, v4 = z + step * v3, v + step * a3
        a4 = r - z4 - even * z4 * z4 - odd * z4**3 - v4 / quality
        z += step / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v += step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        found[i + 1, 0], found[i + 1, 1] = z, v
    return found


def noise(rng: np.random.Generator, kind: str, n: int, numbers: Any) -> np.ndarray:
    """(n,) of unit variance; hum is added to white noise."""
    if kind == "ar2":
        ring, sharp = numbers.ring, numbers.sharp
        spectrum = 1 / np.abs(np.polyval([sharp**2, -2 * sharp * np.cos(ring), 1.0], np.exp(-1j * _rates(2 * n)))) ** 2
        white = np.fft.rfft(rng.standard_normal(2 * n))
        return np.fft.irfft(white * np.sqrt(spectrum / np.mean(spectrum)), 2 * n)[:n]
    if kind == "hum":
        tone = np.sqrt(2) * np.sin(numbers.hum * np.arange(n) + rng.uniform(0, 2 * np.pi))
        return (rng.standard_normal(n) + numbers.share * tone) / np.hypot(1.0, numbers.share)
    return noise_of(rng, {"ar1": "red"}.get(kind, kind), n, numbers.slow, numbers.share)


def _rates(n: int) -> np.ndarray:
    return np.linspace(0, np.pi, n // 2 + 1)


def campaign(seed: int) -> tuple[str, list[Any]]:
    """The kind of the noise, and the records of one sensor, read."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    quality, per_period = 0.6 * (2000 / 0.6) ** rng.random(), 8 * 12.5 ** rng.random()
    even, odd, reads = rng.uniform(0, 0.05), rng.uniform(-0.01, 0.03), int(rng.integers(2))
    numbers = SimpleNamespace(
        slow=rng.uniform(0.4, 0.97), share=rng.uniform(0.3, 1.2), ring=rng.uniform(0.2, 2.5),
        sharp=rng.uniform(0.4, 0.85), hum=2 * np.pi * 50 / 1e4,
    )  # fmt: skip
    inner, size = int(np.ceil(_INNER / per_period)), 0.0
    level, records = 10 ** rng.uniform(-3, -1.5), []
    for name in DRIVES:
        n = int(rng.integers(1500, 4500))
        drive = drive_of(rng, name, n / per_period, 0.3 * per_period)
        times = np.arange(2 * inner * (n - 1) + 1) / (2 * inner * per_period)
        push = np.asarray(drive(times), float)
        step = 2 * np.pi / (per_period * inner)
        linear = _moved(push, step, quality, 0.0, 0.0)[::inner, reads]
        gain = 1.0 / max(float(np.std(linear)), 1e-12)
        motion = _moved(gain * push, step, quality, even, odd)[::inner, reads]
        size = size or level
        read = motion + size * noise(rng, kind, n, numbers)
        if not np.max(np.abs(motion)) < _LARGEST:  # it has left the well of its spring, or is about to
            continue
        time, put = np.arange(n) / 1e4, push[:: 2 * inner]
        told = noise_floor(time, put, read, find_period(put))
        records.append(SimpleNamespace(noise=told, drive=put, response=read, masked=None, step=1e-4, name=name,
                                       measures="displacement", true=size, time=time, clean=motion, seed=seed,
                                       quality=quality, per_period=per_period))  # fmt: skip
    return kind, records


def shared(records: list[Any]) -> list[Any]:
    """The floors of the records of a campaign, as it is read (`ident.campaign.read`)."""
    floors = of_one_sensor(records)
    kept = [k for k, record in enumerate(records) if floors[k] is record.noise]
    alike = pooled([floors[k] for k in kept], [len(records[k].time) for k in kept])
    for k, floor in zip(kept, alike, strict=True):
        floors[k] = floor
    return beside_others(records, floors)


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seed", nargs="?", type=int, default=41000)
    parser.add_argument("campaigns", nargs="?", type=int, default=120)
    given = parser.parse_args()
    told: dict[tuple[str, str], list[tuple[float, bool]]] = {}
    for seed in range(given.seed, given.seed + given.campaigns):
        kind, records = campaign(seed)
        free = [record for record in records if record.name in FREE]
        whole = [floor for record, floor in zip(records, shared(records), strict=True) if record.name in FREE]
        ways = {"alone": [record.noise for record in free], "beside others": shared(free), "and a sine": whole}
        for way, floors in ways.items():
            row = told.setdefault((kind, way), [])
            row += [(floor.sigma / record.true, bool(floor.ar)) for record, floor in zip(free, floors, strict=True)]
    for (kind, way), row in sorted(told.items()):
        low, first, middle, third, high = np.percentile([ratio for ratio, _ in row], (5, 25, 50, 75, 95))
        print(f"{kind:6} {way:14} {len(row):3}  {middle:.2f}, half of them {first:.2f} to {third:.2f}, nine in ten "
              f"{low:.2f} to {high:.2f}; {sum(coloured for _, coloured in row)} coloured")  # fmt: skip
        if kind == "white" and way == "and a sine":
            assert low > 0.9 and 0.97 < middle < 1.03 and third < 1.1, "white noise read as white"


if __name__ == "__main__":
    main()
