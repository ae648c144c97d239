"""The coordinates along the fitted records, and what functions of them would add to the readings.

Forces are evaluated where the stage was measured to be, sensor terms on the model's own motion (see `trajectory`): on
the measured one their rows would also contain the very noise that they are to explain.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..effects.dependence import Side
from .bench import Bench, by_record
from .columns import push_columns
from .splines import Places, Size, places, sizes


class Stage(NamedTuple):
    """The coordinates along the records: of the motion that was measured, for forces, and of the model's, for sensors.

    **Arguments:** `force_unit` N and `sensor_unit` m, in which missing terms are counted.
    """

    moved: tuple[Places, ...]
    modelled: tuple[Places, ...]
    ranges: dict[str, Size]
    force_unit: float
    sensor_unit: float


def set_stage(bench: Bench) -> Stage:
    """The coordinates along all fitted records."""
    scene, scales = bench.scene, bench.fit.scales
    largest, lanes = (scales.displacement, scales.voltage), scene.tape.lanes
    moved = places(lanes, scene.paths, [1] * len(lanes), scales.period, largest)
    own = places(lanes, scene.own, [2 * span.substeps for span in scene.tape.spans], scales.period, largest)
    linear, omega = bench.fit.model.linear, 2 * np.pi * float(bench.fit.values[0])
    force_unit = linear.mass * omega**2 * scales.displacement
    return Stage(moved, own, sizes(moved), force_unit, scales.displacement)


def rows_of(bench: Bench, stage: Stage, side: Side, functions: Callable[[Places], np.ndarray]) -> np.ndarray:
    """Whitened rows (k, n) of functions of the coordinates, not projected.

    **Arguments:** `functions`: from the coordinates of a record to (k, 1, points), in units of `force_unit` (pushed
    through the model's dynamics) or, for a sensor, of `sensor_unit` (added to the readings).
    """
    scene = bench.scene
    if side == "sensor":
        shown = np.concatenate([functions(place)[:, 0] for place in stage.modelled], axis=1)
        return by_record(bench, stage.sensor_unit * shown)
    grids = [stage.force_unit * functions(place)[:, 0].T for place in stage.moved]
    return by_record(bench, push_columns(scene.tape, scene.dynamics, scene.tape.windows(grids)))
