"""The shipped campaigns are what their PROVENANCE says."""

import ast
import tomllib
from dataclasses import replace
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments import make_campaigns as campaigns
from experiments.simulator.geometry import Geometry
from experiments.simulator.signals import sine
from experiments.simulator.stage import acceleration, prepare, resonance, simulate
from experiments.simulator.stiffness import segment_stiffness

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("name", "index"),
    [
        ("platform_317hz", 0),
        ("platform_317hz", 6),
        ("platform_fe", 3),
        ("oscillator", 0),
        ("mystery_platform", 3),
        ("mystery_platform", 7),
        ("mystery_platform", 8),
    ],
)
def test_record_is_reproduced_to_rounding(name: str, index: int) -> None:
    columns = campaigns.STYLES[name][0]
    shipped = np.genfromtxt(campaigns.DATA / name / campaigns.PLANS[name][index].file, delimiter=",", skip_header=2).T
    for column, file, made in zip(columns, shipped, campaigns.record(name, index), strict=True):
        # One count: another machine's last bit may fall on the other side of a rounding edge.
        np.testing.assert_allclose(file, made * column.per_si, atol=1.01 * 10.0**-column.decimals, rtol=0)


@pytest.mark.parametrize("name", list(campaigns.PLANS))
def test_folder_lists_its_files_and_is_small(name: str) -> None:
    folder = campaigns.DATA / name
    listed = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))["record"]
    assert {r["file"] for r in listed} == {f.name for f in folder.glob("*.csv")}
    assert all(f.stat().st_size < 120_000 for f in folder.glob("*.csv"))
    truth = tomllib.loads((folder / "truth.toml").read_text(encoding="utf-8"))
    assert truth["parameters"] == pytest.approx(campaigns.TRUTHS[name][0])


def test_simulators_do_not_import_the_tool() -> None:
    folder = ROOT / "experiments"
    hidden = [folder / "hidden_effects" / name for name in ("generator.py", "laws.py", "linear.py")]
    for file in [*(folder / "simulator").glob("*.py"), *hidden, folder / "make_campaigns.py"]:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(n.split(".")[0] == "ident" for n in names), file


def test_geometry_meets_the_reference_numbers() -> None:
    g = Geometry()
    assert g.neutral_axis == pytest.approx(19.0984367367e-6, rel=1e-11)
    assert g.twisting == pytest.approx(1.77901083585e-6, rel=1e-10)
    assert g.stage_stiffness == pytest.approx(605.146382124, rel=1e-11)
    assert g.residual_moment(90e6, 20e6, -10e6) == pytest.approx(2.1461529474e-5, rel=1e-10)
    np.testing.assert_allclose(g.initial_shape(2.1461529474e-5), (-25.5492505359e-6, 28.3276243163e-6), rtol=1e-9)
    np.testing.assert_allclose(g.frame_stiffness(), [[164536.448, 110040.995], [110040.995, 231237.8845]], rtol=1e-8)


@pytest.mark.parametrize("x", [-4.9, -0.301, -0.299, 0.0, 1e-9, 0.299, 0.301, 10.0])
def test_segment_stiffness_is_the_closed_form(x: float) -> None:
    r = 0.4
    with mpmath.workdps(60):
        big = mpmath.mpf(x) + mpmath.mpf(10) ** -30
        u = mpmath.sqrt(big)
        c, s = mpmath.cosh(u), mpmath.sinh(u)
        exact = big / (1 - s / u + (c - 1) * (c - 1 + r * u * s) / (u * (s + r * u * c)))
    assert segment_stiffness(x, r) == pytest.approx(float(mpmath.re(exact)), rel=1e-12)


@pytest.mark.parametrize("closure", ["axial-force", "sign-change", "curve"])
def test_fine_steps_agree_with_an_adaptive_solver(closure: str) -> None:
    stage = replace(campaigns.PAPER, closure=closure, width=2e-6)
    curve = campaigns.finite_element_curve() if closure == "curve" else None
    drive, t = sine(8, 317), np.arange(400) / (80 * 317)
    constants, table = prepare(stage, drive, t, curve=curve)

    def rate(now: float, state: np.ndarray) -> tuple[float, float]:
        at = np.array([now])
        return state[1], acceleration(*state, drive.value(at)[0], drive.rate(at)[0], constants, table)

    exact = solve_ivp(rate, (0, t[-1]), (0, 0), method="DOP853", t_eval=t, rtol=1e-10, atol=1e-14).y[0]
    assert np.max(np.abs(simulate(stage, drive, t, curve=curve)[0] - exact)) < 1e-8 * np.max(np.abs(exact))


