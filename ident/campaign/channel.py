"""The unit of a column, and what the device makes of it."""

from __future__ import annotations

from ..errors import UserError
from ..units import factor_of
from .device import Device
from .record import Channel, Measures
from .spec import RecordSpec, signal_units
from .tables.table import Column


def own_units(device: Device, measures: Measures = "displacement") -> tuple[str, str]:
    """The units of drive and response that exist for this device only; "" where they are ordinary ones."""
    drive, response = signal_units(device, measures)
    return (drive[0] if drive[1] is None else "", response[0] if response[1] is None else "")


def channel_of(column: Column, base: str, notes: list[str], role: str) -> Channel:
    """The unit of a column; without one it is the base unit, which is said."""
    if column.unit is None:
        notes.append(f'{column.file}: the {role} "{column.header}" states no unit; {base} is assumed.')
        return Channel(base, 1.0)
    return Channel(column.unit, factor_of(column.unit))


def plausible_noise(spec: RecordSpec, size: float) -> float:
    """The noise given, if numbers of 16 digits can be weighed with it."""
    assert spec.noise is not None
    if 1e-12 * size <= spec.noise <= 1e6 * size:
        return spec.noise
    what = f"a noise of {spec.noise:.3g} cannot be right where the response has {size:.3g} rms (SI units)"
    raise UserError(what, where=f"{spec.where}: noise of {spec.file}", do="correct it, or leave it out")
