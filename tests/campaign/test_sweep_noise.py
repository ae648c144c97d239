"""The noise of curves is found beside their peaks, bends and jumps."""

from __future__ import annotations

import shutil
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.quality.suspect import suspects_by_data
from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.campaign.sweeps.jump import find_jump, loop_runs_backwards
from ident.campaign.sweeps.noise import sweep_noise
from ident.campaign.sweeps.together import seen_together
from tests.campaign.curves import QUALITY, RESONANCE, both_ways, duffing
from tests.end_to_end.user import DATA

# 40 frequencies, 4.5 of them within the half-power width near resonance, as in experiments/curves
FREQUENCY = RESONANCE * (
    1 + np.concatenate([np.linspace(-10, -2.5, 8), np.linspace(-2.2, 3.5, 26), np.linspace(4, 12, 6)]) / QUALITY
)
LEVELS = (1 / 3, 5 / 9, 7 / 9, 1.0)
_COLUMNS = ("frequency", "level", "amplitude", "up")


@cache
def _clean(cubic: float) -> tuple[np.ndarray, ...]:
    return both_ways(LEVELS, FREQUENCY, cubic)


def _sweep(cubic: float, phase: bool, noise: tuple[float, float, float], seed: int):
    constant, relative, turn = noise
    f, level, up, clean = _clean(cubic)
    rng = np.random.default_rng(seed)

    def white() -> np.ndarray:
        return rng.standard_normal(len(f))

    seen = clean * (1 + relative * white()) * np.exp(1j * turn * white()) + constant * (white() + 1j * white())
    volts = Channel("V", 1.0)
    sweep = Sweep("s.csv", f, level, np.abs(seen), np.angle(seen) if phase else None, up, "fundamental", volts, volts,
                  NoiseFloor(0.0))  # fmt: skip
    size = np.abs(clean)
    return sweep, np.hypot(constant, relative * size), np.hypot(constant / size, turn)


@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude"])
@pytest.mark.parametrize("cubic", [0.0, 0.03, 0.12], ids=["linear", "bent", "jumps"])
@pytest.mark.parametrize(
    "noise", [(1e-3, 2e-3, 2e-3), (2e-3, 0.0, 0.0), (1e-4, 5e-3, 5e-3)], ids=["both", "constant", "relative"]
)
def test_the_noise_of_curves(noise, cubic, phase):
    ratios = []
    for seed in range(6):
        sweep, amplitude, angle = _sweep(cubic, phase, noise, seed)
        found = sweep_noise(sweep)
        high = amplitude >= np.quantile(amplitude, 0.9)
        ratios.append(
            [np.median(found.deviation / amplitude), np.median((found.deviation / amplitude)[high]),
             np.median(found.phase_deviation / angle)]
        )  # fmt: skip
        assert found.noise.relative_error < 0.3 and "scatter" in found.noise.method
    everywhere, top, turned = np.mean(ratios, 0)
    print(f"{everywhere:.2f} {top:.2f} {turned:.2f}, scatter {np.std(ratios, 0)}")
    assert 0.88 < everywhere < 1.12
    assert 0.85 < top < (1.25 if cubic == 0.0 else 1.8 if phase or cubic < 0.1 else 2.3)
    assert not phase or 0.88 < turned < 1.12


def test_files_of_one_device_share_their_noise_however_many_they_are():
    """One of eight estimates lies far off by chance; alone it would make a floor that the device does not keep."""
    alone = 0
    for seed in range(6, 12):
        whole, *_ = _sweep(0.0, False, (1e-3, 1e-2, 1e-2), seed)
        files = [
            replace(whole, name=f"{k}.csv", **{name: getattr(whole, name)[run.rows] for name in _COLUMNS})
            for k, run in enumerate(whole.runs)
        ]
        assert len(files) == 8
        found = seen_together([sweep_noise(file) for file in files], [])
        alone += len({one.noise.sigma for one in found if isinstance(one, Sweep)}) - 1
    assert alone == 0


def test_no_kind_of_noise_is_taken_for_absent():
    """The likeliest constant part is zero in one case of ten here, and points far from the peak would decide a fit."""
    parts = []
    for seed in range(20):
        whole, *_ = _sweep(0.0, True, (3e-4, 2e-3, 2e-3), seed)
        found = sweep_noise(whole.only(np.flatnonzero(whole.level == LEVELS[-1])))
        parts.append(found.noise.sigma / 3e-4)
    assert min(parts) > 0.3 and np.median(parts) == pytest.approx(1.0, abs=0.25) and max(parts) < 2.5


def test_passes_up_and_down_tell_what_too_few_neighbours_do_not():
    """Between points that lie far apart a curve may bend, at one frequency it does not."""
    ratios = []
    for seed in range(6):
        whole, amplitude, _ = _sweep(0.12, False, (1e-3, 2e-3, 2e-3), seed)
        ratios.append(np.median(sweep_noise(whole).deviation / amplitude))
    assert 0.9 < np.mean(ratios) < 1.1 and max(ratios) < 1.15


def test_each_level_has_a_floor_of_its_own_where_ranges_differ():
    quiet, *_ = _sweep(0.0, True, (1e-4, 1e-3, 1e-3), 1)
    loud, *_ = _sweep(0.0, True, (3e-3, 1e-3, 1e-3), 2)
    top = quiet.level == LEVELS[-1]
    arrays = {name: np.where(top, getattr(loud, name), getattr(quiet, name)) for name in ("amplitude", "phase")}
    notes: list[str] = []
    (found,) = seen_together([sweep_noise(replace(quiet, **arrays))], notes)
    assert isinstance(found, Sweep) and found.own_noise is not None and "noise floor of its own" in notes[-1]
    constant = found.noises[0]
    assert np.median(constant[top]) == pytest.approx(3e-3, rel=0.25)
    assert np.median(constant[~top]) < 3e-4
    assert "1 V" in notes[-1]
    (same,) = seen_together([sweep_noise(quiet)], [])
    assert isinstance(same, Sweep) and same.own_noise is None


