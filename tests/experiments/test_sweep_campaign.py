"""The shipped sweeps are what their PROVENANCE says, and the simulators of stepped sines are right."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments import make_sweeps
from experiments.curves import generator
from experiments.curves.files import STYLES, write
from experiments.curves.sweeps import drive_phase, fundamental, sweep
from experiments.hidden_effects.laws import INDEX, LAWS
from experiments.simulator.signals import sine
from experiments.simulator.stage import acceleration, prepare
from ident.campaign import read_campaign
from ident.campaign.sweeps.dynamic_stiffness import dynamic_stiffness

ROOT = Path(__file__).resolve().parents[2]
FOLDER = make_sweeps.DATA / make_sweeps.NAME


@pytest.fixture(scope="module")
def campaign():
    return read_campaign(FOLDER)


def test_a_pass_is_reproduced_and_settled():
    near = np.array([504.0, 511.0, 512.0, 513.0])
    up, down = make_sweeps.passes(9.0, frequencies=near)
    shipped = np.genfromtxt(FOLDER / "sweep_9V.csv", delimiter=",", skip_header=2).T
    rows = [int(np.flatnonzero((shipped[0] == f) & (shipped[4] == 1))[0]) for f in near]
    noise = 1e-3 * 10 + 0.01 * np.abs(up.response) * 1e6
    assert np.all(np.abs(shipped[2][rows] - np.abs(up.response) * 1e6) < noise)
    largest = np.max(np.abs(up.response))
    np.testing.assert_allclose(down.response[::-1], up.response, rtol=0, atol=1e-5 * largest)


def test_a_point_agrees_with_another_solver(monkeypatch):
    f, level = 508.0, 9.0
    monkeypatch.setattr(make_sweeps, "SETTLED", 60)  # the transient too must agree
    t = np.arange((make_sweeps.SETTLED + make_sweeps.READ) * 64 + 1) / (64 * f)
    drive = sine(level, f)
    constants, curve = prepare(make_sweeps.PAPER, drive, t)

    def rate(now: float, state: np.ndarray) -> tuple[float, float]:
        at = np.array([now])
        return state[1], acceleration(state[0], state[1], drive.value(at)[0], drive.rate(at)[0], constants, curve)

    window = slice(-make_sweeps.READ * 64 - 1, -1)
    found = solve_ivp(rate, (0, t[-1]), (0, 0), method="DOP853", t_eval=t[window], rtol=1e-9, atol=1e-15)
    other = fundamental(found.y[0], 2 * np.pi * f * t[window])
    mine = make_sweeps.passes(level, frequencies=np.array([f]))[0].response[0]
    assert abs(mine - other) < 1e-4 * abs(other)


def test_the_numbers_of_the_provenance(campaign):
    assert [sweep.holdout for sweep in campaign.sweeps] == [level == 7.0 for level in make_sweeps.LEVELS]
    peaks = {sweep.level[0]: sweep.frequency[np.argmax(sweep.amplitude)] for sweep in campaign.sweeps}
    assert peaks[3.0] == pytest.approx(500, abs=1) and peaks[9.0] == pytest.approx(511, abs=1)
    seen = dynamic_stiffness(campaign.sweeps)
    assert seen is not None and 12 < np.ptp(seen.stiffness.curve) < 14 and seen.stiffness.misfit > 4
    truth = tomllib.loads((FOLDER / "truth.toml").read_text(encoding="utf-8"))
    for record in campaign.sweeps:
        assert record.noise.sigma == pytest.approx(truth["noise"], rel=0.35)
        assert record.relative_noise == pytest.approx(truth["relative_noise"], rel=0.2)
        assert record.phase_noise == pytest.approx(truth["phase_noise"], rel=0.25)
    assert all(file.stat().st_size < 6000 for file in FOLDER.glob("*.csv"))


def test_the_phase_runs_on_and_the_lock_in_sees_the_fundamental_alone():
    phase, frequency, point, step = drive_phase(np.array([0.9, 1.0, 1.1]), 20)
    assert np.all(np.diff(phase) > 0) and np.max(np.diff(phase)) < 1.2 * step * 1.1 / 2 + 1e-12
    np.testing.assert_allclose(np.diff(phase), frequency[:-1] * step / 2, rtol=1e-9)
    assert [int(np.sum(point == k)) for k in range(3)] == sorted(
        (int(np.sum(point == k)) for k in range(3)), reverse=True
    )
    signal = 2.0 * np.sin(phase - 0.7) + 0.3 + 0.5 * np.cos(3 * phase) + 0.2 * np.sin(2 * phase)
    last = slice(-700, None)
    assert fundamental(signal[last], phase[last]) == pytest.approx(2.0 * np.exp(-0.7j), rel=1e-9)


def _duffing(cubic: float) -> tuple[np.ndarray, np.ndarray]:
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    c[INDEX["cubic-stiffness"]] = cubic
    return c, s


def test_a_linear_device_gives_its_transfer_function():
    quality = 25.0
    ratios = np.array([0.9, 0.98, 1.0, 1.03, 1.2])
    found = sweep(ratios, 0.5, 120, 1 / quality, quality, *_duffing(0.0), np.zeros(14))
    exact = 0.5 / quality / (1 - ratios**2 + 1j * ratios / quality)
    np.testing.assert_allclose(found, exact, atol=3e-5 * np.max(np.abs(exact)))


def test_a_weakly_nonlinear_device_jumps_at_the_folds_of_the_theory():
    """Folds of a²[(1 + ¾ c a² − r²)² + (r/Q)²] = F²: where it has a double root in a² (Nayfeh & Mook, §4.1.1)."""
    quality, cubic, force = 60.0, 0.12, 1 / 60.0
    fine = np.arange(1.0, 1.1, 2e-5)
    counts = []
    for r in fine:
        k = 0.75 * cubic
        roots = np.roots([k**2, 2 * k * (1 - r**2), (1 - r**2) ** 2 + (r / quality) ** 2, -(force**2)])
        counts.append(int(np.sum(np.abs(roots.imag) < 1e-9)))
    bistable = fine[np.array(counts) == 3]
    ratios = np.arange(bistable[0] - 0.006, bistable[-1] + 0.006, 5e-4)
    both = np.concatenate([ratios, ratios[::-1]])
    found = np.abs(sweep(both, 1.0, 260, 1 / quality, quality, *_duffing(cubic), np.zeros(14)))
    up, down = found[: len(ratios)], found[len(ratios) :][::-1]
    jumps = [ratios[int(np.argmax(-np.diff(run)))] + 2.5e-4 for run in (up, down)]
    assert jumps[0] == pytest.approx(bistable[-1], abs=1.2e-3)  # theory of first order in the detuning, steps of 5e-4
    assert jumps[1] == pytest.approx(bistable[0], abs=8e-4)


def test_a_strong_law_agrees_with_scipy():
    """Backbone, harmonics and all: one point with a cubic spring and quadratic drag."""
    quality, level, ratio = 20.0, 1.0, 1.02
    c, s = np.zeros(len(LAWS)), np.zeros((len(LAWS), 3))
    for name, value, shape in (("quadratic-damping", 0.05, (0.05, 0, 0)), ("cubic-stiffness", 0.1, (0.1, 0, 0))):
        c[INDEX[name]], s[INDEX[name]] = value, shape

    def rate(t: float, x: np.ndarray) -> list[float]:
        z, v = x
        drag = 0.05 * v * np.sqrt(v * v + 0.05**2)
        return [v, level / quality * np.sin(ratio * t) - z - v / quality - 0.1 * z**3 / (1 + 0.1 * z * z) - drag]

    periods = 100
    t = np.arange(64 * periods) * 2 * np.pi / (64 * ratio)
    found = solve_ivp(rate, (0, t[-1]), (0, 0), method="DOP853", t_eval=t, rtol=1e-10, atol=1e-12)
    window = slice(-8 * 64, None)
    exact = fundamental(found.y[0][window], ratio * t[window])
    mine = sweep(np.array([ratio]), level, periods, 1 / quality, quality, c, s, np.zeros(14))[0]
    assert abs(mine - exact) < 5e-5 * abs(exact)


def test_every_style_of_a_laboratory_is_read(tmp_path):
    case = _small_case()
    for style in STYLES:
        for phase in (True, False):
            folder = tmp_path / f"{style}{phase}"
            write(case, folder, style, phase, holdout=case.curves[2].level)
            sweeps = read_campaign(folder).sweeps
            runs = {(round(run.level, 3), run.up): (one, run.rows) for one in sweeps for run in one.runs}
            assert len(runs) == len(case.curves), style
            for curve in case.curves:
                one, rows = runs[round(curve.level, 3), curve.up]
                seen = one.amplitude[rows] * (np.exp(1j * one.phase[rows]) if one.phase is not None else 1.0)
                wanted = curve.response if one.phase is not None else np.abs(curve.response)
                np.testing.assert_allclose(one.frequency[rows], curve.frequency, rtol=1e-6)
                np.testing.assert_allclose(seen, wanted, atol=2e-4 * np.max(np.abs(curve.response)))
                assert one.holdout == (curve.level == case.curves[2].level)


def _small_case() -> generator.Case:
    """A linear device in closed form: the tables matter here, not the motion."""
    device = generator.Device("platform", 500.0, 30.0, 1 / 30, 20e-6, 9.0, 1.0)
    ratios = generator.frequencies(30.0)
    curves = []
    for level in generator.LEVELS:
        response = level / 30 / (1 - ratios**2 + 1j * ratios / 30) * device.unit
        curves.append(generator.Curve(9 * level, True, 500 * ratios, response, response))
        curves.append(generator.Curve(9 * level, False, 500 * ratios[::-1], response[::-1], response[::-1]))
    return generator.Case(device, curves, {})


def test_the_simulators_do_not_import_the_tool():
    files = [*(ROOT / "experiments" / "curves" / name for name in ("sweeps.py", "generator.py", "files.py"))]
    for file in [*files, ROOT / "experiments" / "make_sweeps.py"]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "ident" for name in names), file
