"""Steady responses against closed forms and an independent solver: amplitude, phase, derivatives, folds, stability."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator
from ident.campaign.sweeps.jump import find_jump
from ident.effects.registry import built_in
from ident.model import Model
from ident.response import Equation
from ident.response.branches import follow
from ident.response.controlled import Points, at_amplitude
from ident.response.memory import Seen, memory_along
from ident.response.periodic import Periodic
from ident.response.sweep import run_along
from tests.fit.test_curves import closed_form

FREQUENCY, QUALITY, GAIN, CUBIC = 40.0, 50.0, 100.0, 3e6
STEPS = 128


def duffing(cubic: float = CUBIC) -> Periodic:
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    return Periodic(Equation(model), np.array([FREQUENCY, QUALITY, GAIN, cubic, 0.0]), STEPS)


def points(frequency: np.ndarray, amplitude: np.ndarray) -> Points:
    n = len(frequency)
    return Points(frequency, np.ones(n), amplitude, np.zeros(n), np.zeros(n, bool))


def test_a_linear_oscillator_needs_the_drive_of_its_transfer_function() -> None:
    frequency = np.linspace(36, 44, 9)
    found = at_amplitude(duffing(0.0), points(frequency, np.full(9, 0.02)))
    omega, own = 2 * np.pi * frequency, 2 * np.pi * FREQUENCY
    exact = (own**2 - omega**2 + 1j * own * omega / QUALITY) * 0.02 / GAIN
    assert found.converged.all()
    np.testing.assert_allclose(found.needed, exact, rtol=2e-5)


def needed_exactly(model: Periodic, at: Points) -> np.ndarray:
    """The drive after a last step of Newton's method more, for differences."""
    return at_amplitude(model, at, at_amplitude(model, at).unknowns).needed


def test_derivatives_are_those_of_differences() -> None:
    model, at = duffing(), points(np.array([39.0, 40.6, 41.5]), np.array([0.01, 0.03, 0.02]))
    found = at_amplitude(model, at, at_amplitude(model, at).unknowns)
    slopes = found.slopes(np.diag(model.values))
    for i in range(4):
        sides = []
        for side in (1e-6, -1e-6):
            values = model.values.copy()
            values[i] *= 1 + side
            sides.append(needed_exactly(Periodic(model.equation, values, STEPS), at))
        np.testing.assert_allclose(slopes[i], (sides[0] - sides[1]) / 2e-6, rtol=1e-5, atol=1e-8)
    for name, slope in (("amplitude", found.by_amplitude), ("frequency", found.by_frequency)):
        value = getattr(at, name)
        up, down = (needed_exactly(model, at._replace(**{name: value * (1 + s)})) for s in (1e-6, -1e-6))
        np.testing.assert_allclose(slope, (up - down) / (2e-6 * value), rtol=1e-5)


