"""A drive without a response: what a model is asked about before anything is measured."""

from __future__ import annotations

import numpy as np

from ..units import NUMBER, factor_of
from .device import Device
from .period import find_period
from .quality.checks import on_grid, uniform_time
from .record import Channel, NoiseFloor, Trace
from .spec import signal_units
from .tables.columns import match_columns, trace_roles
from .tables.table import Table

_FINE = 1e-4  # of a response that is not known: the solver's step is then as fine as for the best records


def drive_alone(table: Table, device: Device) -> Trace:
    """Time and drive of a table as a record that starts at rest; its response is zero, because there is none.

    **Raises:** UserError if the columns cannot be told, or time is not uniform.
    """
    (unit, dimension), (response_unit, _) = signal_units(device)
    roles = trace_roles(dimension or NUMBER, NUMBER, ("" if dimension else unit, ""))[:2]
    found = match_columns(table, roles, {}, {})
    time_factor, drive_factor = factor_of(found["time"].unit), factor_of(found["drive"].unit)
    time = uniform_time(found["time"], time_factor, [])
    drive, nowhere = found["drive"].numbers() * drive_factor, np.zeros(len(time), bool)
    _, drive = on_grid(found["time"], time_factor, time, nowhere, drive)
    noise = NoiseFloor(_FINE, method="nothing was measured")
    channels = Channel(found["drive"].unit or unit, drive_factor), Channel(response_unit, 1.0)
    nothing = np.zeros(len(time))
    return Trace(table.name, time, drive, nothing, *channels, noise=noise, start="rest", period=find_period(drive))
