"""What is said of curves before any model, and what their dynamic stiffness shows."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.record import Channel, NoiseFloor, Sweep
from ident.campaign.sweeps.dynamic_stiffness import dynamic_stiffness
from ident.campaign.sweeps.judge import judge_sweep
from ident.campaign.sweeps.jump import find_jump
from ident.report.words.sweeps import what_the_sweeps_tell
from tests.campaign.curves import QUALITY, RESONANCE, both_ways, duffing, write_table

VOLT = Channel("V", 1.0)
NEAR = np.linspace(460.0, 560.0, 81)


def _sweep(f, level, up, response, *, noise: float = 1e-3, phase: bool = True) -> Sweep:
    rng = np.random.default_rng(0)
    seen = response + noise * (rng.standard_normal(len(f)) + 1j * rng.standard_normal(len(f)))
    angle = np.angle(seen) if phase else None
    return Sweep("s.csv", f, level, np.abs(seen), angle, up, "fundamental", VOLT, VOLT, NoiseFloor(noise, (), "", 0.1))


def _linear(spacing: float, shift: float) -> Sweep:
    f = np.arange(440.0 + shift, 560.0, spacing)
    return _sweep(f, np.ones(len(f)), np.ones(len(f), bool), duffing(1.0, f, 0.0), noise=0.0)


@pytest.mark.parametrize("points, error", [(2, 0.27), (4, 0.07), (8, 0.02)])
def test_the_half_power_width_of_so_many_points(points, error):
    """What the number that `judge_sweep` asks for is worth."""
    width = RESONANCE / QUALITY
    spacing = width / points
    found = [judge_sweep(_linear(spacing, shift)).runs[0].width for shift in np.linspace(0, spacing, 9)]
    worst = max(abs(w / width - 1) for w in found if w is not None)
    assert None not in found and error / 4 < worst < error


def test_levels_peaks_and_jumps():
    judged = judge_sweep(_sweep(*both_ways((0.3, 1.0), NEAR, 0.15)))
    assert [(run.level, run.up, run.points) for run in judged.runs] == [
        (0.3, True, 81), (0.3, False, 81), (1.0, True, 81), (1.0, False, 81)]  # fmt: skip
    assert judged.both_ways and judged.phase and not judged.remarks
    assert [run.jump is not None for run in judged.runs] == [False, False, True, True]
    assert judged.runs[0].within >= 4 and judged.runs[0].peak == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("sag", [0.0, 1e-3])  # of a level that was monitored
def test_a_steep_curve_that_both_ways_repeat_is_no_jump(sag):
    f = np.linspace(95.0, 105.0, 60)
    amplitude = 0.1 + 0.9 * np.exp(-(f - 100.0) / 30.0) / (1 + np.exp(-(f - 100.0) / 0.12))
    level = 1.0 + sag * np.random.default_rng(0).standard_normal(120)
    up = np.repeat([True, False], 60)
    sweep = Sweep("a.csv", np.tile(f, 2), level, np.tile(amplitude, 2), None, up, "fundamental", VOLT, VOLT,
                  NoiseFloor(1e-3))  # fmt: skip
    assert [run.jump for run in judge_sweep(sweep).runs] == [None, None]
    assert find_jump(f, amplitude) is not None


def test_what_is_unusual_is_said():
    f = np.linspace(460.0, 560.0, 11)
    few = judge_sweep(_sweep(f, np.ones(11), np.ones(11, bool), duffing(1.0, f, 0.0), noise=1e-4))
    assert "points within the half-power width" in " ".join(few.remarks)
    f = np.linspace(400.0, 498.0, 60)
    cut = judge_sweep(_sweep(f, np.ones(60), np.ones(60, bool), duffing(1.0, f, 0.0)))
    assert "sweep further" in " ".join(cut.remarks)
    up = duffing(1.0, NEAR, 0.15)
    only = judge_sweep(_sweep(NEAR, np.ones(81), np.ones(81, bool), up))
    assert "swept up only" in " ".join(only.remarks)
    f, level, way, response = both_ways((1.0,), np.linspace(400.0, 560.0, 90), 0.0)
    late = judge_sweep(_sweep(f, level, way, response * np.exp(-1j)))
    assert "-60°" in " ".join(late.remarks)
    assert not judge_sweep(_sweep(f, level, way, -response)).remarks  # an inverted sensor is no delay


def test_what_a_set_of_levels_can_tell(tmp_path):
    f, level, up, response = both_ways((3.0, 9.0), NEAR, 0.0)
    columns = [f, level, 0.1 * np.abs(response), np.degrees(np.angle(response)), up.astype(float)]
    header = "f (Hz),level (V),amplitude (um),phase (deg),up"

    def told(header: str, columns: list[np.ndarray]) -> str:
        return " ".join(what_the_sweeps_tell(read_campaign(write_table(tmp_path / "s.csv", header, columns))))

    whole = told(header, columns)
    assert not any(words in whole for words in ("amplitudes alone", "one drive level", "span", "both ways"))
    assert "amplitudes alone" in told("f (Hz),level (V),amplitude (um),up", columns[:3] + columns[4:])
    one = [column[level == 3.0] for column in columns]
    assert "one drive level" in told(header, one)
    assert "both ways" in told(header, [column[up] for column in columns])
    columns[1] = np.where(level == 3.0, 6.0, 9.0)
    assert "factor of 1.5" in told(header, columns)


@pytest.mark.parametrize("cubic", [0.0, 0.12, -0.08], ids=["linear", "hardening", "softening"])
def test_the_natural_frequency_is_the_backbone_whatever_the_level(cubic):
    """f(a) = f0 √(1 + ¾ c a²) and Γ = ω0/Q, Nayfeh & Mook §4.1.1, from points of which most are off the backbone."""
    sweep = _sweep(*both_ways((0.4, 0.7, 1.0), NEAR, cubic))
    seen = dynamic_stiffness([sweep])
    assert seen is not None and seen.stiffness.misfit < 1.3 and seen.damping.misfit < 1.3
    inner = (seen.stiffness.at > 0.2) & (seen.stiffness.at < 0.95 * seen.stiffness.at[-1])
    backbone = RESONANCE * np.sqrt(1 + 0.75 * cubic * seen.stiffness.at**2)
    np.testing.assert_allclose(seen.stiffness.curve[inner], backbone[inner], rtol=1e-3)
    inner = (seen.damping.at > 0.2 * 3e3) & (seen.damping.at < 0.95 * seen.damping.at[-1])
    np.testing.assert_allclose(seen.damping.curve[inner], 2 * np.pi * RESONANCE / QUALITY, rtol=0.06)


def test_a_law_of_the_drive_keeps_the_levels_apart():
    f, level, up, response = both_ways((0.4, 0.7, 1.0), NEAR, 0.0)
    seen = dynamic_stiffness([_sweep(f, level, up, response * (1 + 0.2 * level**2))])
    assert seen is not None and max(seen.stiffness.misfit, seen.damping.misfit) > 3.0


def test_without_phase_there_is_no_such_picture():
    sweep = _sweep(*both_ways((0.4, 1.0), NEAR, 0.1), phase=False)
    assert dynamic_stiffness([sweep]) is None and dynamic_stiffness([]) is None


def test_one_table_of_many_levels_as_a_record_each(tmp_path):
    f, level, up, response = both_ways((3.0, 6.0, 9.0), NEAR, 0.0)
    write_table(tmp_path / "s.csv", "f (Hz),Drive (Vpp),amplitude (um)", [f, 2 * level, 0.1 * np.abs(response)])
    record = '[[record]]\nfile = "s.csv"\nkind = "sweep"\nlevel = "{}"\n'
    (tmp_path / "campaign.toml").write_text("".join(record.format(v) for v in ("3 V", "12 Vpp")))
    sweeps = read_campaign(tmp_path).sweeps
    assert [set(sweep.level) for sweep in sweeps] == [{3.0}, {6.0}]
    assert [len(sweep.runs) for sweep in sweeps] == [2, 2] and sweeps[0].name != sweeps[1].name
    (tmp_path / "campaign.toml").write_text(record.format("4 V"))
    with pytest.raises(Exception, match="its levels are 3, 6, 9"):
        read_campaign(tmp_path)


def test_directions_in_files_of_their_own_are_turned_together(tmp_path):
    f, level, up, response = both_ways((5.0, 9.0), NEAR, 0.15 / 81)
    for volts in (5.0, 9.0):
        for way, name in ((True, "down"), (False, "up")):  # each is called what it is not
            here = (level == volts) & (up == way)
            write_table(
                tmp_path / f"{volts:g}V_{name}.csv", "f (Hz),A (um)", [f[here][::-1], np.abs(response[here][::-1])]
            )
    campaign = read_campaign(sorted(tmp_path.glob("*.csv")))
    assert "exchanged" in " ".join(campaign.notes)
    assert {(sweep.name, bool(sweep.up[0])) for sweep in campaign.sweeps} == {
        ("5V_down.csv", True), ("5V_up.csv", False), ("9V_down.csv", True), ("9V_up.csv", False)}  # fmt: skip


def test_a_new_campaign_of_curves(tmp_path):
    from ident.campaign.propose import propose

    f, level, up, response = both_ways((3.0, 6.0, 9.0), NEAR, 0.001)
    one = write_table(tmp_path / "all.csv", "f (Hz),Drive (V),A (um)", [f, level, 0.1 * np.abs(response)])
    files = []
    for volts in (3.0, 6.0, 9.0):
        for way, name in ((True, "up"), (False, "down")):
            here = (level == volts) & (up == way)
            path = tmp_path / f"{volts:g}V_{name}.csv"
            parts = [0.1 * np.real(response[here]), 0.1 * np.imag(response[here])]
            files.append(write_table(path, "f (Hz),Re (um),Im (um)", [f[here], *parts]))
    for paths, count in (([one], 3), (files, 6)):
        (tmp_path / "campaign.toml").write_text(propose(paths, tmp_path), encoding="utf-8")
        campaign = read_campaign(tmp_path)
        assert len(campaign.sweeps) == count
        assert {run.level for sweep in campaign.sweeps if sweep.holdout for run in sweep.runs} == {6.0}
        assert {(run.level, run.up) for sweep in campaign.sweeps for run in sweep.runs} == {
            (volts, way) for volts in (3.0, 6.0, 9.0) for way in (True, False)}  # fmt: skip


def test_passes_that_do_not_repeat_are_noisier_than_their_neighbours_tell(tmp_path):
    f, level, up, response = both_ways((3.0, 9.0), NEAR, 0.15 / 81)
    rng = np.random.default_rng(3)
    seen = np.abs(response) * (1 + 5e-4 * rng.standard_normal(len(f)))
    header = "f (Hz),level (V),A (um)"
    steady = read_campaign(write_table(tmp_path / "s.csv", header, [f, level, seen]))
    assert not any("differ" in note for note in steady.notes)
    drifted = seen * np.where(up, 1.02, 1.0)
    campaign = read_campaign(write_table(tmp_path / "s.csv", header, [f, level, drifted]))
    assert "up and down differ by" in " ".join(campaign.notes)
    assert campaign.sweeps[0].relative_noise == pytest.approx(0.02 / np.sqrt(2), rel=0.1)
    for way, name in ((True, "up"), (False, "down")):
        for volts in (3.0, 9.0):
            here = (level == volts) & (up == way)
            write_table(tmp_path / f"{volts:g}V_{name}.csv", "f (Hz),A (um)", [f[here], drifted[here]])
    campaign = read_campaign(sorted(tmp_path.glob("?V_*.csv")))
    assert all(0.01 < sweep.relative_noise < 0.02 for sweep in campaign.sweeps)
