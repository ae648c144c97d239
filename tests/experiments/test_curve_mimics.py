"""Which laws could pass for one another on curves, by the study's own simulators."""

import numpy as np
import pytest

from experiments.curves.generator import draw
from experiments.curves.mimics import SEEN, left_by
from experiments.curves.orbits import settled_sweep
from experiments.curves.sweeps import sweep
from experiments.hidden_effects.generator import Device
from experiments.hidden_effects.laws import INDEX, LAWS


@pytest.mark.parametrize(
    ("name", "size", "shape"),
    [
        ("cubic-stiffness", 0.15, (0.0, 0.0, 0.0)),  # jumps at 1, on its way up
        ("quadratic-stiffness", 0.25, (0.1, 0.0, 0.0)),
        ("prandtl-ishlinskii", 0.2, (0.3, 20.0, 0.0)),
        ("sensor-nonlinearity", 0.1, (0.8, 0.0, 0.0)),
    ],
)
def test_where_a_motion_ends_is_found_without_waiting(name: str, size: float, shape: tuple[float, ...]) -> None:
    device = Device("platform", 500.0, 25.0, 1 / 25, 1e-5, 9.0, 1.0)
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    c[INDEX[name]], s[INDEX[name]] = size, shape
    ratios = 1 + np.linspace(-3, 5, 25) / device.quality
    waited, found = (
        run(ratios, 1.0, 500, device.gain, device.quality, c, s, device.geometry) for run in (sweep, settled_sweep)
    )
    np.testing.assert_allclose(found, waited, rtol=3e-4)


@pytest.mark.slow  # beams under stress take their time
def test_a_shape_that_is_drawn_of_either_sign_passes_through_zero() -> None:
    """A spring with a bend of its own, which stressed beams without a force by the voltage follow; drawn, they have
    one, a thousand times larger than what may be left of it."""
    case = draw(9300, ("quadratic-stiffness",), size=0.05)
    assert left_by(case, "residual-stress", phase=True) < SEEN
