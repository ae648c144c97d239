"""A pendulum in air, let go: drag and softening, or one law with many shapes?

Run by `python -m experiments.ring_downs.two_simple`.

The angle of a pendulum with quadratic drag, integrated by SciPy, is read by a camera:

    φ̈ = −sin φ − φ̇/Q − d |φ̇| φ̇,    in units of the small oscillation

let go once, from one angle, or from three. A spring with memory has four numbers, which bend to as much loss and
softening as the two laws have; the records say which answer is simpler. Printed and asserted: what is named.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.diagnosis.diagnose import diagnose  # noqa: E402
from ident.diagnosis.search.steps import Discovery  # noqa: E402
from ident.effects.registry import Registry  # noqa: E402
from ident.fit import fit  # noqa: E402
from ident.fit.linear.start_model import start_model  # noqa: E402

PER_PERIOD = 20
LEVELS = {"one": (1.0,), "three": (1.0, 0.5, 0.75)}  # of the largest angle; the last of three is held out
HIDDEN = {"quadratic-damping", "cubic-stiffness"}
HALF_OF_THEM = 0.5


class Pendulum(NamedTuple):
    """What a seed draws: frequency (Hz), quality, drag per mass, the largest angle (rad), noise (rad)."""

    frequency: float
    quality: float
    drag: float
    angle: float
    noise: float
    seed: int


def draw(seed: int) -> Pendulum:
    """A pendulum."""
    rng = np.random.default_rng([seed, 41])
    within = lambda low, high: float(np.exp(rng.uniform(np.log(low), np.log(high))))
    angle = within(0.15, 0.6)
    return Pendulum(within(0.4, 2.0), within(150.0, 600.0), within(0.02, 0.1), angle, angle * within(0.001, 0.004),
                    seed)  # fmt: skip


def write(case: Pendulum, folder: Path, levels: tuple[float, ...], periods: int) -> None:
    """Its decays as a user has them."""
    rng, text = np.random.default_rng([case.seed, 43]), 'device = { kind = "oscillator", output = "rad" }\n'
    turns = 2 * np.pi * np.arange(periods * PER_PERIOD) / PER_PERIOD
    for k, level in enumerate(levels):
        motion = lambda _, y: (y[1], -np.sin(y[0]) - y[1] / case.quality - case.drag * abs(y[1]) * y[1])
        solved = solve_ivp(motion, (0, turns[-1]), (level * case.angle, 0.0), "DOP853", turns, rtol=1e-9, atol=1e-12)
        reading = solved.y[0] + case.noise * rng.standard_normal(len(turns))
        table = np.stack([turns / (2 * np.pi * case.frequency), reading], axis=1)
        np.savetxt(folder / f"decay_{k}.csv", table, "%.9g", ",", header="time (s),angle (rad)", comments="")
        text += f'[[record]]\nfile = "decay_{k}.csv"\nholdout = {str(0 < k == len(levels) - 1).lower()}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")


def found_in(
    case: Pendulum, levels: tuple[float, ...], periods: int = 60, library: Registry | None = None
) -> Discovery:
    """What the tool makes of it."""
    with tempfile.TemporaryDirectory() as folder:
        write(case, Path(folder), levels, periods)
        campaign = read_campaign(folder)
        return diagnose(fit(start_model(campaign), campaign), library).discovery


def main() -> None:
    """Print and assert."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=6, help="pendulums")
    parser.add_argument("--first", type=int, default=8100, help="the first seed")
    options = parser.parse_args()
    told = []
    for seed in range(options.first, options.first + options.seeds):
        for often, levels in LEVELS.items():
            case = draw(seed)
            found = found_in(case, levels)
            names = [step.added for step in found.steps if step.role == "effect"]
            walked = " > ".join("/".join(step.tie_set) for step in found.steps) or "nothing"
            told.append(set(names) >= HIDDEN or any(set(step.tie_set) >= HIDDEN for step in found.steps))
            print(f"seed {seed} let go from {often}, angle {case.angle:.2f}, drag {case.drag:.3f}, noise "
                  f"{case.noise / case.angle:.2%}: {found.verdict:14} {walked:60} "
                  f"{found.start.fitted.error_over_noise:.3g} -> {found.final.fitted.error_over_noise:.3f}",
                  flush=True)  # fmt: skip
    print(f"{len(told)} campaigns: drag and softening are the answer, or one of two, in {np.mean(told):.2f}")
    assert np.mean(told) > HALF_OF_THEM, told


if __name__ == "__main__":
    main()