def test_one_look_at_points_that_are_nearly_known_brings_their_derivatives_along(monkeypatch: Any) -> None:
    model, at = duffing(), points(np.array([39.0, 40.6, 41.5]), np.array([0.01, 0.03, 0.02]))
    known, looks = at_amplitude(model, at), []
    directions = np.diag(model.values)
    moved = Periodic(model.equation, model.values * (1 + 1e-4), STEPS)
    start = known.unknowns.copy()
    start[:, :-1] += 1e-4 * np.sum(known.moves(directions).unknowns, axis=0)
    expected = at_amplitude(moved, at, start).moves(directions)
    one = Periodic.look
    monkeypatch.setattr(Periodic, "look", lambda *given: (looks.append(1), one(*given))[1])
    found = at_amplitude(moved, at, start, directions).moves(directions)
    assert len(looks) == 1
    np.testing.assert_allclose(found.needed, expected.needed, rtol=1e-3)
    np.testing.assert_allclose(found.unknowns, expected.unknowns, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("quality", [50.0, 2000.0])
def test_a_drive_that_reaches_the_sensor_past_the_stage_leaves_one_answer_at_an_antiresonance(quality: float) -> None:
    """Without the share, a reading beyond its least would be answered by two forces, and one below it by none. The
    stage may move many times as far as is read there."""
    device, leak, frequency = Oscillator(), 9e-3, np.linspace(41.5, 44.5, 61)
    model = Model(device) + built_in()["sensor-crosstalk"](device)
    omega, own = 2 * np.pi * frequency, 2 * np.pi * FREQUENCY
    exact = GAIN / (own**2 - omega**2 + 1j * own * omega / quality) + leak
    assert np.min(np.abs(exact)) < (0.2 if quality < 100 else 0.02) * leak
    there = Periodic(Equation(model), np.array([FREQUENCY, quality, GAIN, leak, 0.0]), STEPS)
    found = at_amplitude(there, points(frequency, np.abs(exact)))
    assert found.converged.all()
    np.testing.assert_allclose(found.share, 1.0, rtol=2e-3)
    np.testing.assert_allclose(found.tone, exact, rtol=2e-3)
    weaker = Periodic(Equation(model), np.array([FREQUENCY, quality, GAIN, 0.7 * leak, 0.0]), STEPS)
    far = at_amplitude(weaker, points(frequency, np.abs(exact)))
    assert far.converged.all() and np.all(far.share > 0)


def test_a_motion_whose_mean_moves_far_is_found_from_the_next_point() -> None:
    """Of an even spring the balance of the fundamental knows nothing, and begins with a phase that is far off."""
    device, frequency = Oscillator(), np.linspace(38.0, 41.0, 25)
    model = Model(device) + built_in()["quadratic-stiffness"](device)
    cubic = -1e7  # as soft by a quadratic one: Nayfeh & Mook, Nonlinear Oscillations, 1979, §2.3.1
    values = np.array([FREQUENCY, QUALITY, GAIN, np.sqrt(-0.9 * cubic) * 2 * np.pi * FREQUENCY, 0.0])
    amplitude = np.abs(closed_form(0.5, frequency, False, cubic))
    found = at_amplitude(Periodic(Equation(model), values, STEPS), points(frequency, amplitude))
    assert found.converged.all()
    assert np.all((found.share > 0.4) & (found.share < 0.7))  # of one volt: first-order theory is not far off


def test_a_long_transient_of_an_independent_solver_ends_where_the_curve_is() -> None:
    level, frequency = 1.0, 42.0
    omega, own = 2 * np.pi * frequency, 2 * np.pi * FREQUENCY

    def motion(t: float, y: np.ndarray) -> list[float]:
        push = GAIN * level * np.cos(omega * t) - own / QUALITY * y[1] - own**2 * y[0] - CUBIC * y[0] ** 3
        return [y[1], push]

    branch = follow(duffing(), np.array([level]), np.zeros(1), np.array([[37.0, 45.0]]), np.array([0.08]))[0]
    upper = run_along(duffing(), branch, np.linspace(38, frequency, 9), 0.0, False, np.array([0.08, 20.0, 1.0, 40.0]))
    period = 1 / frequency
    found = solve_ivp(motion, (0, 60 * period), upper.unknowns[-1, :2], method="DOP853", rtol=1e-10, atol=1e-13,
                      t_eval=59 * period + period / 64 * np.arange(64))  # fmt: skip
    turns = np.exp(-2j * np.pi * np.arange(64) / 64)
    assert abs(2 * np.mean(found.y[0] * turns)) == pytest.approx(upper.reading[-1], rel=1e-5)


@pytest.fixture(scope="module")
def curves() -> list:
    levels = np.array([0.3, 0.6, 1.0])
    return follow(duffing(), levels, np.zeros(3), np.array([37.0, 45.0]), np.array([0.024, 0.046, 0.073]))


def test_folds_of_a_duffing_oscillator_lie_where_first_order_theory_has_them(curves: list) -> None:
    """A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, §4.1.1: the frequency response has vertical tangents
    where (ω0² + ¾ k A² − ω²)(ω0² + 9/4 k A² − ω²) + (ω ω0/Q)² = 0, for small amplitudes."""
    assert not curves[0].folds
    assert curves[0].stable.all()
    for branch in curves[1:]:
        assert len(branch.folds) == 2
        for fold in branch.folds:
            omega, own, bent = 2 * np.pi * fold.frequency, 2 * np.pi * FREQUENCY, 0.75 * CUBIC * fold.amplitude**2
            shift = own**2 - omega**2
            root = np.roots([3.0, 4 * shift, shift**2 + (omega * own / QUALITY) ** 2])
            nearest = root[np.argmin(np.abs(root - bent))].real
            assert nearest == pytest.approx(bent, rel=0.03)
        low, high = (fold.index for fold in branch.folds)
        assert not branch.stable[low + 2 : high - 1].any()
        assert branch.stable[: low - 1].all() and branch.stable[high + 3 :].all()


def test_the_peaks_lie_on_the_backbone(curves: list) -> None:
    """First order in the nonlinearity, Nayfeh & Mook §4.1.1: ω² = ω0² + ¾ k A² at the peak."""
    for branch in curves[1:]:
        top = int(np.argmax(np.abs(branch.tone)))
        amplitude = abs(branch.tone[top])
        backbone = np.sqrt((2 * np.pi * FREQUENCY) ** 2 + 0.75 * CUBIC * amplitude**2) / (2 * np.pi)
        assert branch.frequency[top] == pytest.approx(backbone, rel=2e-3)


def test_up_and_down_jump_at_different_folds(curves: list) -> None:
    branch, scale, frequency = curves[2], np.array([0.08, 20.0, 1.0, 40.0]), np.linspace(38, 44.5, 66)
    up = run_along(duffing(), branch, frequency, 0.0, False, scale)
    down = run_along(duffing(), branch, frequency[::-1], 0.0, False, scale)
    assert up.fold is not None and down.fold is not None
    assert up.fold.frequency > down.fold.frequency + 1
    assert frequency[up.after - 1] <= up.fold.frequency <= frequency[up.after]
    seen = find_jump(frequency, up.reading)
    assert seen is not None and seen.after == up.after


def test_every_effect_of_the_library_has_steady_responses() -> None:
    device = Oscillator()
    for name, effect in built_in().items():
        if effect.platform_only or effect.needs:
            continue
        one = effect(device)
        size = {"displacement": 0.02, "velocity": 5.0, "voltage": 1.0, "period": 1 / FREQUENCY, "duration": 1.0,
                "induction": 0.2, "nearness": 2e5}  # fmt: skip
        small = {p.name: p.default * size.get(p.scale, 1.0) for p in one.declared()}
        model = Model(device) + effect(device, None, **small)
        values = np.array([FREQUENCY, QUALITY, GAIN, *(small[p.name] for p in one.parameters)])
        found = at_amplitude(
            Periodic(Equation(model), values, 64), points(np.array([38.0, 40.0]), np.array([0.01, 0.02]))
        )
        assert found.converged.all(), name


def with_memory(name: str, **values: float) -> Periodic:
    """A linear oscillator whose drive has an effect with a memory."""
    device = Oscillator()
    model = Model(device) + built_in()[name](device)
    known = {f"{name}.{key}": value for key, value in values.items()}
    own = [FREQUENCY, QUALITY, GAIN]
    return Periodic(Equation(model), np.array([*own, *(known.get(p.name, 0.0) for p in model.parameters[3:])]), STEPS)


def needed_force(at: Points) -> np.ndarray:
    omega, own = 2 * np.pi * at.frequency, 2 * np.pi * FREQUENCY
    return (own**2 - omega**2 + 1j * own * omega / QUALITY) * at.amplitude / GAIN


def test_plays_in_the_drive_are_no_unknowns_and_act_as_exact_ones() -> None:
    weight, reach = 0.3, 0.5
    model = with_memory("prandtl-ishlinskii", weight=weight, reach=reach)
    at = points(np.linspace(38, 42, 9), np.linspace(0.004, 0.012, 9))
    found = at_amplitude(model, at)
    assert model.size == 2
    assert found.converged.all()
    angle = np.linspace(0, 6 * np.pi, 30001)
    for needed, force, level in zip(found.needed, needed_force(at), at.level, strict=True):
        volts, left = level * np.cos(angle), np.zeros(10001, complex)
        for j in range(6):
            play, half = np.zeros(len(angle)), reach * (j + 0.5) / 6
            for k in range(1, len(angle)):
                play[k] = min(max(play[k - 1], volts[k] - half), volts[k] + half)
            left += weight / 6 * (volts - play)[-10001:]
        own = 2 * np.mean((volts[-10001:] - left)[:-1] * np.exp(-1j * angle[-10001:-1]))
        assert needed / level * own == pytest.approx(force, rel=0.01)  # edges are rounded


def test_an_actuator_that_saturates_is_asked_for_a_share_where_no_level_reaches_as_far() -> None:
    """E − η E³ gives at most 2/3 of √(4/9η) of a linear one: at every level less than is needed here."""
    eta = 0.3
    model = with_memory("pzt-hysteresis", eta=eta * GAIN)
    at = points(np.linspace(38, 42, 9), np.full(9, 0.02))
    assert np.all(np.abs(needed_force(at))[[0, -1]] > 2 / 3 * np.sqrt(4 / 9 / eta))
    found = at_amplitude(model, at)
    assert found.converged.all()
    np.testing.assert_allclose(found.needed * (1 - 0.75 * eta), needed_force(at), rtol=1e-4)


def test_levels_that_plays_need_have_the_slopes_of_differences() -> None:
    model = with_memory("prandtl-ishlinskii", weight=0.3, reach=0.5)
    at = points(np.linspace(38, 42, 9), np.linspace(0.004, 0.012, 9))
    slopes = at_amplitude(model, at).slopes(np.diag(np.where(model.values == 0, 1.0, model.values)))
    for i, value in enumerate(model.values):
        sides = []
        for side in (1e-4, -1e-4):
            values = model.values.copy()
            values[i] += side * (value or 1.0)
            sides.append(at_amplitude(Periodic(model.equation, values, STEPS), at).needed)
        # A play has edges, of which the sum along the motion is not as exact as the solver.
        np.testing.assert_allclose(slopes[i], (sides[0] - sides[1]) / 2e-4, rtol=5e-4, atol=1e-6)


@pytest.mark.parametrize("name", ["prandtl-ishlinskii", "creep", "drive-lag"])
def test_closed_forms_of_settled_memories_are_where_their_rates_lead(name: str) -> None:
    at = {p.name: 0.02 if p.unit == "s" else 3.0 for p in built_in()[name].parameters}
    effect = built_in()[name](Oscillator()).with_values(**at)
    level, frequency, steps = 7.0, 20.0, 2000
    angle = np.pi / steps * np.arange(2 * steps + 1)
    volts, rate = level * np.cos(angle), -2 * np.pi * frequency * level * np.sin(angle)
    still, time = np.zeros(len(angle)), angle / (2 * np.pi * frequency)
    seen = Seen(still, still, volts, rate, still, 2 * time[1], 2 * np.pi * frequency, 1.0, 0.0)
    hidden = tuple(map(np.asarray, effect.begun(seen.first)))
    for _ in range(12):
        hidden, path = memory_along(effect, hidden, seen)
    closed = [effect.settled(level, seen.drive(v, r)) for v, r in zip(volts[::100], rate[::100], strict=True)]
    scale = np.max(np.abs(np.array(path)))
    np.testing.assert_allclose(np.array(path)[:, ::100].T, np.array(closed, float), rtol=0, atol=0.01 * scale)


def test_a_slow_memory_of_the_drive_has_settled_at_once() -> None:
    late, time, spread = 0.2, 3.0, 4.0  # s: hundreds of periods
    model = with_memory("creep", late=late, time=time, spread=spread)
    at = points(np.linspace(38, 42, 5), np.full(5, 0.01))
    found = at_amplitude(model, at)
    omega = 2 * np.pi * at.frequency
    lagging = sum(1 / (1 + 1j * omega * time * spread**j) for j in (-1, 0, 1)) / 3
    np.testing.assert_allclose(found.needed * (1 + late * lagging), needed_force(at), rtol=1e-4)
    slopes = found.slopes(np.diag(model.values))
    for i in (3, 5):  # late, time
        sides = []
        for side in (1e-4, -1e-4):
            values = model.values.copy()
            values[i] *= 1 + side
            sides.append(at_amplitude(Periodic(model.equation, values, STEPS), at).needed)
        np.testing.assert_allclose(slopes[i], (sides[0] - sides[1]) / 2e-4, rtol=1e-3, atol=1e-9)


def test_a_response_that_leaves_the_band_upwards_is_also_followed_from_above() -> None:
    """The upper fold lies far beyond the band: a sweep down must still find the low response, and jump where
    first-order theory has the lower fold: ω² − ω0² = 3 (¾ k)^⅓ (F/2)^⅔ without damping."""
    model, frequency = duffing(), np.linspace(39.2, 44.0, 25)
    branch = follow(model, np.array([3.0]), np.zeros(1), np.array([[38.0, 44.0]]), np.array([0.2]))[0]
    assert branch.gap is not None and len(branch.stretches) == 2
    scale = np.array([0.2, 60.0, 3.0, 40.0])
    up = run_along(model, branch, frequency, 0.0, False, scale)
    assert up.fold is None and np.all(np.diff(up.reading) > 0)
    down = run_along(model, branch, frequency[::-1], 0.0, False, scale)
    assert down.fold is not None and down.reading[0] < 0.05 < down.reading[down.after]
    squared = (2 * np.pi * FREQUENCY) ** 2 + 3 * (0.75 * CUBIC) ** (1 / 3) * (GAIN * 3 / 2) ** (2 / 3)
    assert down.fold.frequency == pytest.approx(np.sqrt(squared) / (2 * np.pi), rel=0.01)


def test_a_motion_too_far_from_its_neighbour_is_reached_by_points_between() -> None:
    """Beside a second well the mean of a motion moves far with its amplitude: from 164 to 160 Hz one search is lost."""
    device, squared = Oscillator(), (2 * np.pi * 211.0) ** 2
    model = Model(device) + built_in()["quadratic-stiffness"](device) + built_in()["cubic-stiffness"](device)
    values = np.array([211.0, 36.0, 0.028e-6 * squared, -0.116883e6 * squared, 0.0, 0.003247e12 * squared, 0.0])
    frequency = np.array(
        [206.0, 204, 202, 200, 198, 196, 194, 192, 190, 188, 186, 184, 181, 178, 175, 172, 168, 164, 160]
    )
    um = [3.169, 3.4065, 3.6778, 3.8592, 4.0536, 4.2904, 4.4408, 4.6519, 4.8038, 4.9851, 5.0688, 5.2689, 5.4745, 5.6851,
          5.8681, 6.0858, 6.3007, 6.5222, 6.6801]  # fmt: skip
    n = len(frequency)
    at = Points(frequency, np.full(n, 6.0), 1e-6 * np.array(um), np.zeros(n), np.zeros(n, bool))
    found = at_amplitude(Periodic(Equation(model), values, STEPS), at)
    assert found.converged.all()
    np.testing.assert_allclose(found.share, 1.0, atol=0.15)  # of the level that was set
