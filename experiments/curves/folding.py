"""Sensors that read less where the stage moves more: `python -m experiments.curves.folding --first 9820 --devices 10`.

One reading then has two motions. Devices of the study, whose sensor makes 30 % of misfit, are swept with and without
phase and fitted with the right law, from the linear model; how many fits reach the noise is printed and asserted.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
from pathlib import Path

from ident import runtime

runtime.configure()

from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.fit import Fit, fit  # noqa: E402
from ident.model import build_model  # noqa: E402

from .files import STYLES, write  # noqa: E402
from .generator import Case, Noise, draw  # noqa: E402

EFFECT, SIZE = "sensor-nonlinearity", 0.3
REACHED, SHARE = 1.15, 0.8  # noise floors; of the fits, asserted


def fitted(seed: int, phase: bool) -> tuple[Case, Fit]:
    """One device, and the fit of the right law to it."""
    case = draw(seed, (EFFECT,), size=SIZE, noise=Noise())
    with tempfile.TemporaryDirectory() as folder:
        write(case, Path(folder), STYLES[seed % len(STYLES)], phase)
        campaign = read_campaign(folder)
        return case, fit(build_model(campaign, (EFFECT,)), campaign)


def main() -> None:
    """Fit, print and assert."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=9820)
    parser.add_argument("--devices", type=int, default=10)
    asked = parser.parse_args()
    left = []
    for seed in range(asked.first, asked.first + asked.devices):
        for phase in (True, False):
            left.append(fitted(seed, phase)[1].fitted.error_over_noise)
            print(f"{seed} {'with' if phase else 'without'} phase: error over noise {left[-1]:.3f}", flush=True)
    reached = sum(error < REACHED for error in left)
    print(f"{reached} of {len(left)} reach {REACHED} noise floors")
    assert reached >= SHARE * len(left)


if __name__ == "__main__":
    main()
