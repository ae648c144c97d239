"""Records as other laboratories write them: `python -m experiments.other_labs [SEED] [device…]`

Devices of 2 Hz to 30 kHz, driven in V, A, N and m/s², read in µm, mm, degrees, mm/s and m/s², by sines, chirps,
multisines, noise, steps and decays, with offsets, rounded times, few bits and coloured noise; SciPy's adaptive solver,
force laws written here. Each is given to `ident new` and `ident discover`, whose word is final. Asserted: the hidden
effect is named or a tie names it, nothing else is, what the library cannot have is not called known, held-out error
does not grow, and the noise floor is reached unless it stands beside the device that it is not.
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, sosfiltfilt

Signal = Callable[[np.ndarray | float], np.ndarray]
OFFSETS = frozenset({"sensor-offset", "static-force"})
"""A level, which is in many records and no fault to name."""


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


@device("cubic-stiffness")
def mems(lab: Lab, rng: np.random.Generator) -> None:
    """Bursts of 7 ms at 12 kHz, µm, from rest, zero of the sensor off."""
    f = 11.7e3 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(3200) / (40 * f)
    for i, (size, ratio) in enumerate([(0.3, 0.99), (1.0, 1.0), (1.5, 1.02), (1.2, 0.97)]):
        u = sine(size, f * ratio)
        z = solve(oscillator(f, 45, 0.05 * w2, u, lambda z, v, u, t: -0.02 * w2 * z**3), t, [0, 0])[0]
        lab.write(f"burst{i}", "time (us),Drive (V),z (um)", 1e6 * t, u(t), z, noise=0.008, bits=12, digits=3,
                  offset=0.03, held=i == 3)  # fmt: skip


@device("coulomb-friction", floor=False)
def bench(lab: Lab, rng: np.random.Generator) -> None:
    """A rig of 2.3 kg at 5 Hz, N and mm; friction turns over 1/4000 of the largest speed, finer than the model's."""
    f, t = 5.2 * rng.uniform(0.9, 1.1), np.arange(4000) / 400
    for i, size in enumerate([2.5, 5, 9, 6]):
        u = multisine(rng, size, 1, 14, 0.2)
        z = solve(oscillator(f, 12, 1 / 2.3, u, lambda z, v, u, t: -1.1 / 2.3 * np.tanh(v / 2e-4)), t, [0, 0])[0]
        lab.write(f"run{i}", "t (s),Force (N),displacement (mm)", t, u(t), 1e3 * z, colour=0.6, digits=4, held=i == 3)


@device("quadratic-damping")
def voice_coil(lab: Lab, rng: np.random.Generator) -> None:
    """A stage without a spring, A and mm, with drag."""
    push, t = 11 * rng.uniform(0.9, 1.1), np.arange(4000) / 500
    for i, size in enumerate([0.15, 0.35, 0.6, 0.45]):
        u = multisine(rng, size, 0.5, 12, 0.25)
        rates = lambda t, y, u=u: [y[1], (push * float(u(t)) - 1.2 * y[1] - 14 * abs(y[1]) * y[1]) / 0.35]
        lab.write(f"stage{i}", "t (ms),Current (A),Position (mm)", 1e3 * t, u(t), 1e3 * solve(rates, t, [0, 0])[0],
                  noise=0.004, bits=14, digits=1, held=i == 3)  # fmt: skip


@device("end-stop")
def valve(lab: Lab, rng: np.random.Generator) -> None:
    """Overdamped, A and mm, with a stop on one side."""
    f, t = 40 * rng.uniform(0.9, 1.1), np.arange(4000) / 2000
    w2 = (2 * np.pi * f) ** 2
    for i, size in enumerate([0.3, 0.5, 0.8, 0.6]):
        u = noise(rng, size, 0.5, 60, t[-1])
        stop = lambda z, v, u, t: -12 * w2 * max(z - 0.35e-3, 0.0)
        z = solve(oscillator(f, 0.22, 1e-3 * w2, u, stop), t, [0, 0])[0]
        lab.write(f"valve{i}", "time (s),coil (A),lift (mm)", t, u(t), 1e3 * z, offset=0.02, held=i == 3)


