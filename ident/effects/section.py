"""From a platform's geometry to the section of its beams."""

from __future__ import annotations

from ..campaign.device import Platform
from ..mechanics import Section, section


def device_section(device: Platform) -> Section:
    """The two-layer section of a platform's beams."""
    return section(
        silicon_modulus=device.silicon_modulus,
        silicon_poisson=device.silicon_poisson,
        pzt_modulus=device.pzt_modulus,
        pzt_poisson=device.pzt_poisson,
        silicon_thickness=device.silicon_thickness,
        pzt_thickness=device.pzt_thickness,
        width=device.width,
    )
