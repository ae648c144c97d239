"""A free decay as it looks without a model: frequency and damping against amplitude, measured and of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..words.quantity import Scale
from .style import DATA, MODEL, label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...fit.linear.decay_curve import DecayCurve

_ROOM = 0.15  # of the range, above and below


def draw_decay(top: Axes, low: Axes, curves: tuple[DecayCurve, ...], unit: Scale) -> None:
    """Frequency in the upper axes and damping rate in the lower ones, against the amplitude in a unit of the response;
    the measured curve first."""
    measured, model = curves
    for axes, name in ((top, "frequency"), (low, "rate")):
        seen = getattr(measured, name)
        axes.plot(measured.amplitude / unit.factor, seen, "o", color=DATA, ms=4)
        axes.plot(model.amplitude / unit.factor, getattr(model, name), color=MODEL)
        low_end, high_end = float(np.min(seen)), float(np.max(seen))
        room = max(_ROOM * (high_end - low_end), 1e-3 * abs(high_end))
        axes.set_ylim(low_end - room, high_end + room)
        axes.set_xscale("log")
        axes.minorticks_off()
        ends = float(np.min(measured.amplitude)) / unit.factor, float(np.max(measured.amplitude)) / unit.factor
        ticks = np.geomspace(*ends, 4)
        axes.set_xticks(ticks, [f"{tick:.2g}" for tick in ticks])
    label(top, "", "frequency (Hz)", "frequency against amplitude")
    label(low, f"amplitude ({unit.unit})", "decay rate (1/s)", "damping against amplitude")