@device("end-stop")
def probe(lab: Lab, rng: np.random.Generator) -> None:
    """A cantilever shaken by its base, V and nm, that hits a wall ten times as stiff; one record does not."""
    f = 14e3 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(4000) / (40 * f)
    for i, size in enumerate([0.3, 1.0, 2.0, 1.5]):
        u = sine(size, f * (0.985 + 0.01 * i))
        stop = lambda z, v, u, t: -9 * w2 * max(z - 70.0, 0.0)
        z = solve(oscillator(f, 60, 1.6 * w2, u, stop), t, [0, 0], most=0.02 / f)[0]
        lab.write(f"tip{i}", "t (us),piezo (V),deflection (nm)", 1e6 * t, u(t), z, noise=0.008, digits=4, held=i == 3)


@device("coulomb-friction")
def struck(lab: Lab, rng: np.random.Generator) -> None:
    """A joint that rubs, struck twice by a hammer, N and m/s²: no frequency is free of motion."""
    f, t = 34 * rng.uniform(0.9, 1.1), np.arange(4096) / 2048
    blow = lambda t, at: np.sin(np.pi * np.clip((t - at) / 4e-3, 0, 1)) ** 2
    for i, size in enumerate([60, 140, 250, 180]):
        u = lambda t, size=size: size * (blow(np.asarray(t), 0.05) - blow(np.asarray(t), 0.9))
        rates = oscillator(f, 45, 1 / 3.2, u, lambda z, v, u, t: -0.5 * np.tanh(v / 1e-3))
        a = [rates(at, y)[1] for at, y in zip(t, solve(rates, t, [0, 0], most=5e-4).T, strict=True)]
        lab.write(f"hit{i}", "time_s,hammer_N,acc_m_s2", t, u(t), np.array(a), noise=0.006, digits=6, held=i == 3)


@device("cubic-damping")
def decays(lab: Lab, rng: np.random.Generator) -> None:
    f, t = 63 * rng.uniform(0.9, 1.1), np.arange(5000) / 2000
    for i, size in enumerate([4, 2.2, 0.8, 3]):
        phase = rng.uniform(0, 6)
        start = [size * np.cos(phase), -2 * np.pi * f * size * np.sin(phase)]
        z = solve(oscillator(f, 180, 0, None, lambda z, v, u, t: -2 * z * z * v), t, start)[0]
        lab.write(f"decay{i}", "t (s),tip (mm)", t, None, z, noise=0.012, bits=12, offset=0.05, digits=4, held=i == 3)


@device("coulomb-friction")
def vibrometer_decays(lab: Lab, rng: np.random.Generator) -> None:
    f, t = 22 * rng.uniform(0.9, 1.1), np.arange(3500) / 1000
    force = 0.06 * (2 * np.pi * f) ** 2
    for i, size in enumerate([9.0, 5.0, 7.0]):
        v = solve(oscillator(f, 60, 0, None, lambda z, v, u, t: -force * np.tanh(v / 0.5)), t, [size, 0])[1]
        lab.write(f"ring{i}", "t (s),velocity (mm/s)", t, None, v, digits=3, held=i == 2)


@device("cubic-stiffness", "quadratic-damping")
def pendulum(lab: Lab, rng: np.random.Generator) -> None:
    """sin, and drag: decays from 0.5 to 1.1 radian."""
    f, t = 1.9 * rng.uniform(0.9, 1.1), np.arange(2400) / 60
    w = 2 * np.pi * f
    for i, size in enumerate([0.9, 0.5, 1.1, 0.7]):
        rates = lambda t, y: [y[1], -w * w * np.sin(y[0]) - w / 90 * y[1] - 0.12 * abs(y[1]) * y[1]]
        z = solve(rates, t, [size, 0])[0]
        lab.write(f"pend{i}", "time (s),angle (rad)", t, None, z, bits=11, digits=3, held=i == 3)


@device("creep|viscoelastic-support", floor=False)
def heater(lab: Lab, rng: np.random.Generator) -> None:
    """Quasi-static steps, V and µm, creeping in 1.3 and 14 s."""
    gain, t = 1.35 * rng.uniform(0.9, 1.1), np.arange(2400) / 20
    for i, size in enumerate([10, 20, 15]):
        u = steps(size * rng.uniform(0, 1, 10), t[-1], 0.5)
        late = solve(lambda t, y, u=u: [(float(u(t)) - y[0]) / 1.3, (float(u(t)) - y[1]) / 14], t, [0, 0], most=0.05)
        z = gain * (0.68 * u(t) + 0.12 * late[0] + 0.2 * late[1])
        lab.write(f"steps{i}", "time [s],heater (V),position (um)", t, u(t), z, noise=0.003, offset=2.3, digits=2,
                  held=i == 2)  # fmt: skip


