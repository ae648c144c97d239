"""The linear part that every model starts from: one resonance, driven by a voltage.

    (M + m) z̈ + (M ω0/Q) ż + M ω0² z = G V + Σ forces of the effects

For the platform M is the stage's mass, m the record's load and G = K_f d31/T_p; for a generic oscillator M = 1, m = 0
and G is called the gain. ω0 and Q are those of the unloaded stage. M is known from the geometry, to some 10 %: records
of two loads tell it better.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from ..campaign.device import Device, Platform
from ..effects.parameter import Expected
from ..effects.section import device_section
from ..mechanics import drive_force_coefficient, l_beam, stage_stiffness

FREQUENCY, QUALITY, GAIN, MASS = 0, 1, 2, 3
"""Places of the linear part's numbers among the parameters of every model; without a spring the first is a time scale
that is held, and the second the decay time. The mass is one where the model is `weighed`."""
_TOLERANCE = 0.2  # of ln f0: a layer 10 % thicker raises f0 by 15 %, a stage 10 % heavier lowers it by 5 %
_HEAVIER = 0.1  # of ln M
# m/V; films of PZT have e31,f up to 14 ± 4 C/m² (Marshall et al., Integrated Ferroelectrics 80, 2006; DOI
# 10.1080/10584580600656437), which with the nominal modulus, e31,f = E d31/(1 − ν), is 150 ± 45 pm/V.
_LARGEST_D31 = 200e-12


@dataclass(frozen=True)
class LinearPart:
    """Numbers of the linear part that do not change in a fit.

    **Arguments:**

    - `prefix`: "platform" or "oscillator"; `gain_name`, `gain_unit`: its drive parameter.
    - `mass`: kg, nominal (1 for an oscillator); `force_per_gain`: N/V for a unit of the drive parameter.
    - `nominal_frequency`: Hz, from the geometry; None where nothing is known beforehand.
    - `expected_frequency`, `expected_gain`: the same as knowledge with a spread.
    """

    prefix: str
    gain_name: str
    gain_unit: str
    mass: float
    force_per_gain: float
    nominal_frequency: float | None
    expected_frequency: Expected | None = None
    expected_gain: Expected | None = None
    expected_mass: Expected | None = None


@lru_cache(maxsize=32)
def linear_part(device: Device) -> LinearPart:
    """The linear part of a device; K_f of the platform from its geometry (Sensors 2020, 20, 3959, Eq. 13)."""
    if not isinstance(device, Platform):
        return LinearPart("oscillator", "gain", "N/V", 1.0, 1.0, None)
    section = device_section(device)
    beam = l_beam(section, device.length_1, device.length_2)
    force_per_gain = float(drive_force_coefficient(section, beam)) / device.pzt_thickness
    frequency = math.sqrt(stage_stiffness(beam, 0.0, 0.0) / device.stage_mass) / (2 * math.pi)
    return LinearPart(
        "platform", "d31", "m/V", device.stage_mass, force_per_gain, frequency,
        Expected(frequency, _TOLERANCE, "nominal geometry; thickness and stage mass are known to some 10 %"),
        Expected(0.0, _LARGEST_D31, "films of PZT reach some 150 pm/V, either sign"),
        Expected(device.stage_mass, _HEAVIER, "nominal geometry; the stage's thickness is known to some 10 %"),
    )  # fmt: skip
