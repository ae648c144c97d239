"""Sweeps that were run faster than the motion settles: `python -m experiments.curves.hurry`.

An oscillator is swept up and down at two levels, so fast that it passes its half-power width in about one ring-up, by a
gliding frequency or in short steps. The motion is integrated by SciPy (DOP853), and so is the reading: the integral of
displacement times the phase of the drive over its last whole turn. No part of the tool has a share in it. Fitted is the
right model, with the rate told and with the rate kept from it (every point is then taken as settled); and a device with
something hidden is given to `ident discover` with the linear model.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.stats import chi2

from experiments.simulator.files import Column, write_campaign, write_csv
from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.diagnosis.diagnose import discover  # noqa: E402
from ident.fit import Fit, fit  # noqa: E402
from ident.model import build_model  # noqa: E402

FREQUENCY, QUALITY, GAIN = 120.0, 60.0, 4e-2  # Hz; m/s² per V
OWN = 2 * np.pi * FREQUENCY
SIZE = GAIN * QUALITY / OWN**2  # m per V, settled, of the linear device
LEVELS = (0.5, 1.0)  # V
RATE = 6.0  # Hz/s: 2π r τ² = 1
BAND, POINTS = (108.0, 136.0), 113  # Hz
HELD = 0.04  # s, a quarter of the ring-up, of the stepped ones
AVERAGING = 0.04  # s: a lock-in averages over as many whole turns as fit
CONSTANT, RELATIVE, PHASE = 1e-3, 2e-3, 2e-3  # noise: of SIZE, of the amplitude, rad
COLUMNS = (
    Column("frequency (Hz)", 1, 4), Column("drive (V)", 1, 3), Column("amplitude (um)", 1e6, 6),
    Column("phase (deg)", 180 / np.pi, 4), Column("direction", 1, 0),
)  # fmt: skip

Force = Callable[[float, float], float]


class Hidden(NamedTuple):
    """A force per mass that the linear model lacks, m/s², its name and its true parameters."""

    name: str
    force: Force
    parameters: dict[str, float]


def cubic(share: float) -> Hidden:
    """A spring that hardens by a share at the settled amplitude of 1 V."""
    k3 = share * OWN**2 / SIZE**2
    return Hidden("cubic-stiffness", lambda z, v: -k3 * z**3, {"cubic-stiffness.k3": k3})


def friction(share: float) -> Hidden:
    """Dry friction of a share of the drive's force at 1 V, turning within 2 % of the largest velocity."""
    size, turn = share * GAIN, 0.02 * OWN * SIZE
    return Hidden("coulomb-friction", lambda z, v: -size * np.tanh(v / turn), {"coulomb-friction.friction": size})


NOTHING = Hidden("nothing", lambda z, v: 0.0, {})


def passed(frequency: np.ndarray, level: float, hidden: Force, swept: bool, begun: float) -> np.ndarray:
    """(k,) complex amplitudes that a lock-in reads on the way through some frequencies, m; the drive was `begun` in a
    phase, in turns, that no table tells."""
    last = 30 * QUALITY / np.pi / FREQUENCY / 2  # s at the first frequency: fifteen ring-ups
    if swept:
        rate = RATE if frequency[-1] > frequency[0] else -RATE
        ends = last + (frequency - frequency[0]) / rate
        turns = lambda t: frequency[0] * t + (0.5 * rate * (t - last) ** 2 if t > last else 0.0)
    else:
        ends = last + HELD * np.arange(len(frequency))
        before = np.append(0.0, frequency[0] * last + HELD * np.append(0.0, np.cumsum(frequency[1:-1])))
        begins = np.concatenate([[0.0], ends])

        def turns(t: float) -> float:
            k = int(np.searchsorted(begins[1:-1], t))
            return before[k] + frequency[k] * (t - begins[k])

    def motion(t: float, y: np.ndarray) -> list[float]:
        phase = 2 * np.pi * (begun + turns(t))
        now = (turns(t + 1e-6) - turns(t - 1e-6)) / 2e-6  # Hz
        c, s = np.cos(phase), np.sin(phase)
        push = GAIN * level * c - OWN**2 * y[0] - OWN / QUALITY * y[1] + hidden(y[0], y[1])
        return [y[1], push, 2 * now * y[0] * c, -2 * now * y[0] * s]

    found = solve_ivp(motion, (0, ends[-1]), [0, 0, 0, 0], method="DOP853", rtol=1e-8, atol=1e-13, dense_output=True,
                      max_step=0.2 / FREQUENCY)  # fmt: skip
    starts = []
    whole = np.floor(AVERAGING * frequency + 1e-9)
    for end, many in zip(ends, whole, strict=True):  # so many turns before, by bisection
        low, high, target = end - 1.5 * many / BAND[0], end, turns(end) - many
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if turns(middle) < target else (low, middle)
        starts.append(low)
    change = found.sol(ends)[2:] - found.sol(np.array(starts))[2:]
    return (change[0] + 1j * change[1]) / whole