@device("voltage-stiffness")
def stiffness_by_drive(lab: Lab, rng: np.random.Generator) -> None:
    f, t = 18 * rng.uniform(0.9, 1.1), np.arange(4800) / 800
    w2 = (2 * np.pi * f) ** 2
    for i, size in enumerate([0.3, 0.6, 1.0, 0.8]):
        u = noise(rng, size, 2, 60, t[-1])
        z = solve(oscillator(f, 25, 0.6 * w2, u, lambda z, v, u, t: -0.12 * w2 * u * z), t, [0, 0], 0.05)[0]
        lab.write(f"par{i}", "t (s),u (V),angle (deg)", t, u(t), z, held=i == 3)


@device("static-force")
def tilted(lab: Lab, rng: np.random.Generator) -> None:
    """A mass on a base that is shaken, m/s² and mm; its weight comes with the drive."""
    f, t = 8.5 * rng.uniform(0.9, 1.1), np.arange(3000) / 300
    for i, size in enumerate([1.0, 2.0, 3.0, 2.2]):
        u = multisine(rng, size, 1, 25, 0.1)
        z = solve(oscillator(f, 4, 1, u, lambda z, v, u, t: 1.4), t, [0, 0])[0]
        lab.write(f"b{i}", "t (s),acc_base (m/s^2),x (mm)", t, u(t), 1e3 * z, bits=12, digits=4, held=i == 3)


@device("second-mode")
def neighbour(lab: Lab, rng: np.random.Generator) -> None:
    f, t = 260 * rng.uniform(0.9, 1.1), np.arange(5000) / 6000
    w = 2 * np.pi * f
    for i, size in enumerate([1.0, 2.5, 1.7]):
        u = multisine(rng, size, 100, 600, 3)
        v = (
            solve(oscillator(f, 30, w * w, u), t, [0, 0])[1]
            + solve(oscillator(1.32 * f, 45, -0.3 * w * w, u), t, [0, 0])[1]
        )
        lab.write(f"mod{i}", "t (s),drive (V),velocity (mm/s)", t, u(t), v, held=i == 2)


@device()
def linear_mems(lab: Lab, rng: np.random.Generator) -> None:
    """30 kHz, a zero that is off, coloured noise; some records are taken for begun in motion."""
    f = 31e3 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(4000) / (10 * f)
    for i, (size, ratio) in enumerate([(0.5, 1.0), (1.5, 0.995), (3.0, 1.01), (2.0, 0.98)]):
        u = sine(size, f * ratio) if i else chirp(1, 0.8 * f, 1.2 * f, t[-1])
        z = solve(oscillator(f, 140, 0.02 * w2, u), t, [0, 0])[0]
        lab.write(f"s{i}", "time (us),Drive (V),z (um)", 1e6 * t, u(t), z, noise=0.02, colour=0.8, offset=0.1, bits=10,
                  digits=2, held=i == 3)  # fmt: skip


@device()
def fork(lab: Lab, rng: np.random.Generator) -> None:
    f, t = 440 * rng.uniform(0.9, 1.1), np.arange(6000) / 8000
    for i, size in enumerate([3.0, 1.0, 2.0]):
        v = solve(oscillator(f, 320, 0, None), t, [size, 0.4 * np.pi * f * size])[1]
        lab.write(f"fork{i}", "t (s),velocity (m/s)", t, None, 1e-3 * v, noise=0.015, bits=12, digits=6, held=i == 2)


@device()
def accelerometer(lab: Lab, rng: np.random.Generator) -> None:
    """N to m/s², zero off."""
    f, t = 14 * rng.uniform(0.9, 1.1), np.arange(4000) / 500
    w = 2 * np.pi * f
    for i, size in enumerate([20, 50, 35]):
        u = noise(rng, size, 1, 60, t[-1])
        z, v = solve(oscillator(f, 3, 1 / 25, u), t, [0, 0], 0.1)
        lab.write(f"a{i}", "t (s),force (N),acceleration (m/s^2)", t, u(t), u(t) / 25 - w * w * z - w / 3 * v,
                  offset=0.08, bits=12, digits=4, held=i == 2)  # fmt: skip


