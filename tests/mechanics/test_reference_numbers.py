"""Every reference number of the nominal device, to the digits that it is given with."""

from __future__ import annotations

import numpy as np
import pytest

from ident import mechanics
from ident.mechanics import residual_moment, segment_stiffness
from tests.mechanics.buckling import critical_force, critical_reduced_force


def test_section(device):
    s = device.section
    assert float(s.neutral_axis) == pytest.approx(19.0984367367e-6, rel=1e-11)
    assert float(s.bending) == pytest.approx(8.94351494993e-7, rel=1e-11)
    assert float(s.axial) == pytest.approx(6141.0, rel=1e-14)
    assert float(s.in_plane_bending) == pytest.approx(5.1175e-4, rel=1e-12)
    assert float(s.torsion) == pytest.approx(1.77901083585e-6, rel=1e-11)
    assert float(s.pzt_arm) == pytest.approx(38.5e-6 - 19.0984367367e-6, rel=1e-10)


def test_in_plane_shear_is_five_sixths_of_the_layers(device):
    layers = 169e9 / (2 * 1.22) * 30e-6 + 63e9 / (2 * 1.30) * 17e-6
    assert float(device.section.in_plane_shear) == pytest.approx(5 / 6 * layers * 1e-3, rel=1e-14)


@pytest.mark.parametrize("ratio, factor", [(1.0, 0.140577), (2.0, 0.228682), (10.0, 0.312325)])
def test_torsion_constant_of_a_rectangle(ratio, factor):
    # Timoshenko & Goodier, table in §109: J = factor b h³
    assert float(mechanics.torsion_constant(ratio, 1.0)) == pytest.approx(factor * ratio, rel=4e-5)


def test_torsion_constant_equals_its_series():
    h, b = 1.0, 1.7
    n = np.arange(1, 4001, 2)
    series = 1 - 192 / np.pi**5 * h / b * np.sum(np.tanh(n * np.pi * b / (2 * h)) / n**5)
    assert float(mechanics.torsion_constant(b, h)) == pytest.approx(b * h**3 / 3 * series, rel=1e-13)


def test_corner_springs(device):
    s, beam = device.section, device.beam
    for spring, r, length in (
        (6.35361012804e-4, beam.spring_1, device.length_1),
        (7.41254514938e-4, beam.spring_2, device.length_2),
    ):
        assert float(s.bending / (r * length)) == pytest.approx(spring, rel=1e-11)


@pytest.mark.parametrize(
    "force, k1, k2",
    [
        (0.0, 368.10109396, 256.849803495),
        (-0.4, 177.582654758, 94.4107754834),
        (-0.1, 320.661816037, 216.4258774),
        (0.4, 556.768130293, 417.510362755),
        (2.0, 1298.72606573, 1048.56824219),
    ],
)
def test_segment_stiffness(device, force, k1, k2):
    beam = device.beam
    first = beam.scale_1 * segment_stiffness(force * beam.per_force_1, beam.spring_1)
    second = beam.scale_2 * segment_stiffness(force * beam.per_force_2, beam.spring_2)
    assert float(first) == pytest.approx(k1, rel=1e-11)
    assert float(second) == pytest.approx(k2, rel=1e-11)


def test_critical_forces(device):
    s, beam = device.section, device.beam
    assert float(critical_force(beam.spring_1, s.bending, device.length_1)) == pytest.approx(-0.768477242563, rel=1e-11)
    assert float(critical_force(beam.spring_2, s.bending, device.length_2)) == pytest.approx(-0.629945966241, rel=1e-11)
    assert float(critical_reduced_force(beam.spring_1)) == pytest.approx(-4.949316842, rel=1e-9)
    assert float(critical_reduced_force(beam.spring_2)) == pytest.approx(-5.522187197, rel=1e-9)


