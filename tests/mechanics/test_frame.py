"""The "frame" closure against finite elements, and its symmetries and derivatives."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from ident.mechanics import frame_law, in_plane_flexibility, initial_shape, residual_moment, restoring, restoring_force
from ident.mechanics.frame import end_stiffness

HELD = {
    "clamped": {"in_plane": "clamped"},
    "rotz_end": {"in_plane": "yaw", "beam_end": (0.0, 0.0)},
    "rotz_c": {"in_plane": "yaw", "beam_end": (0.0, -1.5e-3)},
    "rotz_pin": {"in_plane": "yaw", "beam_end": (1.4e-3, -1.5e-3)},
    "trans": {"in_plane": "translation"},
    "free": {"in_plane": "free"},
}


def _curve(finite_elements, multiple, held):
    rows = finite_elements.query("kappa_multiple == @multiple and stage_constraint == @held")
    assert len(rows) == 25
    return rows.z_m.to_numpy(), rows.F_N_per_beam.to_numpy()


def _error(force, reference):
    """Largest deviation over ±60 µm relative to the largest force."""
    return float(np.max(np.abs(np.asarray(force) - reference)) / np.max(np.abs(reference)))


def _law(device, multiple, **how):
    moment = residual_moment(device.section, *(multiple * s for s in device.stresses))
    shape = initial_shape(device.section, device.length_1, device.length_2, moment)
    # The finite elements carry no mean force and are rigid in in-plane shear.
    return frame_law(device.section, device.length_1, device.length_2, shape, **{"shear": False, **how})


def _force(law, z):
    return law.k1 * z + law.k2 * z**2 + law.k3 * z**3


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("multiple, bound", [(0, 0.010), (0.5, 0.013), (1, 0.018), (2, 0.033), (4, 0.074)])
def test_frame_within_its_error_of_finite_elements(device, finite_elements, held, multiple, bound):
    z, reference = _curve(finite_elements, multiple, held)
    assert _error(_force(_law(device, multiple, **HELD[held]), z), reference) < bound


@pytest.mark.parametrize(
    "held, error",
    [
        ("clamped", 0.1565),
        ("rotz_end", 0.1362),
        ("rotz_c", 0.1082),
        ("rotz_pin", 0.1080),
        ("trans", 0.1398),
        ("free", 0.1444),
    ],
)
def test_axial_force_closure_is_off_by_a_tenth_or_more(device, finite_elements, held, error):
    z, reference = _curve(finite_elements, 1, held)
    sigma12, sigma23, sigma2 = device.stresses
    law = restoring(device.section, device.length_1, device.length_2, sigma12=sigma12, sigma23=sigma23, sigma2=sigma2)
    assert _error(restoring_force(law, z) / 4, reference) == pytest.approx(error, abs=2e-4)


@pytest.mark.parametrize("multiple, rise", [(0.5, 1.37e-6), (1, 2.62e-6), (2, 4.50e-6)])
def test_equilibrium_height_of_the_clamped_stage(device, multiple, rise):
    assert float(_law(device, multiple, in_plane="clamped").rise) == pytest.approx(rise, rel=0.05)


def test_where_the_stage_may_turn_the_axial_force_closure_has_the_asymmetry_the_wrong_way(device, finite_elements):
    z, reference = _curve(finite_elements, 1, "rotz_c")
    sigma12, sigma23, sigma2 = device.stresses
    axial = restoring(device.section, device.length_1, device.length_2, sigma12=sigma12, sigma23=sigma23, sigma2=sigma2)

    def asymmetry(force):
        return float(np.sum(force * z**2))

    assert asymmetry(reference) < 0
    assert asymmetry(np.asarray(_force(_law(device, 1, **HELD["rotz_c"]), z))) < 0
    assert asymmetry(np.asarray(restoring_force(axial, z))) > 0


@pytest.mark.parametrize("how", HELD.values(), ids=HELD.keys())
def test_opposite_stress_mirrors_the_curve(device, how):
    up, down = _law(device, 1.0, **how, shear=True), _law(device, -1.0, **how, shear=True)
    assert float(up.k1) == pytest.approx(float(down.k1), rel=1e-12)
    assert float(up.k2) == pytest.approx(-float(down.k2), rel=1e-10, abs=1e-9)
    assert float(up.k3) == pytest.approx(float(down.k3), rel=1e-12, abs=1e-9)
    assert float(up.rise) == pytest.approx(-float(down.rise), rel=1e-12)


def test_free_stage_keeps_the_linear_stiffness(device):
    law = _law(device, 1.0, in_plane="free")
    assert float(law.k1) == pytest.approx(605.146382124 / 4, rel=1e-11)
    assert float(law.k2) == float(law.k3) == 0.0


def test_free_directions_meet_no_resistance(device):
    flexibility = in_plane_flexibility(device.section, device.length_1, device.length_2)
    np.testing.assert_allclose(flexibility, flexibility.T, rtol=1e-14)
    scale = float(jnp.abs(end_stiffness(flexibility, "clamped")).max())
    turned = end_stiffness(flexibility, "yaw", (0.3e-3, -1.5e-3)) @ jnp.array([1.5e-3, 0.3e-3, 1.0])
    np.testing.assert_allclose(turned, 0.0, atol=1e-9 * scale * 1e-3)
    np.testing.assert_allclose(end_stiffness(flexibility, "translation")[:, :2], 0.0, atol=1e-9 * scale)


def test_tension_raises_the_stiffness(device):
    slack, taut = (
        frame_law(device.section, device.length_1, device.length_2, device.shape, force) for force in (0.0, 0.1)
    )
    assert float(taut.k1) > float(slack.k1)


@pytest.mark.parametrize("multiple", (1.0, 20.0, 1e3))
@pytest.mark.parametrize("in_plane", ("yaw", "clamped", "translation"))
def test_newton_ends_in_the_equilibrium(device, multiple, in_plane):
    law = _law(device, multiple, in_plane=in_plane)
    assert all(np.isfinite(float(part)) for part in law)
    if multiple <= 20:  # finite elements too show no buckling up to twenty times the stress
        assert float(law.k1) > 0


def test_derivatives_through_the_equilibrium(device):
    stress = jnp.array(device.stresses)

    def parts(multiple):
        moment = residual_moment(device.section, *(multiple * stress))
        shape = initial_shape(device.section, device.length_1, device.length_2, moment)
        law = frame_law(device.section, device.length_1, device.length_2, shape, 0.05 * multiple)
        return jnp.stack(law) * jnp.array([1.0, 1e-5, 1e-9, 1e6])  # all of the size of one

    value, slope, second = jax.jit(parts), jax.jit(jax.jacfwd(parts)), jax.jit(jax.jacfwd(jax.jacrev(parts)))
    for multiple in (0.0, 1.0, 4.0):
        step = 1e-4
        difference = (value(multiple + step) - value(multiple - step)) / (2 * step)
        np.testing.assert_allclose(slope(multiple), difference, rtol=1e-6, atol=1e-6)
        difference = (slope(multiple + step) - slope(multiple - step)) / (2 * step)
        np.testing.assert_allclose(second(multiple), difference, rtol=1e-6, atol=1e-6)
