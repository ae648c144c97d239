"""Fig. 13: 8 V at 100 and 317 Hz, without load and with 40 mg.

The paper: "when the 40 mg load is fixed on the platform, its first-order natural frequency decreased"; it "weakened its
abnormal displacement response", which "was still obvious under the low frequency". (Its caption calls panel d "0 mg".)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.campaign import Platform
from ident.report.style import MODEL, RESIDUAL

from .nominal import PARAMETERS, Sine, harmonics, settled
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


def check(found: Found) -> str:
    slow, slow_loaded, fast, fast_loaded = (harmonics(z) for z in found.z)
    # "Abnormal" is a distortion: the second harmonic beside the first.
    weight = lambda h: h.second / h.first
    assert natural(40e-6) < 0.8 * natural(0.0)
    assert weight(fast_loaded) < 0.5 * weight(fast), (fast, fast_loaded)
    assert weight(slow_loaded) > 0.9 * weight(slow) and slow_loaded.offset > 0.02, (slow, slow_loaded)
    told = ", ".join(f"{100 * weight(h):.2f} %" for h in (slow, slow_loaded, fast, fast_loaded))
    return (
        f"40 mg lower the natural frequency from {natural(0.0):.0f} to {natural(40e-6):.0f} Hz; second over first "
        f"harmonic at 100 Hz 0 and 40 mg, 317 Hz 0 and 40 mg: {told}"
    )


def draw(found: Found) -> Figure:
    claim = "40 mg: the offset all but drowns at 317 Hz, near the lowered resonance, and stays at 100 Hz"
    figure, axes = sheet(claim, 4, 2, width=13, height=2.7)
    for i, (case, z) in enumerate(zip(CASES, found.z, strict=True)):
        colour = RESIDUAL if case.load else MODEL
        period(axes[i], z, colour, f"8 V, {case.hertz:g} Hz, {1e6 * case.load:.0f} mg; dashed: symmetric part")
        # In units of the motion, as the eye sees it.
        first = harmonics(z).first
        offset(axes[4 + i], z / first * 1e-4, colour, "not symmetric, of the amplitude")
        axes[4 + i].set_ylabel("offset (%)", fontsize=9)
        axes[4 + i].set_ylim(-6, 2)
    return figure
