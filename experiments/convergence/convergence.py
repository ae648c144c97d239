"""Do fits reach the minimum, wherever they start?  `python -m experiments.convergence.convergence`

1. One record of 4000 samples, 8 V at 317 Hz from rest, eight fitted parameters (σ23 held, because σ12 and σ23 cannot be
   told apart): 20 of 20 starts with every parameter moved by up to ±30 % of its true value must reach one minimum.
2. The first 100 campaigns of `experiments/recovery`, fitted from what `ident` reads off the records, must each reach
the
   minimum that is found from the truth, or a lower one.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np
from rich.progress import track

from experiments.recovery.campaigns import DRIVE_NOISE, PARAMETERS, Case, draw
from experiments.recovery.recovery import model
from experiments.simulator import noise
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, simulate
from ident.campaign.campaign import Campaign
from ident.campaign.period import find_period
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import Fit, fit
from ident.model import Model

SAMPLES = 4000
STARTS, SPREAD = 20, 0.3
CAMPAIGNS = 100
SAME = 0.1  # standard errors by which any parameter may differ between two ends at one minimum
LOWER = 0.5  # in χ²: by less no minimum counts as lower than another (their solver steps may differ by a little)

STAGE = Stage(
    frequency=498.6, quality=31.0, d31=200e-12, closure="axial-force", sigma12=80.6e6, sigma23=45.7e6,
    restraint=0.8, voltage_force=5e-3, eta=7e-23, zeta=5e-23,
)  # fmt: skip


def record() -> Campaign:
    """One record, 8 V at 317 Hz from rest, 80 samples per period, noise 50 nm."""
    rng = np.random.default_rng(8)
    t = np.arange(SAMPLES) / (80 * 317)
    drive = sine(8, 317)
    volts = drive.value(t) + noise.white(rng, SAMPLES, DRIVE_NOISE)
    response = simulate(STAGE, drive, t)[0] + noise.white(rng, SAMPLES, 50e-9)
    floor = NoiseFloor(50e-9, (), "given")
    channels = Channel("V", 1.0), Channel("m", 1.0)
    trace = Trace("8 V at 317 Hz", t, volts, response, *channels, floor, start="rest", period=find_period(volts))
    return Campaign("one record", (trace,))


def eight(stage: Stage = STAGE) -> Model:
    """The model with σ23 held at its true value: eight fitted parameters."""
    held = "residual-stress.sigma23"
    return replace(model(), start=((held, stage.sigma23),), held=frozenset({held}))


def true_values(of: Model, stage: Stage) -> np.ndarray:
    """Values of all parameters of a model at the truth, SI."""
    return np.array(
        [float(getattr(stage, PARAMETERS[p.name])) if p.name in PARAMETERS else p.value for p in of.parameters]
    )


def starts(of: Model, stage: Stage, count: int = STARTS, seed: int = 1) -> list[np.ndarray]:
    """Random points with every fitted parameter moved by up to ±30 %."""
    fitted = np.array([p.fitted for p in of.parameters])
    moves = np.random.default_rng(seed).uniform(1 - SPREAD, 1 + SPREAD, (count, len(fitted)))
    return [np.where(fitted, move, 1.0) * true_values(of, stage) for move in moves]


def error(found: Fit) -> float:
    return found.fitted.error_over_noise


def from_thirty_per_cent(count: int = STARTS) -> list[Fit]:
    """One fit per start."""
    of, campaign = eight(), record()
    return [fit(of, campaign, initial=point) for point in track(starts(of, STAGE, count), "starts")]


def reaches(found: Fit, known: Fit) -> bool:
    """Whether a fit ended at the minimum of another one, or at a lower one."""
    pairs = [(a, b) for a, b in zip(found.estimates, known.estimates, strict=True) if b.standard_error is not None]
    apart = max(abs(a.value - b.value) / float(b.standard_error or 1.0) for a, b in pairs)
    lower = known.fitted.n * (error(known) ** 2 - error(found) ** 2)
    return found.converged and (apart < SAME or lower > LOWER)


def from_guess_and_truth(case: Case) -> tuple[Fit, Fit]:
    """The fit from the records' own guess, and the fit from the truth."""
    of = model()
    return fit(of, case.campaign), fit(of, case.campaign, initial=true_values(of, case.stage))


def check_starts(fits: list[Fit]) -> None:
    """Assert that all starts ended at one minimum, at the noise, with eight determined parameters."""
    best = min(fits, key=error)
    assert 0.95 < error(best) < 1.05, error(best)
    assert all(reaches(found, best) for found in fits), [error(found) for found in fits]
    assert sum(e.standard_error is not None for e in best.estimates) == 8


def check_campaigns(reached: list[bool]) -> None:
    """Assert that every guess led to the minimum that the truth leads to."""
    assert all(reached), [seed for seed, there in enumerate(reached) if not there]


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    options = parser.parse_args()
    fits = from_thirty_per_cent()
    best = min(fits, key=error)
    reached = sum(reaches(found, best) for found in fits)
    steps = [f.starts[0].steps for f in fits]
    print(f"{reached} of {len(fits)} starts at ±30 % reach one minimum, error over noise {error(best):.4f}, "
          f"{min(steps)} to {max(steps)} steps")  # fmt: skip
    for e in best.estimates:
        if e.standard_error is not None:
            print(f"  {e.name:32} {e.value:12.5g} ± {e.standard_error:.2g} {e.unit}")
    check_starts(fits)
    there = [reaches(*from_guess_and_truth(draw(seed))) for seed in track(range(options.campaigns), "campaigns")]
    print(f"{sum(there)} of {len(there)} campaigns reach from their guess the minimum that is found from the truth")
    check_campaigns(there)


if __name__ == "__main__":
    main()
