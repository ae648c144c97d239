"""The thing that was measured: the platform of the paper, or any driven oscillator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..units import kept_unit


@dataclass(frozen=True)
class Platform:
    """Geometry and materials of the micro vibratory platform (SI). The defaults are the nominal device.

    A stage of mass `stage_mass` hangs on four L-shaped two-layer beams; segment 2 (length `length_2`) starts at the
    substrate, segment 1 (length `length_1`) ends at the stage. `beam_end` is the vector from the stage centre to a
    beam's end, `in_plane` the freedom of the stage in its plane; both matter to the "frame" closure only.

    Source: Sensors 2020, 20, 3959, with geometry chosen to meet the resonance that the paper reports.
    """

    silicon_modulus: float = 169e9
    silicon_poisson: float = 0.22
    pzt_modulus: float = 63e9
    pzt_poisson: float = 0.30
    silicon_thickness: float = 30e-6
    pzt_thickness: float = 17e-6
    width: float = 1.0e-3
    length_1: float = 2.4e-3
    length_2: float = 2.8e-3
    stage_mass: float = 60e-6
    beam_end: tuple[float, float] = (0.0, -1.5e-3)
    in_plane: Literal["yaw", "clamped", "free"] = "yaw"
    moment: Literal["neutral-axis", "paper-integral", "paper-printed"] = "neutral-axis"
    max_voltage: float = 10.0
    max_frequency: float = 2000.0


NOMINAL_RESONANCE = 500.0
"""Hz, near which a platform vibrates."""


@dataclass(frozen=True)
class Oscillator:
    """Any driven oscillator, z̈ + (ω0/Q) ż + ω0² z = g u, in whatever units its columns have."""

    output: str = "V"
    input: str = "V"
    max_voltage: float | None = None
    max_frequency: float | None = None


Device = Platform | Oscillator


def response_unit(device: Device) -> str:
    """The unit in which the displacements of a device are kept, "m" or, of an oscillator, that of its `output`."""
    own = device.output if isinstance(device, Oscillator) else "m"
    return kept_unit(own) or own


def drive_unit(device: Device) -> str:
    """The unit in which the drives of a device are kept, "V" or, of an oscillator, that of its `input`."""
    own = device.input if isinstance(device, Oscillator) else "V"
    return kept_unit(own) or own