def test_stage(device):
    stiffness = float(mechanics.stage_stiffness(device.beam, 0.0, 0.0))
    assert stiffness == pytest.approx(605.146382124, rel=1e-11)
    assert np.sqrt(stiffness / 60e-6) / (2 * np.pi) == pytest.approx(505.445957, rel=1e-9)


def test_shortening_stiffness(device):
    a = mechanics.shortening_stiffness(device.section, device.length_1, device.length_2)
    expected = [[164536.448, 110040.995], [110040.995, 231237.8845]]
    np.testing.assert_allclose(a, expected, rtol=5e-9)


@pytest.mark.parametrize(
    "moment, expected",
    [
        ("neutral-axis", 2.1461529474e-5),
        ("paper-printed", 5.28021568627e-5),
        ("paper-integral", 1.57433333333e-5),
    ],
)
def test_residual_moment(device, moment, expected):
    value = float(residual_moment(device.section, *device.stresses, moment=moment))
    assert value == pytest.approx(expected, rel=3e-11)


def test_residual_moment_and_force_equal_their_integrals(device):
    s = device.section
    ts, tp = 30e-6, 17e-6
    nodes, weights = np.polynomial.legendre.leggauss(4)
    moment = force = 0.0
    for low, high, bottom, top in ((0.0, ts, -10e6, 20e6), (ts, ts + tp, 20e6, 90e6)):
        z = (low + high) / 2 + (high - low) / 2 * nodes
        stress = bottom + (top - bottom) * (z - low) / (high - low)
        force += 1e-3 * (high - low) / 2 * np.sum(weights * stress)
        moment += 1e-3 * (high - low) / 2 * np.sum(weights * stress * (z - float(s.neutral_axis)))
    assert float(residual_moment(s, *device.stresses)) == pytest.approx(moment, rel=1e-13)
    assert float(mechanics.mean_force(s, *device.stresses)) == pytest.approx(force, rel=1e-13)


def test_the_two_readings_of_the_moment_differ_as_stated(device):
    s = device.section
    printed = residual_moment(s, *device.stresses, moment="paper-printed")
    integral = residual_moment(s, *device.stresses, moment="paper-integral")
    assert float(printed - integral) == pytest.approx(1e-3 * 70e6 * 30e-6**3 / (3 * 17e-6), rel=1e-12)


def test_initial_deflections(device):
    assert float(device.shape.rise_1) == pytest.approx(-25.5492505359e-6, rel=2e-11)
    assert float(device.shape.rise_2) == pytest.approx(28.3276243163e-6, rel=2e-11)


@pytest.mark.parametrize(
    "in_plane, beam_end, k1, k2, k3, rise",
    [
        ("clamped", (0.0, 0.0), 158.187, 1.614e5, 1.142e10, 2.649e-6),
        ("yaw", (0.0, -1.5e-3), 153.759, -1.856e5, 4.318e9, 2.715e-6),
    ],
)
def test_frame_closure_with_rigid_in_plane_shear(device, in_plane, beam_end, k1, k2, k3, rise):
    law = mechanics.frame_law(
        device.section,
        device.length_1,
        device.length_2,
        device.shape,
        in_plane=in_plane,
        beam_end=beam_end,
        shear=False,
    )
    assert float(law.k1) == pytest.approx(k1, abs=6e-4)
    assert float(law.k2) == pytest.approx(k2, rel=4e-4)
    assert float(law.k3) == pytest.approx(k3, rel=4e-4)
    assert float(law.rise) == pytest.approx(rise, abs=6e-10)


@pytest.mark.parametrize("in_plane, loss", [("clamped", 0.27), ("yaw", 0.14)])
def test_in_plane_shear_lowers_the_hardening(device, in_plane, loss):
    rigid, soft = (
        mechanics.frame_law(
            device.section, device.length_1, device.length_2, device.shape, in_plane=in_plane, shear=shear
        )
        for shear in (False, True)
    )
    assert float(1 - soft.k3 / rigid.k3) == pytest.approx(loss, abs=0.005)
