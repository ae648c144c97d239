"""The curve of a missing law as a fit has it that simulates the law, beside the one along the measured motion.

The two differ where noise of the measured motion bends what is estimated along it: at a kink, and where the records
seldom were.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...effects.effect import AbstractEffect, Drive, State
from .coordinates import absorbed
from .find import Unknown
from .picture import Picture

_FAR = 1e6  # SI: where a step has turned, whatever its width


def curve_of(effect: AbstractEffect, unknown: Unknown, constant: bool) -> np.ndarray | None:
    """Values of the effect at the points of the picture, in its unit, less what the model has in its linear terms, of
    which as much is taken as brings it closest to the picture; None where the picture is no curve over one coordinate,
    or the effect is not what it shows.

    **Arguments:** `effect`: written from `unknown`, with its numbers as they were refitted; `constant`: whether the
    model has a constant force or reading, which a function of one coordinate then shares with it.
    """
    picture, product = unknown.picture, unknown.product
    other = product is not None and (unknown.written is None or not unknown.written.terms[0].law)
    if picture.kind not in ("curve", "factor") or other:
        return None
    (name,), (axis,) = picture.names, picture.grids
    place = {name: axis} if product is None else {name: axis, product.by: _FAR}
    power = 0 if product is None else product.factor.power
    value = np.broadcast_to(_at(effect, place), axis.shape) / _FAR**power
    level = np.ones(len(axis))
    if product is None:
        lines = [axis] * absorbed(unknown.side, name) + [level] * constant
    else:
        lines = [level] * product.known(unknown.side)
    return _closest(value, picture, np.array(lines)) if lines else value


def _at(effect: AbstractEffect, place: Mapping[str, np.ndarray | float]) -> np.ndarray:
    """Force or reading where the coordinates not in `place` are zero."""
    z, v, V, rate, t = (place.get(name, 0.0) for name in ("z", "v", "V", "dV", "t"))
    drive = Drive(V, rate, 1.0, 1.0)
    if effect.acts_on == "drive":
        return np.asarray(effect.drive((), drive, t))
    act = effect.sensor if effect.acts_on == "sensor" else effect.force
    return np.asarray(act(State(z, v), drive, t))


def _closest(value: np.ndarray, picture: Picture, lines: np.ndarray) -> np.ndarray:
    """The values with as much of some lines (k, points) as brings them closest to the picture, by its errors."""
    weight = np.max(picture.error) / np.maximum(picture.error, 1e-9 * np.max(picture.error))
    return value + np.linalg.lstsq((weight * lines).T, weight * (picture.value - value), rcond=None)[0] @ lines
