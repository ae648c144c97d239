"""Free decays with one hidden effect: is it named, and are its numbers right?  `python -m experiments.ring_downs.study`

A device rings down three times, from a large, a middle and (held out) another displacement, integrated by SciPy from
force laws of this file. The tool sees tables of time and displacement, and nothing else. Printed and asserted: how
often the hidden effect is named first, and the standardised errors of its size and of the natural frequency.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads wait by spinning, beside those of XLA; before NumPy

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.diagnosis.diagnose import discover  # noqa: E402
from ident.diagnosis.search.steps import Discovery  # noqa: E402

PERIODS, PER_PERIOD = 60, 24
LEVELS = (1.0, 0.55, 0.8)  # of the largest displacement; the last is held out
NAMED_FIRST, SPREAD = 0.95, (0.7, 1.3)  # the spread of few cases is itself known to some 15 % only


class Hidden(NamedTuple):
    """A law: its `force` per mass at displacement x and velocity v in units of the amplitude and of ω0 times it, for a
    coefficient of one; the parameter that it is, as powers of amplitude and ω0; and how large it is drawn."""

    force: Callable[[float, float], float]
    parameter: str
    amplitude_power: int
    omega_power: int
    sizes: tuple[float, float]


LAWS = {
    "cubic-stiffness": Hidden(lambda x, v: -(x**3), "k3", -2, 2, (0.01, 0.06)),
    "coulomb-friction": Hidden(lambda x, v: -float(np.tanh(v / 2e-3)), "friction", 1, 2, (0.001, 0.004)),
    "quadratic-damping": Hidden(lambda x, v: -abs(v) * v, "c2", -1, 0, (0.005, 0.03)),
    "cubic-damping": Hidden(lambda x, v: -(v**3), "c3", -2, -1, (0.01, 0.04)),
}


class Case(NamedTuple):
    """What a seed draws: natural frequency (Hz), quality, largest displacement (m), size of the law, and noise as a
    share of that displacement."""

    name: str
    frequency: float
    quality: float
    amplitude: float
    size: float
    noise: float
    seed: int

    @property
    def truth(self) -> float:
        """The law's parameter in SI, per mass."""
        law = LAWS[self.name]
        return self.size * self.amplitude**law.amplitude_power * (2 * np.pi * self.frequency) ** law.omega_power


def draw(name: str, seed: int) -> Case:
    """A device with one hidden law."""
    rng = np.random.default_rng([seed, sorted(LAWS).index(name)])
    within = lambda low, high: float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return Case(name, within(0.5, 800.0), within(60.0, 500.0), within(1e-6, 0.05), within(*LAWS[name].sizes),
                within(0.001, 0.005), seed)  # fmt: skip


def write(case: Case, folder: Path) -> None:
    """The decays as a user has them."""
    law, rng = LAWS[case.name], np.random.default_rng([case.seed, 99])
    text = 'device = { kind = "oscillator", output = "m" }\n'
    turns = 2 * np.pi * np.arange(PERIODS * PER_PERIOD) / PER_PERIOD
    for k, level in enumerate(LEVELS):
        motion = lambda _, y: (y[1], -y[0] - y[1] / case.quality + case.size * law.force(y[0], y[1]))
        begin = level * np.array([np.cos(1.0 + k), np.sin(1.0 + k)])
        solved = solve_ivp(motion, (0, turns[-1]), begin, "DOP853", turns, rtol=1e-9, atol=1e-12, max_step=0.05)
        reading = case.amplitude * (solved.y[0] + case.noise * rng.standard_normal(len(turns)))
        table = np.stack([turns / (2 * np.pi * case.frequency), reading], axis=1)
        np.savetxt(folder / f"decay_{k}.csv", table, "%.12g", ",", header="time (s),displacement (m)", comments="")
        text += f'[[record]]\nfile = "decay_{k}.csv"\nholdout = {str(k == len(LEVELS) - 1).lower()}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")


def found_in(case: Case) -> Discovery:
    """What the tool makes of it."""
    with tempfile.TemporaryDirectory() as folder:
        write(case, Path(folder))
        campaign = read_campaign(folder)
        return discover(campaign).discovery


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=50, help="cases of each effect")
    parser.add_argument("--first", type=int, default=6000, help="the first seed")
    options = parser.parse_args()
    named, standard = [], []
    for seed in range(options.first, options.first + options.seeds):
        for name in LAWS:
            case = draw(name, seed)
            found = found_in(case)
            last = found.final
            named.append(bool(found.steps) and found.steps[0].added == name)
            off = []
            if name in last.model.names:
                for full, truth in ((f"{name}.{LAWS[name].parameter}", case.truth), ("frequency", case.frequency)):
                    one = last[full]
                    off += [(one.value - truth) / one.error] if one.error else []
            standard += off
            after = "" if last.holdout is None else f"{last.holdout.error_over_noise:.3f}"
            walked = " > ".join("/".join(step.tie_set) for step in found.steps) or "nothing"
            shown = " ".join(f"{x:+.1f}" for x in off)
            print(
                f"seed {seed} {name:18} Q {case.quality:5.0f} size {case.size:.4f} noise {case.noise:.2%}: "
                f"{found.verdict:14} {walked:50} {found.start.fitted.error_over_noise:.3g} -> "
                f"{last.fitted.error_over_noise:.3f} held out {after} standardised {shown}",
                flush=True,
            )
    share, spread = float(np.mean(named)), float(np.sqrt(np.mean(np.square(standard)))) if standard else float("nan")
    print(
        f"{len(named)} cases: hidden effect named first {share:.3f}; standardised errors {spread:.2f} ({len(standard)})"
    )
    assert share >= NAMED_FIRST and SPREAD[0] <= spread <= SPREAD[1], (share, spread)


if __name__ == "__main__":
    main()
