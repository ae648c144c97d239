"""Fig. 13: 8 V at 100 and 317 Hz, without load and with 40 mg.

The paper: "when the 40 mg load is fixed on the platform, its first-order natural frequency decreased"; it "weakened its
abnormal displacement response", which "was still obvious under the low frequency". (Its caption calls panel d "0 mg".)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.campaign import Platform
from ident.report.figures.style import MODEL, RESIDUAL

from .nominal import PARAMETERS, Sine, harmonics, settled, without_offset
from .sheet import Figure, offset, period, sheet

CASES = (Sine(8.0, 100.0), Sine(8.0, 100.0, 40e-6), Sine(8.0, 317.0), Sine(8.0, 317.0, 40e-6))


class Found(NamedTuple):
    """One period of each case, (4, POINTS) m."""

    z: np.ndarray


def study() -> Found:
    return Found(np.array(settled(CASES)))


def natural(load: float) -> float:
    """Natural frequency of the loaded stage without axial force, Hz."""
    mass = Platform().stage_mass
    return PARAMETERS["platform.frequency"] * float(np.sqrt(mass / (mass + load)))


def distortion(z: np.ndarray) -> float:
    """How much of a period's swing has the wrong symmetry: rms of even harmonics over rms of odd ones."""
    odd = without_offset(z)
    return float(np.std(z - odd) / np.std(odd))


def check(found: Found) -> str:
    slow, slow_loaded, fast, fast_loaded = (distortion(z) for z in found.z)
    assert natural(40e-6) < 0.8 * natural(0.0)
    assert fast_loaded < 0.6 * fast and slow_loaded > slow, found
    told = ", ".join(f"{100 * d:.1f} %" for d in (slow, slow_loaded, fast, fast_loaded))
    return (
        f"40 mg lower the natural frequency from {natural(0.0):.0f} to {natural(40e-6):.0f} Hz; even distortion at 100 "
        f"Hz with 0 and 40 mg, at 317 Hz with 0 and 40 mg: {told} of the motion (at 100 Hz with 40 mg the 4th harmonic "
        "meets the resonance)"
    )


def draw(found: Found) -> Figure:
    claim = "40 mg: the abnormality halves at 317 Hz, near the lowered resonance, and stays plain at 100 Hz"
    figure, axes = sheet(claim, 4, 2, width=13, height=2.7)
    for i, (case, z) in enumerate(zip(CASES, found.z, strict=True)):
        colour = RESIDUAL if case.load else MODEL
        period(axes[i], z, colour, f"8 V, {case.hertz:g} Hz, {1e6 * case.load:.0f} mg")
        # In units of the motion, as the eye sees it.
        first = harmonics(z).first
        offset(axes[4 + i], z / first * 1e-4, colour, "not symmetric, of the amplitude")
        axes[4 + i].set_ylabel("offset (%)", fontsize=9)
        axes[4 + i].set_ylim(-11, 5)
    return figure