def test_a_flank_that_was_passed_once_has_the_noise_of_its_points_and_not_of_their_distances():
    sweep, *_ = _sweep(0.0, True, (1e-6, 1e-4, 1e-4), 3)
    rows = np.flatnonzero(sweep.up & (sweep.level == 1.0) & (sweep.frequency < RESONANCE))
    found = sweep_noise(sweep.only(rows))
    assert np.min(np.diff(np.sort(found.amplitude))) > 20 * found.noise.sigma
    coarse = sweep_noise(replace(sweep, amplitude=np.round(sweep.amplitude, 3)))
    assert coarse.noise.sigma > 0.9e-3 / np.sqrt(12.0)  # what was rounded is known no better


def test_curves_without_noise_or_with_few_points():
    sweep, *_ = _sweep(0.0, True, (0.0, 0.0, 0.0), 0)
    assert 0 < sweep_noise(sweep).noise.sigma < 2e-3
    few = both_ways((1.0,), np.linspace(480, 520, 6), 0.0)
    volts = Channel("V", 1.0)
    short = Sweep("s.csv", few[0], few[1], np.abs(few[3]), None, few[2], "fundamental", volts, volts, NoiseFloor(0.0))
    assert "too few" in sweep_noise(short).noise.method and sweep_noise(short).noise.relative_error == 1.0


def test_points_too_far_apart_give_an_upper_estimate():
    f, level, up, clean = both_ways((1.0,), np.linspace(440, 580, 15), 0.12)
    volts = Channel("V", 1.0)
    found = sweep_noise(Sweep("s.csv", f, level, np.abs(clean), None, up, "fundamental", volts, volts, NoiseFloor(0.0)))
    assert found.noise.relative_error == 1.0


@pytest.mark.parametrize("cubic", [0.15, -0.15], ids=["hardening", "softening"])
def test_jumps_stand_where_branches_end(cubic):
    f = np.arange(420.0, 580.0, 1.0)
    up, down = (find_jump(g, np.abs(duffing(1.0, g, cubic))) for g in (f, f[::-1]))
    assert up is not None and down is not None
    assert up.frequency > down.frequency and up.rise == down.rise == (cubic < 0)
    assert loop_runs_backwards(up, down) is False and loop_runs_backwards(down, up) is True
    fine = np.arange(420.0, 580.0, 0.02)
    for jump, g in ((up, fine), (down, fine[::-1])):
        step = int(np.argmax(np.abs(np.diff(np.abs(duffing(1.0, g, cubic))))))
        assert abs(jump.frequency - g[step]) <= jump.uncertainty + 0.02


@pytest.mark.parametrize("spacing", [0.5, 1.0, 3.0, 4.0])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_resonance_without_a_jump_has_none(spacing, noise):
    f = np.arange(440.0, 560.0, spacing)
    for seed in range(20):
        rng = np.random.default_rng(seed)
        f = f + 0.37 * spacing * (seed % 3 - 1)
        response = 1 / (1 - (f / 500) ** 2 + 1j * f / 500 / QUALITY) / QUALITY
        response = response + noise * rng.standard_normal(len(f))
        assert find_jump(f, np.abs(response)) is None
        assert find_jump(f, np.abs(response), np.angle(response)) is None


@pytest.mark.parametrize("phase", [True, False])
def test_a_jump_on_which_the_motion_was_on_its_way_is_one(phase: bool) -> None:
    """A point half-way down makes two steps of which neither stands out."""
    f = np.arange(420.0, 580.0, 1.0)
    response = duffing(1.0, f, 0.15)
    turned = np.angle(response) if phase else None
    clean = find_jump(f, np.abs(response), turned)
    assert clean is not None and clean.high == clean.low + 1 == clean.after
    late = np.abs(response)
    late[clean.high] = np.mean(late[[clean.low, clean.high + 1]])
    seen = find_jump(f, late, turned)
    assert seen is not None and seen.low <= clean.low and seen.high > clean.high
    assert abs(seen.frequency - clean.frequency) <= seen.uncertainty


def test_two_passes_over_the_same_frequencies_tell_the_noise():
    sweeps, ratios = [], []
    for seed in (0, 1):
        sweep, amplitude, angle = _sweep(0.03, True, (1e-3, 2e-3, 2e-3), seed)
        sweeps.append(replace(sweep, name=f"{seed}.csv", noise=NoiseFloor(1e-3, relative_error=0.1)))
    for found in seen_together(sweeps, []):
        assert isinstance(found, Sweep)
        ratios.append([np.median(found.deviation / amplitude), np.median(found.phase_deviation / angle)])
    assert np.all(np.abs(np.log(ratios)) < 0.15), ratios


def test_a_curve_that_is_listed_twice_is_called_so(tmp_path):
    shutil.copytree(DATA / "platform_sweeps", tmp_path / "twice")
    copy = tmp_path / "twice" / "copy.csv"
    shutil.copy(tmp_path / "twice" / "sweep_5V.csv", copy)
    listed = tmp_path / "twice" / "campaign.toml"
    listed.write_text(listed.read_text() + '[[record]]\nfile = "copy.csv"\nkind = "sweep"\n')
    (suspect,) = suspects_by_data(read_campaign(tmp_path / "twice"))
    assert (suspect.file, suspect.kind) == ("copy.csv", "duplicate") and "sweep_5V.csv" in suspect.says