@device(beyond=True, floor=False)
def groove(lab: Lab, rng: np.random.Generator) -> None:
    """A ball that rolls over grooves 1.7 mm apart: a force periodic in the displacement."""
    f, t = 6 * rng.uniform(0.9, 1.1), np.arange(4500) / 400
    for i, size in enumerate([0.8, 2.0, 4.0, 3.0]):
        u = noise(rng, size, 0.5, 15, t[-1])
        law = lambda z, v, u, t: -0.5 * np.sin(2 * np.pi * z / 1.7e-3 + 0.7)
        z = solve(oscillator(f, 15, 1, u, law), t, [0, 0])[0]
        lab.write(f"g{i}", "t (s),F (N),x (mm)", t, u(t), 1e3 * z, digits=4, held=i == 3)


def discovered(name: str, seed: int, folder: Path) -> tuple[dict, float]:
    """diagnosis.json of `ident discover` on the campaign that `ident new` writes, and CPU seconds."""
    rng = np.random.default_rng([seed, list(DEVICES).index(name)])
    lab = Lab(folder, rng)
    DEVICES[name].write(lab, rng)
    ident, here = [sys.executable, "-m", "ident"], os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    files = sorted(map(str, folder.glob("*.csv")))
    subprocess.run([*ident, "new", str(folder / "mine"), *files], env=here, check=True, capture_output=True)
    toml = folder / "mine" / "campaign.toml"
    text = re.sub(r"^holdout = true.*\n", "", toml.read_text(), flags=re.M)
    for held in lab.held:
        text = re.sub(rf'(^file = ".*{held}"\n)', r"\1holdout = true\n", text, flags=re.M)
    if "\ndevice = " not in text:  # V and µm are those of the platform: say that it is none
        text = text.replace("[model]", 'device = { kind = "oscillator", output = "m" }\n[model]', 1)
    toml.write_text(text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [*ident, "discover", str(toml.parent), "-o", str(folder / "run")]
    subprocess.run(command, env=here, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return json.loads((folder / "run" / "diagnosis.json").read_text()), seconds


def judge(name: str, found: dict) -> str:
    """ "right", "right, with a doubt", "doubt" (a wrong name, not called sure) or "wrong"."""
    hidden, final = DEVICES[name].hidden, set(found["final"]["effects"]) - OFFSETS
    sure = found["verdict"] in ("identified", "adequate")
    if hidden is None:
        return "wrong" if sure else "right"
    tied = [set(step["tie_set"]) | {step["added"]} for step in found["steps"]]
    named = all(names & (final | {*found["final"]["effects"]} | set().union(*tied)) for names in hidden)
    extra = final - frozenset().union(*hidden)
    if named and not extra:
        return "right" if sure or any(len(tie) > 1 for tie in tied) else "right, with a doubt"
    return "wrong" if sure else "doubt"


def main() -> None:
    """Run the devices that are named, or all, and assert what stands beside them."""
    seed, wrong = int(sys.argv[1]) if len(sys.argv) > 1 else 1, list[str]()
    for name in sys.argv[2:] or DEVICES:
        try:
            with tempfile.TemporaryDirectory() as folder:
                found, seconds = discovered(name, seed, Path(folder))
        except subprocess.CalledProcessError as crash:
            print(f"{name:20s} crash: {crash.stderr.decode().splitlines()[-1]}", flush=True)
            wrong.append(name)
            continue
        start, final, verdict = found["start"], found["final"], judge(name, found)
        told = lambda what: f"{what['error_over_noise']:.2f} | {what['holdout_error_over_noise']:.2f}"
        words = f"{verdict:20s} {found['verdict']:15s} {', '.join(final['effects']) or '-'}"
        print(f"{name:20s} {words}: {told(start)} → {told(final)}, {seconds:.0f} s", flush=True)
        held, floor = (
            final["holdout_error_over_noise"],
            max(final["error_over_noise"], final["holdout_error_over_noise"]),
        )
        kept = held <= 1.02 * start["holdout_error_over_noise"] and (floor < 1.2 or not DEVICES[name].floor)
        wrong += [] if verdict.startswith("right") and kept else [name]
    assert not wrong, wrong


if __name__ == "__main__":
    main()
