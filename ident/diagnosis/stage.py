"""The coordinates along the fitted records, and what functions of them would add to the readings.

Forces are evaluated where the stage was measured to be, sensor terms on the model's own motion (see `trajectory`): on
the measured one their rows would also contain the very noise that they are to explain.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..effects.dependence import Side
from ..response import Equation
from .columns import push_columns
from .score import Bench, by_record
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
    largest = (scales.displacement, scales.voltage)
    groups = scene.data.groups
    moved = [places(g, p.z, p.v, 1, scales.period, largest) for g, p in zip(groups, scene.paths, strict=True)]
    own = [
        places(g, p.z[:, :: 2 * substeps], p.v[:, :: 2 * substeps], 2 * substeps, scales.period, largest)
        for g, p, substeps in zip(groups, scene.own, scene.static.substeps, strict=True)
    ]
    linear, omega = bench.fit.model.linear, 2 * np.pi * float(bench.fit.values[0])
    force_unit = linear.mass * omega**2 * scales.displacement
    return Stage(tuple(moved), tuple(own), sizes(moved), force_unit, scales.displacement)


def rows_of(bench: Bench, stage: Stage, side: Side, functions: Callable[[Places], np.ndarray]) -> np.ndarray:
    """Whitened rows (k, n) of functions of the coordinates, not projected.

    **Arguments:** `functions`: from the coordinates of a group to (k, lanes, points), in units of `force_unit` (pushed
    through the model's dynamics) or, for a sensor, of `sensor_unit` (added to the readings).
    """
    if side == "sensor":
        return by_record(bench, [stage.sensor_unit * functions(place) for place in stage.modelled])
    scene, equation = bench.scene, Equation(bench.fit.model)
    found = []
    for substeps, group, path, place in zip(
        scene.static.substeps, scene.data.groups, scene.paths, stage.moved, strict=True
    ):
        pushes = stage.force_unit * functions(place)
        found.append(np.asarray(push_columns(equation, substeps, bench.fit.values, pushes, group.lanes, path)))
    return by_record(bench, found)
