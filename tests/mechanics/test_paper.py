"""The slips of the source, one test each: the printed form fails where the corrected one holds."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.paper import printed as paper
from ident.mechanics import InitialShape, initial_shape, residual_moment, segment_stiffness

EI = 8.94351494993e-7
SEGMENTS = {1: (2.4e-3, 6.35361012804e-4), 2: (2.8e-3, 7.41254514938e-4)}
FORCES = (-0.4, -0.1, 0.4, 2.0)


def _solved(segment: int, force: float) -> paper.Coefficients:
    """Table 1 from the boundary conditions alone: a linear system for C1 and C2, then C3 from z(0) = 0."""
    length, torsion = SEGMENTS[segment]
    alpha, spring = force / EI, EI / torsion
    u = np.sqrt(abs(alpha))

    def shapes(y: float, order: int) -> np.ndarray:
        if alpha < 0:
            turn = order * np.pi / 2
            return u**order * np.array([np.cos(u * y + turn), np.sin(u * y + turn)])
        return u**order * np.array([np.exp(u * y), (-1) ** order * np.exp(-u * y)])

    root_slope, tip_slope = shapes(0, 1), shapes(length, 1)
    if segment == 1:  # root on a spring, guided tip
        first, second = root_slope - spring * shapes(0, 2), tip_slope
    else:  # clamped root, tip on a spring
        first, second = root_slope, tip_slope + spring * shapes(length, 2)
    c1, c2 = np.linalg.solve(np.array([first, second]), [-1 / alpha, -1 / alpha])
    # C3 = α f (C1 or C1 + C2) − f l + α z(l)
    return paper.Coefficients(c1, c2, alpha * (shapes(0, 0) @ [c1, c2]) - length, alpha)


def _tables(segment, force):
    length, torsion = SEGMENTS[segment]
    alpha, spring = force / EI, EI / torsion
    printed = paper.table_1(segment, alpha, length, spring, printed=True)
    corrected = paper.table_1(segment, alpha, length, spring, printed=False)
    return printed, corrected, _solved(segment, force)


@pytest.mark.parametrize("segment", (1, 2))
@pytest.mark.parametrize("force", FORCES)
def test_corrected_table_meets_the_boundary_conditions(segment, force):
    _, corrected, solved = _tables(segment, force)
    assert corrected == pytest.approx(solved, rel=1e-9)


@pytest.mark.parametrize("segment", (1, 2))
@pytest.mark.parametrize("force", FORCES)
def test_corrected_table_is_the_one_rational_function(segment, force):
    length, torsion = SEGMENTS[segment]
    stiffness = paper.stiffness(segment, force, EI, length, torsion, printed=False)
    x, r = force * length**2 / EI, EI / (torsion * length)
    assert stiffness == pytest.approx(float(segment_stiffness(x, r)) * EI / length**3, rel=1e-11)
    printed = paper.stiffness(segment, force, EI, length, torsion, printed=True)
    assert abs(printed / stiffness - 1) > 0.05


def test_eq_1_jumps_at_the_interface():
    ts, tp, stresses = 30e-6, 17e-6, (90e6, 20e6, -10e6)
    sides = np.array([ts * (1 - 1e-12), ts])
    below, above = paper.stress_profile(sides, stresses, ts, tp, printed=True)
    assert above - below == pytest.approx(-30e6, rel=1e-9)
    below, above = paper.stress_profile(sides, stresses, ts, tp, printed=False)
    assert [below, above] == pytest.approx([20e6, 20e6], rel=1e-9)
    ends = paper.stress_profile(np.array([0.0, ts + tp]), stresses, ts, tp, printed=False)
    assert ends == pytest.approx([-10e6, 90e6])


def test_eq_2_third_line_is_not_its_second(device):
    printed = float(residual_moment(device.section, 70e6, 30e6, moment="paper-printed"))
    integral = float(residual_moment(device.section, 70e6, 30e6, moment="paper-integral"))
    y = np.linspace(0, 17e-6, 100001)
    quadrature = 1e-3 * (70e6 * np.trapezoid(y**2, y) / 17e-6 + 30e6 * 30e-6**2 / 3)
    assert integral == pytest.approx(quadrature, rel=1e-9)
    assert printed / integral == pytest.approx(3.35394, rel=1e-5)


def test_eqs_4_and_5_lack_the_half(device):
    # A free segment (no torsion at the corner) of curvature κ rises by κ l²/2; with σ23 = 0 only the half differs.
    arguments = (2.8e-3, 70e6, 0.0, 30e-6, 17e-6, 1e-3, EI)
    printed, corrected = (paper.free_deflection(*arguments, printed=p) for p in (True, False))
    moment = residual_moment(device.section, 70e6, 0.0, moment="paper-printed")
    free: InitialShape = initial_shape(device.section._replace(torsion=0.0), 2.4e-3, 2.8e-3, moment)
    assert corrected == pytest.approx(float(free.rise_2), rel=1e-9)
    assert printed == pytest.approx(2 * corrected, rel=1e-14)


def test_eq_5_divides_the_silicon_term_by_the_wrong_thickness(device):
    arguments = (2.8e-3, 0.0, 30e6, 30e-6, 17e-6, 1e-3, EI)
    printed, corrected = (paper.free_deflection(*arguments, printed=p) for p in (True, False))
    moment = residual_moment(device.section, 0.0, 30e6, moment="paper-printed")
    assert corrected == pytest.approx(float(moment) / EI * 2.8e-3**2 / 2, rel=1e-9)
    assert printed / corrected == pytest.approx(2 * 30 / 17, rel=1e-12)


def test_eq_9_particular_solution_does_not_solve_the_equation():
    # z'' − α z = f (l − y) − α z(l) + C3; the particular solutions are linear in y, so z'' = 0
    alpha, f, c3, tip, length = -4.5e5, 3.0, 0.7, 2e-5, 2.4e-3
    for y in (0.0, 1e-3, 2.4e-3):
        right = f * (length - y) - alpha * tip + c3
        corrected = paper.particular_solution(y, alpha, f, c3, tip, length, printed=False)
        printed = paper.particular_solution(y, alpha, f, c3, tip, length, printed=True)
        assert -alpha * corrected == pytest.approx(right, rel=1e-12)
        assert -alpha * printed != pytest.approx(right, rel=0.01)
    tension = [paper.particular_solution(1e-3, 4.5e5, f, c3, tip, length, printed=p) for p in (True, False)]
    assert tension[0] == tension[1]


@pytest.mark.parametrize("force", (0.4, 2.0))
def test_c13_in_tension(force):
    printed, corrected, solved = _tables(1, force)
    assert corrected.b3 == pytest.approx(force / EI, rel=1e-12)
    assert printed.b3 / solved.b3 < 0
    assert printed[:3] == pytest.approx(solved[:3], rel=1e-9)


@pytest.mark.parametrize("segment", (1, 2))
@pytest.mark.parametrize("force", (-0.4, -0.1))
def test_c13_and_c23_in_compression(segment, force):
    printed, corrected, solved = _tables(segment, force)
    assert corrected.b3 == pytest.approx(force / EI, rel=1e-12)
    assert abs(printed.b3 / solved.b3 - 1) > 0.05
    assert printed[:3] == pytest.approx(solved[:3], rel=1e-9)


@pytest.mark.parametrize("force", (0.4, 2.0))
def test_c22_in_tension(force):
    printed, corrected, solved = _tables(2, force)
    assert corrected.c2 == pytest.approx(solved.c2, rel=1e-12)
    assert printed.c2 / solved.c2 < 0.6
    assert printed.c1 == pytest.approx(solved.c1, rel=1e-9)


@pytest.mark.parametrize("force", (0.4, 2.0))
def test_c23_in_tension(force):
    printed, corrected, solved = _tables(2, force)
    assert corrected.a3 == pytest.approx(solved.a3, rel=1e-12)
    assert printed.a3 / solved.a3 < 0
    assert printed.b3 == pytest.approx(solved.b3, rel=1e-12)