def write(folder: Path, seed: int, hidden: Hidden, effects: tuple[str, ...], swept: bool = True, told: bool = True,
          phase: bool = True) -> None:  # fmt: skip
    """A campaign of one table; whether it tells how fast it was run."""
    rng = np.random.default_rng([seed, 15])
    rising, parts = np.linspace(*BAND, POINTS), []
    for level in LEVELS:
        for way, f in ((1.0, rising), (-1.0, rising[::-1])):
            seen = passed(f, level, hidden.force, swept, rng.uniform())
            n = len(f)
            seen = seen * (1 + RELATIVE * rng.standard_normal(n)) * np.exp(1j * PHASE * rng.standard_normal(n))
            seen += CONSTANT * SIZE * (rng.standard_normal(n) + 1j * rng.standard_normal(n)) / np.sqrt(2)
            parts.append((f, np.full(n, level), np.abs(seen), np.angle(seen), np.full(n, way)))
    columns = tuple(np.concatenate(part) for part in zip(*parts, strict=True))
    kept = [k for k, c in enumerate(COLUMNS) if phase or "phase" not in c.heading]
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "sweeps.csv", tuple(COLUMNS[k] for k in kept), tuple(columns[k] for k in kept))
    record: dict[str, object] = {"file": "sweeps.csv", "kind": "sweep"}
    if told:
        record |= {"averaging": f"{AVERAGING} s"}
        record |= {"sweep_rate": f"{RATE} Hz/s"} if swept else {"dwell": f"{HELD} s"}
    head: dict[str, object] = {"title": "In a hurry", "device": {"kind": "oscillator", "output": "m"}}
    write_campaign(folder / "campaign.toml", head, effects, {}, [record])


def off(found: Fit, hidden: Hidden) -> tuple[np.ndarray, float]:
    """Errors of the parameters in standard errors, and the error over noise."""
    true = {"oscillator.frequency": FREQUENCY, "oscillator.quality": QUALITY, "oscillator.gain": GAIN}
    true |= hidden.parameters
    errors = np.array([(found[name].value - value) / (found[name].error or np.nan) for name, value in true.items()])
    return errors, found.fitted.error_over_noise


def independent(found: Fit, hidden: Hidden) -> float:
    """χ² of the parameters' errors by the whole covariance."""
    true = {"oscillator.frequency": FREQUENCY, "oscillator.quality": QUALITY, "oscillator.gain": GAIN}
    true |= hidden.parameters
    names = [found.model.parameters[i].name for i in found.free]
    own = [names.index(name) for name in true]
    wrong = np.array([found.value(name) - value for name, value in true.items()])
    return float(wrong @ np.linalg.solve(found.covariance[np.ix_(own, own)], wrong))


def recovered(first: int, devices: int) -> None:
    """Fit the right model to some devices, print and assert."""
    ends, squares = [], []
    with tempfile.TemporaryDirectory() as name:
        for k in range(devices):
            hidden, swept = cubic(0.02 + 0.02 * (k % 4)), k % 3 != 2
            folder = Path(name) / str(k)
            write(folder, first + k, hidden, (hidden.name,), swept)
            campaign = read_campaign(folder)
            begun = time.perf_counter()
            found = fit(build_model(campaign), campaign)
            seconds = time.perf_counter() - begun
            write(folder / "settled", first + k, hidden, (hidden.name,), swept, told=False)
            settled = read_campaign(folder / "settled")
            (errors, left), (wrong, misfit) = off(found, hidden), off(fit(build_model(settled), settled), hidden)
            ends.append((errors, left, np.max(np.abs(wrong)), misfit))
            squares.append(independent(found, hidden))
            print(f"{first + k} {'glides' if swept else 'steps'}: error over noise {left:.3f}, off by "
                  + ", ".join(f"{x:+.1f}" for x in errors) + f" standard errors, {seconds:.0f} s; taken as settled "
                  f"{misfit:.1f}, off by {np.max(np.abs(wrong)):.0f}", flush=True)  # fmt: skip
    errors = np.concatenate([e for e, *_ in ends])
    chance = float(chi2.sf(sum(squares), len(errors)))
    rms, largest = np.sqrt(np.mean(errors**2)), np.max(np.abs(errors))
    print(f"{len(errors)} parameters: rms {rms:.2f} standard errors, largest {largest:.1f}; by the whole covariance "
          f"chi2 {sum(squares):.0f} (p = {chance:.2f})")  # fmt: skip
    assert chance > 1e-3
    assert max(left for _, left, *_ in ends) < 1.15
    assert min(wrong for *_, wrong, _ in ends) > 10
    assert min(misfit for *_, misfit in ends) > 2


def named(first: int, hidden: Hidden, phase: bool) -> None:
    """Discover what a device has hidden, from the linear model, print and assert."""
    with tempfile.TemporaryDirectory() as name:
        write(Path(name), first, hidden, (), phase=phase)
        campaign, begun = read_campaign(name), time.perf_counter()
        found = discover(campaign).discovery
    steps = [(step.added, *step.tie_set[1:]) for step in found.steps]
    print(f"{first} {hidden.name}, {'with' if phase else 'without'} phase: {found.verdict}, {steps}, error over noise "
          f"{found.start.fitted.error_over_noise:.1f}, then {found.final.fitted.error_over_noise:.2f}, "
          f"{time.perf_counter() - begun:.0f} s", flush=True)  # fmt: skip
    assert steps[0][0] == hidden.name


def main() -> None:
    """Fit, discover, print and assert."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=15100)
    parser.add_argument("--devices", type=int, default=9)
    parser.add_argument("--hidden", default="cubic,friction", help="what is hidden; nothing: no discover")
    parser.add_argument("--phase", default="with,without")
    asked = parser.parse_args()
    if asked.devices:
        recovered(asked.first, asked.devices)
    for phase in asked.phase.split(","):
        for one in filter(None, asked.hidden.split(",")):
            named(asked.first + 500, {"cubic": cubic(0.05), "friction": friction(0.1)}[one], phase == "with")


if __name__ == "__main__":
    main()
