"""Traces and sweeps of one device fitted together: `python -m experiments.curves.joint --devices 20`.

Each device of the independent simulator (a platform with a hardening spring and hysteresis) gives two records from rest
and four passes of a stepped sine. They are written as a laboratory would, read back with the noise estimated, and
fitted three times: the traces alone, the sweeps alone, both. Errors of the parameters in units of their standard errors
should have the standard deviation one, and no standard error of the joint fit be larger than either alone.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.curves.sweeps import READ, fundamental
from experiments.simulator.files import Column, write_campaign, write_csv
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, simulate
from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.fit import fit  # noqa: E402
from ident.model import build_model  # noqa: E402

EFFECTS = ("cubic-stiffness", "pzt-hysteresis")
LEVELS = (4.0, 8.0)
TRACES = ((8.0, 317.0), (6.0, 505.0))  # V, Hz
KINDS = ("traces", "sweeps", "both")
SAMPLES = 64  # per period of a sweep
SETTLED = 600  # periods that a frequency is held
TRACE_NOISE = 50e-9  # m
CONSTANT, RELATIVE, PHASE = 20e-9, 0.002, np.radians(0.2)  # noise of sweeps: m, fraction of the amplitude, rad
TRACE_COLUMNS = (Column("time (ms)", 1e3, 6), Column("drive (V)", 1, 5), Column("z (um)", 1e6, 4))
SWEEP_COLUMNS = (
    Column("frequency (Hz)", 1, 3), Column("drive (V)", 1, 3), Column("amplitude (um)", 1e6, 5),
    Column("phase (deg)", 180 / np.pi, 3), Column("direction", 1, 0),
)  # fmt: skip


@dataclass(frozen=True)
class Result:
    """A fit: errors of its free parameters in standard errors, and the standard errors, by name; and the `white`
    errors, (p,), in units of the whole covariance, which are independent of each other."""

    off: dict[str, float]
    errors: dict[str, float]
    white: np.ndarray


def draw(rng: np.random.Generator) -> Stage:
    """A device; at 8 V its resonance bends by up to some ten hertz, with jumps in about half of them."""
    return Stage(
        frequency=rng.uniform(480, 520), quality=rng.uniform(22, 40), d31=rng.uniform(40e-12, 70e-12),
        cubic=rng.uniform(0.3e10, 1.2e10), eta=rng.uniform(1e-23, 3e-23), zeta=rng.uniform(1e-23, 3e-23),
    )  # fmt: skip


def truth(stage: Stage) -> dict[str, float]:
    """The device's parameters under the names of the tool."""
    return {
        "platform.frequency": stage.frequency, "platform.quality": stage.quality, "platform.d31": stage.d31,
        "cubic-stiffness.k3": stage.cubic, "pzt-hysteresis.eta": stage.eta, "pzt-hysteresis.zeta": stage.zeta,
    }  # fmt: skip


def write(stage: Stage, rng: np.random.Generator, folder: Path) -> None:
    """One campaign of each kind, in folders of that name."""
    tables: dict[str, tuple[tuple[Column, ...], tuple[np.ndarray, ...]]] = {}
    for volts, f in TRACES:
        t = np.arange(1600) / (40 * f)
        z = simulate(stage, sine(volts, f), t, substeps=8)[0] + TRACE_NOISE * rng.standard_normal(len(t))
        tables[f"trace_{volts:g}V.csv"] = TRACE_COLUMNS, (t, sine(volts, f).value(t), z)
    for level in LEVELS:
        tables[f"sweep_{level:g}V.csv"] = SWEEP_COLUMNS, _swept(stage, level, rng)
    for kind in KINDS:
        own = folder / kind
        own.mkdir(parents=True)
        records: list[dict[str, object]] = []
        for file, (columns, values) in tables.items():
            what = file.split("_")[0]
            if kind in (f"{what}s", "both"):
                write_csv(own / file, columns, values)
                start: dict[str, object] = {"start": "rest"} if what == "trace" else {}
                records.append({"file": file, "kind": what} | start)
        write_campaign(own / "campaign.toml", {"title": f"A platform, {kind}"}, EFFECTS, {}, records)


