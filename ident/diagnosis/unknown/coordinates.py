"""The coordinates along the fitted records, and what functions of them would add to the readings.

Forces are evaluated where the stage was measured to be, sensor terms on the model's own motion (see `trajectory`): on
the measured one their rows would also contain the very noise that they are to explain.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...effects.dependence import Side
from ...model import FREQUENCY
from ..linearised.push_columns import push_columns
from ..linearised.regression import Regression, by_record
from .splines import Places, Size, places, sizes


class Stage(NamedTuple):
    """The coordinates along the records: of the motion that was measured, for forces, and of what
    sensors read of the model's.

    **Arguments:** `force_unit` N and `sensor_unit` m, in which missing terms are counted.
    """

    moved: tuple[Places, ...]
    modelled: tuple[Places, ...]
    of_motion: dict[str, Size]
    of_reading: dict[str, Size]
    force_unit: float
    sensor_unit: float

    def ranges(self, side: Side) -> dict[str, Size]:
        """The ranges of the coordinates that a side sees."""
        return self.of_reading if side == "sensor" else self.of_motion

    def resolved(self, side: Side, name: str, pieces: int) -> Stage:
        """The same with so many splines over one coordinate."""
        own = self.ranges(side)
        ranges = own | {name: own[name]._replace(pieces=pieces)}
        return self._replace(of_reading=ranges) if side == "sensor" else self._replace(of_motion=ranges)


def absorbed(side: Side, name: str) -> bool:
    """Whether a term proportional to this coordinate is in every model already: stiffness, damping, gain."""
    return name == "z" or (side != "sensor" and name in ("v", "V"))


def set_stage(regression: Regression) -> Stage:
    """The coordinates along all fitted records."""
    trajectories, scales = regression.trajectories, regression.fit.scales
    largest, lanes = scales.displacement, trajectories.tape.lanes
    moved = places(lanes, trajectories.paths, [1] * len(lanes), scales.period, (largest, scales.voltage))
    own, of_motion = trajectories.read(trajectories.own), sizes(moved)
    rates = any(lane.order for lane in lanes)
    reading = max(float(np.max(np.abs(path.z))) for path in own) if rates else largest
    strides = [2 * span.substeps for span in trajectories.tape.spans]
    modelled = places(lanes, own, strides, scales.period, (reading, scales.voltage))
    linear, omega = regression.fit.model.linear, 2 * np.pi * float(regression.fit.values[FREQUENCY])
    force_unit = linear.mass * omega**2 * largest
    return Stage(moved, modelled, of_motion, sizes(modelled) if rates else of_motion, force_unit, reading)


def rows_of(regression: Regression, stage: Stage, side: Side, functions: Callable[[Places], np.ndarray]) -> np.ndarray:
    """Whitened rows (k, n) of functions of the coordinates, not projected.

    **Arguments:** `functions`: from the coordinates of a record to (k, 1, points), in units of `force_unit` (pushed
    through the model's dynamics) or, for a sensor, of `sensor_unit` (added to the readings).
    """
    trajectories = regression.trajectories
    if side == "sensor":
        shown = np.concatenate([functions(place)[:, 0] for place in stage.modelled], axis=1)
        return by_record(regression, stage.sensor_unit * shown)
    grids = trajectories.tape.windows([functions(place)[:, 0] for place in stage.moved])
    pushed = push_columns(trajectories.tape, trajectories.dynamics, grids)
    return by_record(regression, stage.force_unit * pushed)
