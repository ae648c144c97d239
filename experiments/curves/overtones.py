"""What harmonics tell that the fundamental does not: `python -m experiments.curves.overtones`.

Sweeps at three levels of devices with something hidden, once with the amplitude of the fundamental alone (and its
phase), and once with the 2nd and the 3rd harmonic beside it, are given to `ident discover` with the linear model: an
oscillator with a quadratic spring, one with a cubic spring that softens as much, and a platform under residual stress.
The oscillators are solved by a harmonic balance written here, the platform by long transients of
`experiments.simulator`; no part of the tool has a share in either.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import root

from experiments.make_campaigns import PAPER
from experiments.simulator.files import Column, write_campaign, write_csv
from experiments.simulator.signals import sine
from experiments.simulator.stage import simulate
from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.diagnosis.diagnose import discover  # noqa: E402

FREQUENCY, QUALITY, SIZE = 250.0, 80.0, 2e-6  # Hz; m, which a linear device would reach at 1 V
OWN = 2 * np.pi * FREQUENCY
GAIN = OWN**2 * SIZE / QUALITY
SHIFT = 0.6  # half-power widths, by which the spring softens at the highest peak
CUBIC = -SHIFT / QUALITY / 0.375 * OWN**2 / SIZE**2
QUADRATIC = np.sqrt(-0.9 * CUBIC) * OWN  # softens as much: Nayfeh & Mook, 1979, §2.3.1
LEVELS = (0.4, 0.7, 1.0)  # V, of what SIZE is reached at; of the platform as many tenths of 8 V
ORDERS, SAMPLES = np.arange(1, 8), 64  # of the balance: it is the same to 1e-9 with one more
HEARD = (1, 2, 3)
PERIODS, READ = 400, 20  # of a transient, and of its reading
CONSTANT, RELATIVE, PHASE = 3e-4, 2e-3, 2e-3  # noise: of the largest amplitude, of each, rad


def oscillator(quadratic: float, cubic: float, seed: int) -> np.ndarray:
    """(levels, points, 2 + orders): level, frequency, complex harmonics 1 to 3, m."""
    angle = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    there = np.hstack([np.ones((SAMPLES, 1)), np.cos(np.outer(angle, ORDERS)), np.sin(np.outer(angle, ORDERS))])
    back = 2 / SAMPLES * there.T
    back[0] /= 2
    n, found = len(ORDERS), []
    for level in LEVELS:
        x, rows = np.zeros(1 + 2 * n), []
        for f in frequencies(FREQUENCY, QUALITY, seed):
            w = f / FREQUENCY

            def off(x: np.ndarray, w: float = w, level: float = level) -> np.ndarray:
                z = there @ x
                bent = back @ (quadratic * SIZE / OWN**2 * z**2 + cubic * SIZE**2 / OWN**2 * z**3)
                even, odd = 1 - (ORDERS * w) ** 2, ORDERS * w / QUALITY
                c, s = x[1 : 1 + n], x[1 + n :]
                linear = np.concatenate([x[:1], even * c + odd * s, even * s - odd * c])
                linear[1] -= level / QUALITY
                return linear + bent

            solved = root(off, x, tol=1e-12)
            assert solved.success, solved.message
            x = solved.x
            rows.append([level, f, *(SIZE * (x[1 : 1 + n] - 1j * x[1 + n :])[: len(HEARD)])])
        found.append(rows)
    return np.array(found)


def platform(seed: int) -> np.ndarray:
    """The same of a platform under residual stress."""
    found = []
    for level in 8.0 * np.array(LEVELS):
        state, rows = (0.0, 0.0), []
        for f in frequencies(PAPER.frequency, PAPER.quality, seed):
            t = np.arange((PERIODS + READ) * SAMPLES + 1) / (SAMPLES * f)
            z, v = simulate(PAPER, sine(level, f), t, start=state, substeps=2)
            state, last = (float(z[-1]), float(v[-1])), slice(-READ * SAMPLES - 1, -1)
            turn = np.exp(-1j * (2 * np.pi * f * t[last] - np.pi / 2))  # relative to the cosine of the drive's phase
            rows.append([level, f, *(2 * np.mean(z[last] * turn**k) for k in HEARD)])
        found.append(rows)
    return np.array(found)


def frequencies(own: float, quality: float, seed: int) -> np.ndarray:
    """(44,) Hz, up."""
    jitter = np.random.default_rng([seed, 44]).uniform(-0.05, 0.05)
    return own * (1 + (np.concatenate([np.linspace(-8, -2.4, 8), np.linspace(-2.2, 2.2, 30), np.linspace(2.5, 8, 6)])
                       + jitter) / quality)  # fmt: skip


def write(folder: Path, truth: np.ndarray, seed: int, overtones: bool, phase: bool, device: bool) -> None:
    """A campaign of one table."""
    rng = np.random.default_rng([seed, 45])
    rows = truth.reshape(-1, truth.shape[-1])
    clean, n = rows[:, 2:], len(rows)
    floor = CONSTANT * np.max(np.abs(clean))
    noise = floor * (rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape))
    seen = clean * (1 + RELATIVE * rng.standard_normal(clean.shape)) + noise
    turned = np.angle(seen[:, 0]) + PHASE * rng.standard_normal(n)
    columns = [Column("frequency (Hz)", 1, 4), Column("drive (V)", 1, 3), Column("amplitude (nm)", 1e9, 4)]
    values = [np.real(rows[:, 1]), np.real(rows[:, 0]), np.abs(seen[:, 0])]
    if phase:
        columns.append(Column("phase (deg)", 180 / np.pi, 4))
        values.append(turned)
    for k in HEARD[1:] if overtones else ():
        columns.append(Column(f"A{k} (nm)", 1e9, 4))
        values.append(np.abs(seen[:, k - 1]))
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "sweeps.csv", tuple(columns), tuple(values))
    head: dict[str, object] = {"title": "Heard"}
    if not device:
        head["device"] = {"kind": "oscillator", "output": "m"}
    records: list[dict[str, object]] = [{"file": "sweeps.csv", "kind": "sweep", "direction": "up"}]
    write_campaign(folder / "campaign.toml", head, (), {}, records)


def main() -> None:
    """Simulate, discover, print and assert."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=16000)
    parser.add_argument("--only", default="", help="a name of what is hidden")
    parser.add_argument("--phase", default="without,with")
    asked = parser.parse_args()
    seed = asked.seed
    cases = {
        "quadratic-stiffness": lambda: oscillator(QUADRATIC, 0.0, seed),
        "cubic-stiffness": lambda: oscillator(0.0, CUBIC, seed),
        "residual-stress": lambda: platform(seed),
    }
    for name, solve in cases.items():
        if asked.only and asked.only != name:
            continue
        truth = solve()
        largest = np.max(np.abs(truth[..., 2:]), axis=(0, 1))
        print(f"{name}: harmonics up to " + ", ".join(f"{100 * x / largest[0]:.2g} %" for x in largest[1:]), flush=True)
        for phase in (word == "with" for word in asked.phase.split(",")):
            for overtones in (False, True):
                with tempfile.TemporaryDirectory() as place:
                    write(Path(place), truth, seed, overtones, phase, name == "residual-stress")
                    campaign, begun = read_campaign(place), time.perf_counter()
                    found = discover(campaign).discovery
                steps = [(step.added, *step.tie_set[1:]) for step in found.steps]
                print(f"  {'with' if phase else 'without'} phase, {'with' if overtones else 'without'} harmonics: "
                      f"{found.verdict}, {steps}, error over noise {found.final.fitted.error_over_noise:.2f}, "
                      f"{time.perf_counter() - begun:.0f} s", flush=True)  # fmt: skip
                assert any(name in step for step in steps)
                assert not overtones or steps[0][0] == name


if __name__ == "__main__":
    main()
