"""Devices that no linear oscillator comes near: `python -m experiments.strongly_nonlinear [NAME …]`.

SciPy integrates an oscillator with one strong law, its tables are written as a laboratory writes them, and `ident new`
and `ident discover` are typed as they stand. Asserted are the names, the error on a record that was held out, and that
the linear model left at least thirty noise floors; printed are the errors, the verdict and CPU seconds.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from experiments.public_data import ident

FREQUENCY, QUALITY, SIZE = 50.0, 30.0, 2e-3  # Hz; m, by which the laws are placed
OMEGA = 2 * np.pi * FREQUENCY
FORCE = 3 * OMEGA**2 * SIZE / QUALITY  # N/kg per volt
TIME = np.arange(3000) / 2000.0
NOISE = 0.004  # of the readings' standard deviation


class Device(NamedTuple):
    """`law`: what is added to the linear oscillator's acceleration, of displacement and velocity; `names`: what may be
    named; `velocity`: whether that is read instead of displacement."""

    law: Callable[[float, float], float]
    names: tuple[str, ...]
    velocity: bool = False


def stop(z: float, _: float) -> float:
    """A spring 2.8 times as stiff as the stage's own that is met at half of `SIZE`, on one side."""
    return -2.8 * OMEGA**2 * max(z - 0.5 * SIZE, 0.0)


def hardening(share: float) -> Callable[[float, float], float]:
    """Stiffness that grows by three times a share at the displacement `SIZE`."""
    return lambda z, _: -share * OMEGA**2 * z**3 / SIZE**2


DEVICES = {
    "hardening": Device(hardening(1.0), ("cubic-stiffness",)),
    "hardening, velocity read": Device(hardening(0.3), ("cubic-stiffness",), velocity=True),
    "pendulum": Device(
        lambda z, _: OMEGA**2 * (z - np.sin(0.7 * z / SIZE) * SIZE / 0.7), ("cubic-stiffness", "quintic-stiffness")
    ),
    "stop": Device(stop, ("end-stop",)),
    "dry friction": Device(lambda _, v: -FORCE / 6 * np.tanh(1e3 * v / (OMEGA * SIZE)), ("coulomb-friction",)),
    "drag": Device(lambda _, v: -3 * OMEGA / QUALITY * v * abs(v) / (OMEGA * SIZE), ("quadratic-damping",)),
}


def drives(random: np.random.Generator) -> dict[str, np.ndarray]:
    """Volts of five records: sines below and at resonance, a chirp, and two multisines."""
    tones = np.linspace(10, 120, 40)

    def multisine(volts: float) -> np.ndarray:
        phases = random.uniform(0, 2 * np.pi, len(tones))
        return volts / 5 * np.sin(2 * np.pi * tones * TIME[:, None] + phases).sum(axis=1)

    chirp = np.sin(2 * np.pi * (20 * TIME + 60 * TIME**2 / (2 * TIME[-1])))
    sine = lambda volts, hertz: volts * np.sin(2 * np.pi * hertz * TIME)
    return {"noise": multisine(0.6), "weak": sine(0.4, 49.0), "strong": sine(1.0, 51.5), "chirp": chirp,
            "noise2": multisine(0.4)}  # fmt: skip


def write(device: Device, folder: Path, seed: int) -> list[str]:
    """The records of a device as CSV files; their names."""
    random = np.random.default_rng(seed)
    reading = "velocity (mm/s)" if device.velocity else "displacement (mm)"
    for name, volts in drives(random).items():
        drive = CubicSpline(TIME, volts)
        rate = lambda t, y, drive=drive: [
            y[1], FORCE * drive(t) - OMEGA**2 * y[0] - OMEGA / QUALITY * y[1] + device.law(*y)
        ]  # fmt: skip
        moved = solve_ivp(rate, (0, TIME[-1]), [0, 0], "DOP853", TIME, rtol=1e-9, atol=1e-12, max_step=5e-4).y
        read = 1e3 * moved[int(device.velocity)]
        read = read + NOISE * np.std(read) * random.standard_normal(len(TIME))
        table = np.column_stack([TIME, volts, read])
        np.savetxt(folder / f"{name}.csv", table, "%.8g", ",", header=f"time (s),drive (V),{reading}", comments="")
    return [f"{name}.csv" for name in drives(random)]


def check(name: str, seed: int = 1) -> str:
    """Run one device, assert what is claimed of it, and return its row."""
    device = DEVICES[name]
    with tempfile.TemporaryDirectory() as temporary:
        work = Path(temporary)
        files = write(device, work, seed)
        begun = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
        ident(("new", "mine", *files), work)
        ident(("discover", "mine", "-o", "run"), work)
        seconds = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) - begun
        run = json.loads((work / "run" / "run.json").read_text(encoding="utf-8"))
        said = json.loads((work / "run" / "diagnosis.json").read_text(encoding="utf-8"))
    start, held_out = said["start"]["error_over_noise"], run["holdout"]["error_over_noise"]
    row = f"{name:26} {start:6.0f} {held_out:6.2f}  {', '.join(run['effects'])}: {said['verdict']}, {seconds:.0f} s"
    assert start > 30 and held_out < 1.5 and set(run["effects"]) == set(device.names), row
    return row


def main() -> None:
    """The devices that are named, or all."""
    print(f"{'device':26} {'linear':>6} {'after':>6}  error over noise, the latter held out")
    for name in sys.argv[1:] or DEVICES:
        print(check(name), flush=True)


if __name__ == "__main__":
    main()
