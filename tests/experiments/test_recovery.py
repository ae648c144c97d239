"""A slice of the recovery study: four campaigns, with bands as wide as so few allow."""

import numpy as np
import pytest

from experiments.recovery import recovery
from experiments.recovery.campaigns import KINDS, draw
from experiments.simulator.geometry import Geometry
from tests.mechanics.buckling import critical_force

SLICE = (0, 9, 14, 15)  # one of each kind of noise, all solved in the same steps: a single compilation


def test_the_slice_has_every_kind_of_noise(rows) -> None:
    assert {row["kind"] for row in rows} == set(KINDS)


@pytest.fixture(scope="module")
def rows() -> list[dict]:
    return [recovery.one(seed) for seed in SLICE]


def test_error_bars_hold_the_truth(rows) -> None:
    errors = np.array([list(row["errors"].values()) for row in rows])
    assert errors.shape == (len(SLICE), 8)
    assert np.max(np.abs(errors)) < 4.5
    assert 0.6 < np.sqrt(np.mean(errors**2)) < 1.5


def test_what_cannot_be_told_apart_is_said_to_be_undetermined(rows) -> None:
    recovery.check(rows, mean=np.inf, spread=(0.0, np.inf))


def test_the_study_notices_error_bars_that_are_too_small(rows) -> None:
    wrong = [row | {"errors": {name: 3 * error for name, error in row["errors"].items()}} for row in rows]
    with pytest.raises(AssertionError):
        recovery.check(wrong)


def test_every_draw_stays_far_from_buckling() -> None:
    g = Geometry()
    critical = [
        float(critical_force(r, g.bending, length))
        for r, length in zip(g.corner_ratios, (g.length_1, g.length_2), strict=True)
    ]
    for seed in range(8):
        case = draw(seed)
        s = case.stage
        rise = g.initial_shape(g.residual_moment(s.sigma12, 0.0, -s.sigma23))
        for z, record in zip(case.pure, case.campaign.fitted, strict=True):
            own = [share * z for share in g.shares]
            shortening = [(0.6 * o + r) * o / n for o, r, n in zip(own, rise, (g.length_1, g.length_2), strict=True)]
            force = s.restraint * g.frame_stiffness() @ np.array(shortening) + s.voltage_force * record.drive
            assert all(np.min(f) > c / 6 for f, c in zip(force, critical, strict=True))
