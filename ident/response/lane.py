"""The drive of one record as the solver sees it."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..campaign.drive import drive_frequency, half_step_drive
from ..campaign.held_drive import beside_edge
from ..campaign.record import Trace

Numbers = Any  # NumPy outside a program, JAX inside


class Lane(NamedTuple):
    """The drive of one record.

    **Arguments:** `step`, s, of the Runge–Kutta method; `voltage` and `rate`, (2 n + 1,) V and V/s on the half-step
    grid; `omega`, rad/s, one or one of each block; `load`, kg; `moving`, 1 if the record begins in motion; `order` of
    the derivative of the displacement that was measured; `stiffer` and `damped`, the share by which the device's own
    spring and damper are so in this record; `sine`, 1 if the drive is one of about this frequency, so that the solver's
    error at it is taken off; `into`, s of the record before an excerpt of it; `allowed`, by how much a step may miss
    what is measured where it meets a kink, beyond which it is divided; `beside`, s² or s, what V̇ of a drive that is
    held adds to a reading of velocity or acceleration beside one of its edges (`beside_edge`).
    """

    step: float
    voltage: np.ndarray
    rate: np.ndarray
    omega: float | np.ndarray
    load: float = 0.0
    moving: float = 0.0
    order: float = 0.0
    stiffer: float = 0.0
    damped: float = 0.0
    sine: float = 0.0
    into: float = 0.0
    allowed: float = math.inf
    beside: float = 0.0


ALLOWED = 2e-3
"""Of the noise, by which a step may miss where it meets a kink. There are two in a period, and as many periods of them
add up as the quality says: with dry friction at Q = 40 the readings were right within 0.05 of the noise."""


@lru_cache(maxsize=64)  # hypotheses about one record ask for the others again
def lane_of(record: Trace, substeps: int, allowed: float = ALLOWED) -> Lane:
    """The drive of a record with so many steps of the solver per sample; `allowed` of the noise, as above."""
    voltage, rate = half_step_drive(record, substeps)
    moving = float(record.begins_in_motion)
    own = (record.load, moving, record.order, record.stiffer, record.damped)
    noise = max(record.noise.sigma, 1e-4 * float(np.std(record.response)))
    omega, into = drive_frequency(record), record.into
    step, beside = record.step / substeps, 0.0
    if record.edge is not None:
        beside = beside_edge(record.edge, substeps, record.order) * step ** (3 - record.order)
    return Lane(step, voltage, rate, omega, *own, into=into, allowed=allowed * noise, beside=beside)
