"""Sweeps of a velocity or an acceleration, as the displacement whose rate they are: a = r/ωⁿ, n = 1 or 2.

They are read, turned and their noise is estimated as they were measured, for there it is the same at all frequencies;
then amplitude, harmonics (at their own frequencies) and noise are divided, and the phase is less by n·90°.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import UserError
from ...units import VOLTAGE, find_unit, format_quantity
from ..device import Device, Oscillator
from ..quality.checks import PLATFORM_TRAVEL
from ..record import MEASURES, Channel, Measures, Record, Sweep
from ..spec import RecordSpec, signal_units

_NAMED = 3  # sweeps that a note names


def measured_by(spec: RecordSpec, device: Device) -> Measures:
    """What the unit of a sweep's amplitude is one of: a sensor's volts are volts, whatever it reads."""
    return "displacement" if signal_units(device)[1][1] == VOLTAGE else spec.measures


def displaced(records: Sequence[Record], specs: Sequence[RecordSpec], device: Device, notes: list[str]) -> list[Record]:
    """The records, with sweeps of a velocity or an acceleration as sweeps of the displacement.

    **Raises:** UserError where only half the peak-to-peak value of such a reading is known.
    """
    found, names = list[Record](), dict[Measures, list[str]]()
    for record, spec in zip(records, specs, strict=True):
        if isinstance(record, Sweep) and spec.measures != "displacement":
            names.setdefault(spec.measures, []).append(record.name)
            record = _displaced(record, spec, signal_units(device)[1][0])
            if not isinstance(device, Oscillator):
                on_a_platform(record.name, record.amplitude)
        found.append(record)
    for measures, own in names.items():
        by = "2πf" if measures == "velocity" else "(2πf)²"
        some = ", ".join(own[:_NAMED]) + (f" and {len(own) - _NAMED} more" if len(own) > _NAMED else "")
        notes.append(f"{some}: amplitudes of {measures}; divided by {by} they are those of the displacement.")
    return found


def on_a_platform(where: str, amplitude: np.ndarray) -> None:
    """A `UserError` for amplitudes, m, that no platform has."""
    if np.max(amplitude) > PLATFORM_TRAVEL:
        raise UserError(
            f"an amplitude of {np.max(amplitude):.3g} m cannot be right for a platform",
            where=where,
            do='state its unit, in the header or with units = { amplitude = "um" }',
        )


def _displaced(sweep: Sweep, spec: RecordSpec, unit: str) -> Sweep:
    if sweep.quantity != "fundamental":
        what = f"half the peak-to-peak value of {spec.measures} does not tell that of the displacement"
        raise UserError(what, where=spec.where, do="measure the fundamental, or integrate before the peaks are read")
    order = MEASURES.index(spec.measures)
    rate = (2 * np.pi * sweep.frequency) ** order
    amplitude, noises = sweep.amplitude / rate, sweep.noises.copy()
    noises[0] /= rate
    overtones = tuple(
        one._replace(amplitude=one.amplitude / rate / one.order**order, noise=one.noise / rate / one.order**order)
        for one in sweep.overtones
    )
    return replace(
        sweep,
        amplitude=amplitude,
        phase=None if sweep.phase is None else sweep.phase - order * np.pi / 2,
        response_channel=_channel(unit, float(np.max(amplitude))),
        noise=replace(sweep.noise, sigma=float(np.median(noises[0]))),
        own_noise=noises,
        overtones=overtones,
    )


def _channel(unit: str, size: float) -> Channel:
    """The unit, with the prefix in which numbers of a size are read."""
    shown = format_quantity(size, unit).split()[-1]
    found = find_unit(shown)
    return Channel(unit, 1.0) if found is None else Channel(shown, found.factor)
