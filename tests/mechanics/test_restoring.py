"""The three closures as the simulator sees them: forces, symmetry, finiteness, gradients."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.mechanics import (
    BEAMS,
    arch_force,
    axial_forces,
    restoring,
    restoring_force,
    restoring_stiffness,
    shortening,
    shortening_stiffness,
    stage_stiffness,
)

CLOSURES = ("axial-force", "sign-change", "frame")
# σ12, σ23, σ2 in Pa, ρ, β_V in N/V, w in m
PARAMETERS = np.array([70e6, 30e6, 20e6, 0.8, 2e-3, 3e-6])


def _constants(device, p, closure):
    return restoring(
        device.section,
        device.length_1,
        device.length_2,
        sigma12=p[0],
        sigma23=p[1],
        sigma2=p[2],
        restraint=p[3],
        voltage=p[4],
        width=p[5],
        closure=closure,
    )


def test_axial_forces_are_the_frame_times_the_shortenings(device):
    constants = _constants(device, PARAMETERS, "axial-force")
    a = np.asarray(shortening_stiffness(device.section, device.length_1, device.length_2))
    z, v = 7e-6, 5.0
    own = [
        float(shortening(device.beam.share_1, device.length_1, device.shape.rise_1, z)),
        float(shortening(device.beam.share_2, device.length_2, device.shape.rise_2, z)),
    ]
    z1, z2 = float(device.beam.share_1) * z, float(device.beam.share_2) * z
    assert z1 + z2 == pytest.approx(z, rel=1e-14)
    expected = [
        3 / 5 * z1**2 / 2.4e-3 + float(device.shape.rise_1) * z1 / 2.4e-3,
        3 / 5 * z2**2 / 2.8e-3 + float(device.shape.rise_2) * z2 / 2.8e-3,
    ]
    assert own == pytest.approx(expected, rel=1e-13)
    forces = axial_forces(constants.law, z, v)
    assert np.array(forces) == pytest.approx(0.8 * a @ expected + 2e-3 * v, rel=1e-12)


def test_own_force_is_compressive_just_below_rest_and_tensile_beyond(device):
    share, length, rise = 0.5, 2.8e-3, 28e-6
    for own, sign in ((-1e-6, -1), (-5 / 3 * 28e-6 * 0.99, -1), (-5 / 3 * 28e-6 * 1.01, 1), (1e-6, 1)):
        assert np.sign(shortening(share, length, rise, own / share)) == sign


def test_sign_change_law(device):
    constants = _constants(device, PARAMETERS, "sign-change")
    a = np.asarray(shortening_stiffness(device.section, device.length_1, device.length_2))
    step = 0.8 * a[1, 1] * float(device.shape.rise_2) ** 2 / 2.8e-3
    first, second = axial_forces(constants.law, 3e-6, 1.0)
    assert float(second) == pytest.approx(step * np.tanh(1.0) + 2e-3, rel=1e-12)
    assert float(first) < 0 < float(second)  # the segments bend in opposite senses


@pytest.mark.parametrize("closure", CLOSURES)
def test_opposite_stress_mirrors_the_restoring_force(device, closure):
    p = PARAMETERS * [1, 1, 1, 1, 0, 1]
    q = p * [-1, -1, -1, 1, 1, 1]
    z = np.linspace(-30e-6, 30e-6, 13)
    up, down = _constants(device, p, closure), _constants(device, q, closure)
    if closure == "frame":  # the mean force changes sign with the stress and is no mirror image: take it away
        balance = -p[0] * 17 / 94 + p[1] * 30 / 94
        up, down = (
            _constants(device, np.array([s * p[0], s * p[1], s * balance, 1, 0, 1e-6]), "frame") for s in (1, -1)
        )
    np.testing.assert_allclose(restoring_force(up, z), -restoring_force(down, -z), rtol=1e-9, atol=1e-15)
    assert float(up.rise) == pytest.approx(-float(down.rise), rel=1e-9)


@pytest.mark.parametrize("closure", CLOSURES)
def test_without_stress_the_force_is_odd(device, closure):
    constants = _constants(device, PARAMETERS * [0, 0, 0, 1, 0, 1], closure)
    z = np.linspace(1e-6, 30e-6, 13)
    np.testing.assert_allclose(restoring_stiffness(constants, z), restoring_stiffness(constants, -z), rtol=1e-13)
    assert float(restoring_stiffness(constants, 0.0)) == pytest.approx(605.146382124, rel=1e-11)
    assert float(constants.rise) == 0.0


@pytest.mark.parametrize("moment", ("neutral-axis", "paper-integral", "paper-printed"))
def test_only_one_combination_of_the_stresses_acts(device, moment):
    def stiffness(sigma12, sigma23):
        constants = restoring(
            device.section, device.length_1, device.length_2, sigma12=sigma12, sigma23=sigma23, moment=moment
        )
        return restoring_stiffness(constants, jnp.linspace(-20e-6, 20e-6, 9))

    by_12, by_23 = jax.jit(jax.jacfwd(stiffness, argnums=(0, 1)))(70e6, 30e6)
    singular = np.linalg.svd(np.stack([by_12, by_23]), compute_uv=False)
    assert singular[1] < 1e-12 * singular[0]


@pytest.mark.parametrize("closure", CLOSURES)
def test_gradients_equal_finite_differences(device, closure):
    stiffness = jax.jit(lambda p: restoring_stiffness(_constants(device, p[:6], closure), p[6], p[7]))
    point = np.array([*PARAMETERS, 4e-6, 3.0])
    exact = np.asarray(jax.jit(jax.jacfwd(stiffness))(point))
    np.testing.assert_allclose(exact, jax.jit(jax.grad(stiffness))(point), rtol=1e-11, atol=1e-18)
    for i, size in enumerate(np.abs(point)):
        step = np.zeros(8)
        step[i] = 1e-4 * size
        slope = (float(stiffness(point + step)) - float(stiffness(point - step))) / (2 * step[i])
        assert exact[i] * size == pytest.approx(slope * size, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("closure", ("axial-force", "sign-change"))
def test_finite_for_any_finite_displacement_and_drive(device, closure):
    constants = _constants(device, PARAMETERS, closure)
    both = jax.jit(lambda z, v: jax.value_and_grad(lambda a: restoring_stiffness(constants, a, v))(z))

    @given(st.floats(-1e3, 1e3), st.floats(-1e6, 1e6))
    def check(z, v):
        stiffness, slope = both(z, v)
        assert np.isfinite(float(stiffness))
        assert np.isfinite(float(slope))

    check()


def test_arch_force_is_what_the_secant_stiffness_leaves_out(device):
    # Virtual work N_i dΔ_i/dz: the quadratic part of Δ is the geometric stiffness, the rest the arch term.
    beam, shape, z = device.beam, device.shape, 5e-6
    forces = axial_forces(_constants(device, PARAMETERS, "axial-force").law, z)
    work = 0.0
    for force, share, length, rise in (
        (forces[0], beam.share_1, device.length_1, shape.rise_1),
        (forces[1], beam.share_2, device.length_2, shape.rise_2),
    ):
        slope = jax.grad(shortening, argnums=3)(share, length, rise, z)
        work += BEAMS * float(force * (slope - 1.2 * share**2 * z / length))
    assert float(arch_force(beam, shape, *forces)) == pytest.approx(work, rel=1e-12)


def test_geometric_stiffness_of_small_forces_is_of_the_same_shape(device):
    # dK/dN at N = 0 of a clamped-guided segment is 6/(5 l): the 3/5 z²/l of the shortening, by Castigliano
    stiff_corner = device.beam._replace(spring_1=0.0, spring_2=0.0)
    slope = jax.grad(lambda n: stage_stiffness(stiff_corner, n, 0.0))(0.0)
    k1, k2 = 12 * stiff_corner.scale_1, 12 * stiff_corner.scale_2
    assert float(slope) == pytest.approx(4 * (k2 / (k1 + k2)) ** 2 * 1.2 / 2.4e-3, rel=1e-12)


def test_unknown_choices_are_refused(device):
    with pytest.raises(ValueError, match="axial-force, sign-change or frame"):
        _constants(device, PARAMETERS, "arch")
    with pytest.raises(ValueError, match="yaw, clamped, free or translation"):
        restoring(device.section, 2.4e-3, 2.8e-3, sigma12=1e6, sigma23=0.0, closure="frame", in_plane="loose")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="neutral-axis, paper-integral or paper-printed"):
        restoring(device.section, 2.4e-3, 2.8e-3, sigma12=1e6, sigma23=0.0, moment="both")  # type: ignore[arg-type]
