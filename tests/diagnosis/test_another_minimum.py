"""A law that stands in a valley beside the device's own is found from its other shapes before a refinement is named."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.search.once_more import another_minimum
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model

F, Q, STEP, N, FINE, NOISE = 31.0, 26.0, 1 / 1250.0, 4000, 4, 2e-3
STIFF, TIME, SPREAD = 0.55, 0.0052, 14.0
BESIDE = (
    31.14,
    9.88,
    1.0,
    11150.0,
    0.0188,
    1.81,
    0.5,
)  # where a race left the search: one time, and damping for the other
ONE = Channel("V", 1.0)


def records() -> tuple[Trace, ...]:
    """Noise and a sine shake a mount of two Maxwell elements, by SciPy."""
    w, times = 2 * np.pi * F, (TIME / np.sqrt(SPREAD), TIME * np.sqrt(SPREAD))
    kv = 0.5 * STIFF * w * w
    matrix = [[0, 1, 0, 0], [-w * w - 2 * kv, -w / Q, kv, kv],
              [1 / times[0], 0, -1 / times[0], 0], [1 / times[1], 0, 0, -1 / times[1]]]  # fmt: skip
    system = (np.array(matrix), np.array([[0], [w * w], [0], [0]]), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 1)))
    found = []
    for k in range(3):
        rng, t = np.random.default_rng(k), STEP / FINE * np.arange(FINE * N)
        tones = 2 * np.pi * rng.uniform((2, 15, 3)[k], (20, 110, 150)[k], 25)
        drive = np.sum([np.sin(x * t + p) for x, p in zip(tones, rng.uniform(0, 6.3, 25), strict=True)], axis=0) / 5
        z = lsim(system, drive, t)[1].ravel()[::FINE]
        read = z + NOISE * rng.standard_normal(N)
        found.append(Trace(f"{k}", t[::FINE], drive[::FINE], read, ONE, ONE, NoiseFloor(NOISE), "rest"))
    return tuple(found)


@pytest.fixture(scope="module")
def fits() -> tuple[Fit, Fit]:
    device = Oscillator("V", "V")
    start = fit(Model(device), Campaign("mount", records(), device))
    law = built_in()["viscoelastic-support"](device)
    return start, fit(start.model + law, start.campaign, initial=np.array(BESIDE))


def test_the_valley_of_the_device_is_found(fits: tuple[Fit, Fit]) -> None:
    start, beside = fits
    assert beside.fitted.error_over_noise > 1.1, "no longer another minimum: the test needs one"
    said: list[str] = []
    lower = another_minimum(beside, start, said.append)
    assert lower is not None and said
    assert lower.fitted.error_over_noise < 1.05
    assert lower.value("viscoelastic-support.spread") == pytest.approx(SPREAD, rel=0.1)
    assert another_minimum(lower, start, said.append) is None, "there is no better one"


def test_what_has_no_shapes_has_no_other_minimum(fits: tuple[Fit, Fit]) -> None:
    start, _ = fits
    said: list[str] = []
    assert another_minimum(start, start, said.append) is None and not said