def _swept(stage: Stage, level: float, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Columns of a sweep up and down again, the state carried on."""
    width = stage.frequency / stage.quality
    rising = stage.frequency + width * np.concatenate([np.linspace(-4, -1, 6), np.linspace(-0.8, 2.4, 26)])
    state, response, order = (0.0, 0.0), [], np.concatenate([rising, rising[::-1]])
    for f in order:
        t = np.arange((SETTLED + READ) * SAMPLES + 1) / (SAMPLES * f)
        z, v = simulate(stage, sine(level, f), t, start=state, substeps=2)
        state = (float(z[-1]), float(v[-1]))
        window = slice(-READ * SAMPLES - 1, -1)
        response.append(fundamental(z[window], 2 * np.pi * f * t[window]))
    n = len(order)
    seen = np.array(response) * (1 + RELATIVE * rng.standard_normal(n)) * np.exp(1j * PHASE * rng.standard_normal(n))
    seen += CONSTANT * (rng.standard_normal(n) + 1j * rng.standard_normal(n))
    way = np.repeat([1.0, -1.0], len(rising))
    return order, np.full(n, level), np.abs(seen), np.angle(seen), way


def fitted(folder: Path, true: dict[str, float]) -> Result:
    """A campaign fitted, against the truth."""
    campaign = read_campaign(folder)
    found = fit(build_model(campaign), campaign)
    names = [found.model.parameters[i].name for i in found.free]
    assert set(names) == set(true) and found.converged
    errors = np.sqrt(np.diag(found.covariance))
    off = (found.values[list(found.free)] - np.array([true[name] for name in names])) / errors
    white = np.linalg.solve(np.linalg.cholesky(found.covariance / np.outer(errors, errors)), off)
    by_name = lambda numbers: dict(zip(names, map(float, numbers), strict=True))
    return Result(by_name(off), by_name(errors), white)


def study(seeds: Sequence[int]) -> dict[str, list[Result]]:
    """The fits of all devices, by kind of campaign."""
    found: dict[str, list[Result]] = {kind: [] for kind in KINDS}
    for seed in seeds:
        rng = np.random.default_rng([seed, 41])
        stage = draw(rng)
        with tempfile.TemporaryDirectory() as folder:
            write(stage, rng, Path(folder))
            for kind in KINDS:
                found[kind].append(fitted(Path(folder) / kind, truth(stage)))
        told = (f"{kind} " + " ".join(f"{x:+.1f}" for x in found[kind][-1].off.values()) for kind in KINDS)
        print(f"seed {seed}: {'; '.join(told)}", flush=True)
    return found


def main() -> None:
    """Run, print and assert."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--devices", type=int, default=20)
    parser.add_argument("--first", type=int, default=5000, help="seed of the first device")
    options = parser.parse_args()
    found = study(range(options.first, options.first + options.devices))
    for kind, results in found.items():
        off = np.array([list(one.off.values()) for one in results])
        white = np.array([one.white for one in results])
        print(f"{kind}: {off.size} standardised errors, mean {np.mean(off):+.2f}, sd {np.std(off):.2f}, "
              f"largest {np.max(np.abs(off)):.1f}; of independent combinations mean {np.mean(white):+.2f}, "
              f"sd {np.std(white):.2f}")  # fmt: skip
        told = zip(results[0].off, np.std(off, axis=0), strict=True)
        print(f"  {', '.join(f'{name} {spread:.2f}' for name, spread in told)}")
    gains = {
        (kind, name): [both.errors[name] / one.errors[name]
                       for both, one in zip(found["both"], found[kind], strict=True) if name in one.errors]
        for kind in KINDS[:2] for name in found["both"][0].errors
    }  # fmt: skip
    for (kind, name), ratios in gains.items():
        print(f"standard error of {name}, both over {kind}: median {np.median(ratios):.2f}, largest {max(ratios):.2f}")
    chance = 2 / np.sqrt(2 * 6 * options.devices)  # two standard errors of a standard deviation
    for kind in KINDS:  # of the combinations: the errors of one device are correlated
        spread = float(np.std([one.white for one in found[kind]]))
        assert abs(spread - 1) < 0.1 + chance, (kind, spread)
    # Estimated noise floors differ from read to read by a few per cent.
    assert max(max(ratios) for ratios in gains.values()) < 1.05


if __name__ == "__main__":
    main()
