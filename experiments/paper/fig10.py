"""Fig. 10: each mechanism alone at 8 V, 317 Hz. Residual stress gives the offset, hysteresis none.

The paper: "the offset of the zero point is attributed to the residual stress and has almost nothing to do with the
hysteresis of PZT materials".
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from experiments.make_campaigns import PAPER
from experiments.simulator.signals import sine
from experiments.simulator.stage import Stage, simulate
from ident.report.figures.style import MODEL, RESIDUAL

from .nominal import NO_HYSTERESIS, NO_STRESS, POINTS, Sine, harmonics, settled
from .sheet import Figure, offset, period, sheet

DRIVE = Sine(8.0, 317.0)


class Found(NamedTuple):
    """One period of each case: residual stress alone, hysteresis alone, and stress alone without the drive's own axial
    force; and the share of the offset in data/platform_317hz that is left when its stress is
    zero and only the drive's axial force acts."""

    stress: np.ndarray
    hysteresis: np.ndarray
    deflection: np.ndarray
    by_drive: float


def study() -> Found:
    alone = {**NO_HYSTERESIS, "residual-stress.voltage_force": 0.0}
    periods = (settled([DRIVE], changed)[0] for changed in (NO_HYSTERESIS, NO_STRESS, alone))
    whole, drive = (_simulated(stage) for stage in (PAPER, replace(PAPER, sigma12=0.0, sigma23=0.0)))
    return Found(*periods, _along(drive, whole))


def _simulated(stage: Stage) -> np.ndarray:
    """One settled period of the independent simulator at 8 V, 317 Hz, m."""
    time = np.arange(100 * POINTS) / (POINTS * DRIVE.hertz)
    return simulate(stage, sine(DRIVE.volts, DRIVE.hertz), time)[0, -POINTS:]


def check(found: Found) -> str:
    stress, hysteresis, deflection = (harmonics(z) for z in found[:3])
    assert stress.offset > 0.02 and hysteresis.offset < 1e-5, (stress, hysteresis)
    share = _along(found.deflection, found.stress)
    assert 0.6 < share < 1.0, share
    assert found.by_drive > 0.9, found.by_drive
    return (
        f"residual stress alone: mean {1e6 * stress.mean:.3f} µm, 2nd harmonic {1e6 * stress.second:.3f} µm; "
        f"hysteresis alone: {hysteresis.offset:.0e} of its amplitude. The initial deflection makes {100 * share:.0f} % "
        f"of the first, the axial force of the drive the rest; in data/platform_317hz that force alone makes "
        f"{100 * found.by_drive:.0f} % of the offset"
    )


def _along(part: np.ndarray, whole: np.ndarray) -> float:
    """The share of a motion's offset that another motion's offset makes."""
    even = lambda z: (z + np.roll(z, len(z) // 2)) / 2
    return float(even(part) @ even(whole) / (even(whole) @ even(whole)))


def draw(found: Found) -> Figure:
    figure, axes = sheet(
        "Residual stress alone gives the offset at 8 V, 317 Hz; hysteresis alone gives none", 4, width=13
    )
    for i, (z, name, colour) in enumerate(
        ((found.stress, "residual stress", MODEL), (found.hysteresis, "hysteresis", RESIDUAL))
    ):
        period(axes[2 * i], z, colour, f"{name} alone; dashed: symmetric part")
        offset(axes[2 * i + 1], z, colour, f"offset by {name}")
        axes[2 * i + 1].set_ylim(-0.25, 0.25)
    return figure
