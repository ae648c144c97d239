"""Is a record that left its range told from one that did not?  `python -m experiments.faulty_records.clipping`

Resonators of any damping, solved exactly between samples, driven by sines, chirps, steps, pulses and square waves, read
by converters of 5 to 12 bits or by none, with noise up to one step: as they are, and cut at 0.5 to 0.9 of their largest
value.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.signal import cont2discrete, lfilter

from ident.campaign.quality.clipping import clipped_samples

DRIVES = ("sine", "step", "pulse", "square", "chirp")


def response(drive: np.ndarray, rate: float, quality: float) -> np.ndarray:
    """(n,) of z̈ + (ω/Q) ż + ω² z = ω² u from rest, ω = `rate` rad per sample, u a straight line between samples."""
    system = ([rate**2], [1.0, rate / quality, rate**2])
    exact: Any = cont2discrete(system, 1.0, method="foh")
    return np.asarray(lfilter(np.ravel(exact[0]), exact[1], drive))


def case(seed: int) -> tuple[np.ndarray, np.ndarray, float]:
    """The record of a seed as it is and cut, and the share of its samples that are beyond the limit."""
    rng = np.random.default_rng(seed)
    n, per_period = int(rng.integers(400, 3000)), rng.uniform(8, 200)
    rate, quality, t = 2 * np.pi / per_period, 10 ** rng.uniform(-0.5, 2), np.arange(n)
    f = rate * rng.uniform(0.3, 1.5)
    drive = {
        "sine": np.sin(f * t),
        "step": (t > n // 5) * 1.0,
        "pulse": ((t > n // 5) & (t < n // 2)) * 1.0,
        "square": np.sign(np.sin(f / 7 * t) + 1e-9),
        "chirp": np.sin(f * t * (0.5 + t / n)),
    }[DRIVES[seed % 5]]
    clean = response(drive, rate, quality)
    step = float(np.ptp(clean)) / 2 ** rng.uniform(5, 12)
    noisy = clean + rng.choice([0, 0.1, 0.5, 1]) * step * rng.standard_normal(n)
    limit = rng.uniform(0.5, 0.9) * float(np.max(np.abs(clean)))
    cut = np.clip(noisy, -limit, limit)
    coarse = rng.uniform() < 0.8
    read = (lambda signal: np.round(signal / step) * step) if coarse else (lambda signal: signal)
    return read(noisy), read(cut), float(np.mean(np.abs(noisy) >= limit))


def main() -> None:
    """Run the study."""
    counts = {drive: [0, 0, 0] for drive in DRIVES}  # sound ones suspected, clipped ones, and those found
    for seed in range(1000, 1600):
        sound, cut, share = case(seed)
        own = counts[DRIVES[seed % 5]]
        own[0] += bool(np.any(clipped_samples(sound)))
        if share > 0.002:
            own[1] += 1
            own[2] += bool(np.any(clipped_samples(cut)))
    for drive, (false, clipped, found) in counts.items():
        print(f"{drive:7} {false} of 120 sound ones suspected, {found} of {clipped} clipped ones found")
    false, clipped, found = np.sum(list(counts.values()), axis=0)
    print(f"in all  {false} of 600, {found} of {clipped}")
    assert false == 0 and found >= 450


if __name__ == "__main__":
    main()
