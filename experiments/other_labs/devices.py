"""Devices of 2 Hz to 30 kHz, driven in V, A, N and m/s², read in µm, mm, degrees, mm/s and m/s²."""

from __future__ import annotations

import numpy as np

from .lab import Lab, chirp, device, multisine, noise, oscillator, sine, solve, steps


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
