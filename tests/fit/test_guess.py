"""Starting values read off the records, against known oscillators."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit.linear.guess import data_scales, guess_linear
from ident.fit.linear.stretches import oscillator_filter, stretch_of, sums


@pytest.mark.parametrize(("f", "q", "h"), [(500, 30, 4e-5), (68, 20, 1 / 610), (500, 0.3, 1e-4), (1, 50, 1e-2)])
def test_the_filter_is_the_first_order_hold_of_scipy(f, q, h):
    omega = 2 * np.pi * f
    b, a, _ = signal.cont2discrete(([1.0], [1.0, omega / q, omega**2]), h, method="foh")
    ours_b, ours_a = oscillator_filter(f, q, h)
    np.testing.assert_allclose(ours_b, np.ravel(b), rtol=1e-6)
    np.testing.assert_allclose(ours_a, a, rtol=1e-9)


def record(f0: float, q: float, gain: float, drive_hz: float, quiet: int = 0) -> Trace:
    step = 1 / 25_000
    t = step * np.arange(2500 + quiet)
    drive = np.where(np.arange(len(t)) >= quiet, 5 * np.sin(2 * np.pi * drive_hz * (t - quiet * step)), 0.0)
    response = gain * signal.lfilter(*oscillator_filter(f0, q, step), drive)
    channel = Channel("V", 1.0)
    return Trace("r", t, drive, response, channel, channel, NoiseFloor(1e-9), "rest")


@pytest.mark.parametrize(("f0", "q"), [(480.0, 25.0), (530.0, 60.0)])
def test_resonance_quality_and_gain_are_found(f0, q):
    found = guess_linear([record(f0, q, 3.0, 317.0), record(f0, q, 3.0, 505.0)])
    np.testing.assert_allclose([found.frequency, found.quality, found.gain], [f0, q, 3.0], rtol=2e-3)


def test_a_long_quiet_start_does_not_hide_the_resonance():
    found = guess_linear([record(500.0, 30.0, 2.0, 400.0, quiet=9000)])
    np.testing.assert_allclose([found.frequency, found.quality, found.gain], [500.0, 30.0, 2.0], rtol=5e-3)


def test_records_that_share_a_clock_say_together_what_each_says_alone():
    records = [record(500.0, 30.0, 2.0, hz) for hz in (317.0, 480.0, 505.0, 530.0)]
    records = records[:2] + [replace(own, start="unknown") for own in records[2:]]
    together = sums([stretch_of(own) for own in records], 490.0, 25.0, 1.0)
    alone = [sums([stretch_of(replace(own))], 490.0, 25.0, 1.0) for own in records]
    np.testing.assert_allclose(together, np.sum(alone, axis=0), rtol=1e-10)


def test_a_sharp_resonance_between_the_points_of_the_grid_is_tried_where_a_record_is_liveliest():
    # Far from resonance a leak of the drive outweighs the motion, and no broad resonance describes it.
    f0, q = 452.2, 56.0
    near, far = record(f0, q, 3.0, 452.3), record(f0, q, 3.0, 751.0)
    leak = 1.6 * 3.0 / (2 * np.pi * f0) ** 2
    records = [replace(near, name=name) for name in "ab"]
    records = [replace(own, response=own.response + leak * own.drive) for own in (*records, far)]
    assert guess_linear(records).frequency == pytest.approx(f0, rel=0.01)


def test_the_scale_of_a_velocity_is_that_of_the_motion_where_the_spring_is_as_good_as_none():
    """A stage with friction was fitted with a resonance at 2 mHz; the slope across 23 s of it was none, and bounds of
    the friction that are placed by it were no numbers."""
    driven = record(480.0, 25.0, 3.0, 317.0)
    at_resonance, far_below = (data_scales([driven], frequency).velocity for frequency in (480.0, 0.002))
    steepest = float(np.max(np.abs(np.gradient(driven.response, driven.step))))
    assert 0.8 * steepest < at_resonance < steepest  # 99.5 % of the slopes are no steeper
    assert far_below == pytest.approx(at_resonance, rel=0.05)
