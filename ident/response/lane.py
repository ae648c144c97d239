"""One record as the solver sees it."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

Numbers = Array | np.ndarray


class Lane(NamedTuple):
    """The drive of one record.

    **Arguments:** `step`, s, of the Runge–Kutta method; `voltage` and `rate`, (2 n + 1,) V and V/s on the half-step
    grid; `omega`, rad/s; `load`, kg; `moving`, 1 if the record begins in motion.
    """

    step: Numbers
    voltage: Numbers
    rate: Numbers
    omega: Numbers
    load: Numbers
    moving: Numbers | float = 0.0


def half_step_time(lane: Lane) -> Array:
    """Time since the first sample on the half-step grid, s."""
    return jnp.asarray(0.5 * lane.step * jnp.arange(lane.voltage.shape[0]))
