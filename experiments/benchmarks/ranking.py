"""Scores against refits, in one process: `python -m experiments.benchmarks.ranking`

Six records of 2000 samples of a device with one hidden effect (`experiments/hidden_effects`). What ident does is timed
against what it replaces, a refit of every effect of the library. Every side has run on another device before the clock
starts, so that nothing is compiled on one side only. The last line is what a campaign costs whose shape this machine
has not met: the first discovery of a fresh process without the cache of compiled programs.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads wait by spinning, beside those of XLA; before NumPy

import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from ident import runtime

runtime.configure()

from experiments.hidden_effects.campaigns import campaign_of  # noqa: E402  (JAX must be configured first)
from experiments.hidden_effects.generator import draw  # noqa: E402
from ident.campaign.campaign import Campaign  # noqa: E402
from ident.diagnosis.diagnose import discover  # noqa: E402
from ident.diagnosis.linearised.regression import prepare  # noqa: E402
from ident.diagnosis.ranking.confirm import confirm  # noqa: E402
from ident.diagnosis.ranking.score import score  # noqa: E402
from ident.effects.registry import built_in  # noqa: E402
from ident.fit import fit  # noqa: E402
from ident.model import Model  # noqa: E402

HIDDEN = ("cubic-stiffness", "coulomb-friction", "prandtl-ishlinskii", "sensor-nonlinearity", "creep")
BEFORE, TIMED = 40, 41  # seeds
SAMPLES = 2000
FIRST_RANKING, DISCOVERY = 2.0, 10.0  # s


class Times(NamedTuple):
    """Seconds of the first ranking by scores, of the whole discovery, and of refitting every candidate once."""

    ranking: float
    discovery: float
    refits: float


def measure(campaign: Campaign) -> Times:
    """Time the three on one campaign, each from its records."""
    library, start = built_in(), Model(campaign.device)
    fitted = fit(start, campaign)
    ranking = _seconds(lambda: score(prepare(fitted), library))
    discovery = _seconds(lambda: discover(campaign))
    regression = prepare(fitted)
    candidates = score(regression, library)
    refits = _seconds(lambda: [confirm(regression, library[one.name], one) for one in candidates])
    return Times(ranking, discovery, refits)


def _seconds(work: Callable[[], object]) -> float:
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def case(seed: int, effect: str) -> Campaign:
    """The records of a device with an effect of 2 % under noise of 0.3 %."""
    return campaign_of(draw(seed, (effect,), size=0.02, noise=0.003, length=SAMPLES))


def table(effects: Sequence[str]) -> list[Times]:
    """Print a line per hidden effect."""
    print(f"{'hidden':22} {'first ranking':>14} {'discovery':>10} {'every refit':>12} {'refits/ranking':>15} "
          f"{'refits/discovery':>17}")  # fmt: skip
    found = []
    for effect in effects:
        measure(case(BEFORE, effect))
        took = measure(case(TIMED, effect))
        print(f"{effect:22} {took.ranking:12.2f} s {took.discovery:8.1f} s {took.refits:10.1f} s "
              f"{took.refits / took.ranking:15.0f} {took.refits / took.discovery:17.1f}", flush=True)  # fmt: skip
        found.append(took)
    return found


def cold() -> float:
    """Seconds of the first discovery ever, reading and starting Python not counted."""
    command = [sys.executable, "-m", "experiments.benchmarks.ranking", "--cold"]
    environment = {**os.environ, "IDENT_CACHE": "off"}
    return float(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)


if __name__ == "__main__":
    if sys.argv[1:] == ["--cold"]:
        campaign = case(TIMED, HIDDEN[0])
        print(_seconds(lambda: discover(campaign)))
        sys.exit()
    for took in table(HIDDEN):
        assert took.ranking <= FIRST_RANKING and took.discovery <= DISCOVERY, took
    print(f"{HIDDEN[0]}, nothing compiled before: discovery {cold():.0f} s")
