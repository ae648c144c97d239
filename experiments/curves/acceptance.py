"""Steady responses against long transients of an independent solver: `python -m experiments.curves.acceptance`.

A stressed platform with a hardening spring and hysteresis is swept at 7 levels, 60 frequencies, up and down. The
transients are those of `experiments.simulator`, which hold each frequency until the motion has settled.
`ident` gets the device's parameters and follows its curves. Compared are amplitudes, branches, and where the motion
jumps: the transients are led to each jump once more in steps of 0.02 Hz. Times are of the same run, the transient's
with 200 periods of 64 steps at each point, which near folds is too short.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from experiments.curves.sweeps import READ, fundamental
from experiments.make_campaigns import PAPER
from experiments.simulator.signals import sine
from experiments.simulator.stage import simulate
from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.effects.registry import built_in  # noqa: E402
from ident.model import Model, make_effect  # noqa: E402
from ident.response import Equation  # noqa: E402
from ident.response.branches import follow  # noqa: E402
from ident.response.controlled import Points, at_amplitude  # noqa: E402
from ident.response.periodic import Periodic, steps_per_period  # noqa: E402
from ident.response.sweep import Passed, run_along  # noqa: E402

DEVICE = replace(PAPER, cubic=1.2e10)
LEVELS = np.arange(3.0, 10.0)
FREQUENCIES = np.linspace(494.0, 529.0, 60)
LOT, MOST, STILL = 300, 20, 1e-6
"""Each frequency is held for lots of so many periods, at most so many, until the amplitude changes by no more than that
share from one to the next: within millihertz of a fold a motion lingers for a thousand periods before it jumps."""
SAMPLES = 64  # per period
STEPS = steps_per_period(0, 1e-5)  # of ident's solver: for the accuracy that is asked for
FINE, AROUND = 0.02, 0.3  # Hz
VALUES = {
    "platform.frequency": DEVICE.frequency, "platform.quality": DEVICE.quality, "platform.d31": DEVICE.d31,
    "residual-stress.sigma12": DEVICE.sigma12, "residual-stress.sigma23": DEVICE.sigma23,
    "residual-stress.restraint": DEVICE.restraint, "residual-stress.voltage_force": DEVICE.voltage_force,
    "cubic-stiffness.k3": DEVICE.cubic, "pzt-hysteresis.eta": DEVICE.eta, "pzt-hysteresis.zeta": DEVICE.zeta,
}  # fmt: skip


def held(f: float, level: float, state: tuple[float, float], periods: int, substeps: int) -> tuple[complex, tuple]:
    """The fundamental after a frequency was held for some periods, m, relative to the drive; the state then."""
    t = np.arange((periods + READ) * SAMPLES + 1) / (SAMPLES * f)
    z, v = simulate(DEVICE, sine(level, f), t, start=state, substeps=substeps)
    window = slice(-READ * SAMPLES - 1, -1)
    return fundamental(z[window], 2 * np.pi * f * t[window]), (float(z[-1]), float(v[-1]))


def settled(level: float, frequencies: np.ndarray) -> np.ndarray:
    """(k,) complex amplitudes of a pass in which the motion comes to rest at each frequency, m."""
    state, found = (0.0, 0.0), []
    for f in frequencies:
        before = np.inf
        for _ in range(MOST):
            one, state = held(f, level, state, LOT, 2)
            if abs(abs(one) - before) < STILL * before < np.inf:
                break
            before = abs(one)
        found.append(one)
    return np.array(found)


def transient(
    level: float, frequencies: np.ndarray, periods: int, substeps: int, start: float | None = None
) -> np.ndarray:
    """(k,) complex amplitudes of a pass, m; `start`: Hz at which it begins, in steps as those of the pass."""
    state, found = (0.0, 0.0), []
    if start is not None:
        for f in np.linspace(start, frequencies[0], 8):
            _, state = held(f, level, state, periods, substeps)
    for f in frequencies:
        one, state = held(f, level, state, periods, substeps)
        found.append(one)
    return np.array(found)


def device() -> Periodic:
    """The device as a model of ident."""
    campaign = read_campaign("data/platform_sweeps")
    model = Model(campaign.device)
    for name in ("residual-stress", "cubic-stiffness", "pzt-hysteresis"):
        model = model + make_effect(campaign, name, built_in())
    values = np.array([VALUES.get(p.name, 0.0) for p in model.parameters])
    return Periodic(Equation(model), values, STEPS)


def grid(model: Periodic, sizes: np.ndarray) -> list[tuple[Passed, Passed]]:
    """The passes at all levels, up and down."""
    band = np.array([FREQUENCIES[0] - 3, FREQUENCIES[-1] + 3])
    branches = follow(model, LEVELS, np.zeros(len(LEVELS)), band, sizes)
    found = []
    for branch in branches:
        scale = np.maximum(np.max(np.abs(branch.unknowns), axis=0), 1e-300)
        up, down = (run_along(model, branch, f, 0.0, False, scale) for f in (FREQUENCIES, FREQUENCIES[::-1]))
        found.append((up, down))
    return found


def jump(level: float, passed: Passed, frequencies: np.ndarray) -> float:
    """Where the transient jumps, Hz, led towards the fold that the model gives."""
    assert passed.fold is not None
    way = np.sign(frequencies[1] - frequencies[0])
    near = passed.fold.frequency + way * np.arange(-AROUND, AROUND + FINE / 2, FINE)
    found = np.abs(transient(level, near, 400, 2, start=frequencies[0]))
    k = int(np.argmax(np.abs(np.diff(found))))
    return float(near[k] + near[k + 1]) / 2


def timed(do: Callable[[], object], times: int) -> float:
    """Least of several, s by the clock: of milliseconds a machine that others use counts its processor time wrongly."""
    least = np.inf
    for _ in range(times):
        began = time.perf_counter()
        do()
        least = min(least, time.perf_counter() - began)
    return least


def main() -> None:
    """Compare, print and assert."""
    began = time.process_time()
    exact = [[settled(level, f) for f in (FREQUENCIES, FREQUENCIES[::-1])] for level in LEVELS]
    print(f"transients, {2 * LOT} periods a point or more: {time.process_time() - began:.0f} s of processor time")
    largest = max(float(np.max(np.abs(one))) for both in exact for one in both)
    sizes = np.array([max(float(np.max(np.abs(one))) for one in both) for both in exact])
    model = device()
    passes = grid(model, sizes)
    errors, wrong, folds = [], 0, []
    for level, both, mine in zip(LEVELS, exact, passes, strict=True):
        off = [np.abs(p.reading - np.abs(one)) / largest for one, p in zip(both, mine, strict=True)]
        jumps = []
        for p, f in zip(mine, (FREQUENCIES, FREQUENCIES[::-1]), strict=True):
            if p.fold is not None:
                jumps.append((p.fold.frequency, jump(level, p, f)))
        folds += [abs(a - b) for a, b in jumps]
        wrong += sum(int(np.sum(one > 0.02)) for one in off)
        errors += [np.concatenate(off)]
        told = ", ".join(f"{a:.3f} Hz (transient {b:.2f})" for a, b in jumps)
        print(
            f"{level:g} V: median {np.median(off):.1e}, largest {np.max(off):.1e} of the peak; jumps: {told or 'none'}"
        )
    error = np.concatenate(errors)
    print(f"{error.size} points: median error {np.median(error):.1e} of the maximum, {wrong} on a wrong branch, "
          f"jumps within {max(folds):.3f} Hz")  # fmt: skip
    slow = timed(lambda: [transient(v, f, 200, 1) for v in LEVELS for f in (FREQUENCIES, FREQUENCIES[::-1])], 1)
    fast = timed(lambda: grid(model, sizes), 5)
    print(f"up and down: transient {1e3 * slow:.0f} ms, curves {1e3 * fast:.0f} ms, {slow / fast:.0f} times faster")
    refined = refinement(model, passes)
    print(f"warm refinement and Jacobian of {len(LEVELS) * len(FREQUENCIES)} points, {len(model.values)} parameters: "
          f"{1e3 * refined:.1f} ms")  # fmt: skip
    assert np.median(error) <= 1e-5 and not wrong and max(folds) <= 0.1


def refinement(model: Periodic, passes: list[tuple[Passed, Passed]]) -> float:
    """s to find the responses of all points again after the parameters moved by 1e-4, and their
    derivatives."""
    up = [one for one, _ in passes]
    amplitude, n = np.concatenate([one.reading for one in up]), len(FREQUENCIES)
    at = Points(np.tile(FREQUENCIES, len(LEVELS)), np.repeat(LEVELS, n), amplitude, np.zeros(len(amplitude)),
                np.zeros(len(amplitude), bool))  # fmt: skip
    known = at_amplitude(model, at)
    assert known.converged.all()
    moved = Periodic(model.equation, model.values * (1 + 1e-4), model.steps)
    directions = np.diag(model.values)
    start = known.unknowns.copy()
    start[:, :-1] += np.einsum("dpk->pk", 1e-4 * known.moves(directions).unknowns)

    def refine() -> None:
        at_amplitude(moved, at, start.copy(), directions).moves(directions)

    return timed(refine, 30)


if __name__ == "__main__":
    main()