def test_friction_agrees_with_an_adaptive_solver() -> None:
    stage, drive, t = campaigns.MYSTERY, sine(3, 500), np.arange(400) / (80 * 500)
    constants, table = prepare(stage, drive, t)

    def rate(now: float, state: np.ndarray) -> tuple[float, float]:
        at = np.array([now])
        return state[1], acceleration(*state, drive.value(at)[0], drive.rate(at)[0], constants, table)

    # Its steps must be kept short: the friction turns within 1 mm/s.
    exact = solve_ivp(rate, (0, t[-1]), (0, 0), method="DOP853", t_eval=t, rtol=1e-10, atol=1e-14, max_step=2e-6).y[0]
    assert np.max(np.abs(simulate(stage, drive, t)[0] - exact)) < 1e-4 * campaigns.STYLES["mystery_platform"][1]


@pytest.mark.parametrize(("volts", "hertz", "share"), [(1.5, 503, 0.104), (9, 510, 0.020), (8, 317, 0.001)])
def test_friction_of_the_mystery_takes_most_from_weak_motion_at_resonance(
    volts: float, hertz: float, share: float
) -> None:
    """Dry friction takes a fixed force: its share of the motion falls as the motion grows."""
    t = np.arange(40 * 80) / (80 * hertz)

    def level(stage) -> float:
        return float(np.std(simulate(stage, sine(volts, hertz), t)[0][-800:]))

    free = replace(campaigns.MYSTERY, friction=0.0)
    assert 1 - level(campaigns.MYSTERY) / level(free) == pytest.approx(share, abs=0.001)


def test_platform_317hz_has_the_numbers_of_the_paper() -> None:
    assert sum(Geometry().initial_shape(campaigns.MOMENT)) == pytest.approx(2.78e-6, abs=0.01e-6)
    frequencies = np.arange(496.0, 515.0, 1.0)
    low, high = (resonance(campaigns.PAPER, volts, frequencies) for volts in (3, 9))
    assert _peak(frequencies, low) == pytest.approx(500, abs=0.5)
    assert 510 < _peak(frequencies, high) < 511


def _peak(x: np.ndarray, y: np.ndarray) -> float:
    i = int(np.argmax(y))
    a, b, _ = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2], 2)
    return float(x[i] - b / (2 * a))


def test_residual_stress_makes_the_offset_of_platform_317hz() -> None:
    t = np.arange(40 * 80) / (80 * 317)

    def harmonics(stage) -> np.ndarray:
        tail = simulate(stage, sine(8, 317), t)[0][-800:]
        return np.fft.rfft(tail)[[0, 10, 20]] / np.array([800, 400, 400])

    mean, first, second = harmonics(campaigns.PAPER)
    assert mean.real == pytest.approx(-0.118e-6, abs=0.005e-6)
    assert abs(first) == pytest.approx(3.87e-6, abs=0.02e-6)
    assert 0.04 < abs(second) / abs(first) < 0.06
    off = harmonics(campaigns.without(campaigns.PAPER, stress=True))
    assert abs(off[0]) < 1e-3 * abs(first) and abs(off[2]) < 1e-3 * abs(first)
    plain = harmonics(campaigns.without(campaigns.PAPER, hysteresis=True))
    assert plain[0].real == pytest.approx(mean.real, rel=0.1)


def test_platform_clean_follows_the_linear_formula() -> None:
    stage, g = campaigns.CLEAN, Geometry()
    t = np.arange(100 * 80) / (80 * 317)
    amplitude = abs(np.fft.rfft(simulate(stage, sine(8, 317), t)[0][-800:])[10]) / 400
    w, w0 = 2 * np.pi * 317, 2 * np.pi * stage.frequency
    linear = (
        g.drive_gain * stage.d31 * 8 / g.pzt_thickness / g.stage_mass / abs(w0**2 - w**2 + 1j * w * w0 / stage.quality)
    )
    assert amplitude == pytest.approx(linear, rel=1e-4)


def test_platform_fe_stays_on_its_curve() -> None:
    z, force = campaigns.finite_element_curve()
    middle = int(np.argmin(np.abs(z)))
    slope = 4 * (force[middle + 1] - force[middle - 1]) / (z[middle + 1] - z[middle - 1])
    assert 0.014 < slope / Geometry().stage_stiffness - 1 < 0.019
    for plan in campaigns.PLANS["platform_fe"]:
        assert np.max(np.abs(campaigns.noiseless("platform_fe", plan))) < 60e-6


def test_oscillator_is_visibly_cubic() -> None:
    largest = max(
        float(np.max(np.abs(campaigns.noiseless("oscillator", p))))
        for p in campaigns.PLANS["oscillator"]
        if not p.holdout
    )
    circuit = campaigns.CIRCUIT
    assert 0.1 < circuit.cubic * largest**2 / (2 * np.pi * circuit.frequency) ** 2 < 0.6
