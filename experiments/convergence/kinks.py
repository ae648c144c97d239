"""What dividing steps at kinks gains: `python -m experiments.convergence.kinks`

Dry friction and a stop, driven by a sine, against SciPy going from kink to kink with the sign function itself.
Asserted: with divided steps the readings are right within a fifth of a noise of 10⁻⁴ V, and steps that are short
everywhere take more than six times as long for the same, of the stop twice.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, Measures, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.model import Model
from ident.response import Equation, Tape, divided, lay_out, respond

HERTZ, QUALITY, DRIVE, SIGMA = 10.0, 30.0, 40.0, 1e-4
OMEGA = 2 * np.pi * HERTZ
DRIVEN = 0.93 * OMEGA
FRICTION, STOP, GAP = 9.0, 50 * OMEGA**2, 0.1
VALUES = {
    "oscillator.frequency": HERTZ, "oscillator.quality": QUALITY, "oscillator.gain": 1.0,
    "coulomb-friction.friction": FRICTION, "coulomb-friction.velocity": 3e-4,
    "end-stop.above": STOP, "end-stop.below": 0.0, "end-stop.gap": GAP, "end-stop.exponent": 1.0,
    "end-stop.asymmetry": 1.0,
}  # fmt: skip


def record(sigma: float = SIGMA, measures: Measures = "displacement") -> Trace:
    """Six seconds of the sine, 40 samples in a period of the resonance."""
    t = np.arange(2401) / 400.0
    drive, channel = DRIVE * np.sin(DRIVEN * t), Channel("V", 1.0)
    told: dict[str, Any] = {"noise": NoiseFloor(sigma), "start": "rest", "measures": measures}
    return Trace("sine.csv", t, drive, 0.3 * drive / DRIVE, channel, channel, **told)


def model(effect: str) -> tuple[Model, np.ndarray]:
    """An oscillator with one effect, and the values of its parameters."""
    found = Model(Oscillator(), (built_in()[effect](),))
    return found, np.array([VALUES[p.name] for p in found.parameters])


def exact(
    force: Callable[[float, float, int], float], switch: Callable[[float, float], float], at: np.ndarray,
    begun: float = 0.0,
) -> np.ndarray:  # fmt: skip
    """Displacement, zero until `begun`, under a force of (z, v, side) whose side changes where `switch` of (z, v) is
    zero: SciPy's Runge-Kutta method of order 8 from one such place to the next."""
    side, y, found = 0, np.zeros(2), np.zeros_like(at)

    def rates(t: float, y: np.ndarray, side: int) -> tuple[float, float]:
        pushed = DRIVE * math.sin(DRIVEN * t) + force(y[0], y[1], side)
        return y[1], pushed - OMEGA / QUALITY * y[1] - OMEGA**2 * y[0]

    def met(t: float, y: np.ndarray, side: int) -> float:
        return switch(*y) if t > begun + 1e-9 else switch(*(y + 1e-9 * np.array(rates(t, y, side))))

    met.terminal = True  # type: ignore[attr-defined]
    while begun < at[-1]:
        ahead = y + 1e-9 * np.array(rates(begun, y, side))
        side = 1 if switch(*ahead) > 0 else -1
        run = solve_ivp(rates, (begun, at[-1]), y, args=(side,), events=met, method="DOP853", rtol=1e-11, atol=1e-14,
                        dense_output=True)  # fmt: skip
        inside = (at >= begun) & (at <= run.t[-1])
        found[inside] = run.sol(at[inside])[0]
        begun, y = float(run.t[-1]), run.y[:, -1]
    return found


def friction(at: np.ndarray) -> np.ndarray:
    """Displacement under dry friction, which sticks until the drive is larger."""
    loose = math.asin(FRICTION / DRIVE) / DRIVEN + 1e-6
    return exact(lambda z, v, side: -FRICTION * side, lambda z, v: v, at, loose)


def stop(at: np.ndarray) -> np.ndarray:
    """Displacement with a stop above."""
    return exact(lambda z, v, side: -STOP * (z - GAP) if side > 0 else 0.0, lambda z, v: z - GAP, at)


TRUTH = {"coulomb-friction": friction, "end-stop": stop}
LONGER = {"coulomb-friction": 6.0, "end-stop": 2.0}  # as long, at least


def simulated(tape: Tape, effect: str) -> tuple[np.ndarray, float]:
    """The readings, and the shortest time of five simulations with derivatives along four directions, s."""
    system, values = model(effect)
    along, kicks, still = 1e-3 * np.diag(values)[:4], np.zeros((4, 1, 2)), np.zeros((1, 2))
    call = lambda: respond(Equation(system), tape, values, still, along, kicks)
    found, taken = call(), np.inf
    for _ in range(5):
        begun = time.perf_counter()
        jax.block_until_ready(call().marches)
        taken = min(taken, time.perf_counter() - begun)
    return found.readings, taken


def main() -> None:
    """Print the table and assert."""
    trace = record()
    print(f"{'effect':18} {'steps':>22} {'error/noise':>12} {'ms':>7}")
    for effect, truth in TRUTH.items():
        wanted = truth(trace.time)
        missed = lambda found, wanted=wanted: float(np.max(np.abs(found - wanted))) / SIGMA
        tape = lay_out([trace], HERTZ, QUALITY, model(effect)[0])
        found, taken = simulated(tape, effect)
        own = tape.spans[0].substeps
        print(f"{effect:18} {own * 40:>9} and divided {missed(found):12.3f} {1e3 * taken:7.1f}")
        assert missed(found) < 0.2
        for steps in (own, 4 * own, 16 * own, 64 * own):
            plain, longer = simulated(divided([trace], [steps], np.inf), effect)
            print(f"{'':18} {steps * 40:>9} in a period {missed(plain):12.3f} {1e3 * longer:7.1f}")
            if missed(plain) <= 1.1 * missed(found):
                break
        assert longer > LONGER[effect] * taken


if __name__ == "__main__":
    main()
