"""Geometrically exact beam elements of one L beam under residual stress, to see whether it ever buckles.

    E = Σ_e (h/2) [Γᵀ diag(EA, GA, GA) Γ + (κ − κ0)ᵀ diag(GJ, EI_z, EI) (κ − κ0)]
    Γ = R_mᵀ Δx/h − e_t,   κ = log(R_aᵀ R_b)/h,   R_m = R_a exp(log(R_aᵀ R_b)/2)

Segment 2 runs from the clamped root along x to the corner, segment 1 from there along y to the stage. The stage's end
is lifted by z, is kept from turning about x and y, and turns freely about z around the stage's centre. No in-plane
shear (GA is large), as in data/fe_beam, against which `check` holds the curves.

Source: J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58 (1986) 79 (strains); M. A. Crisfield, G. Jelenić,
Proc. R. Soc. A 455 (1999) 1125 (the relative rotation is interpolated).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from experiments.simulator.geometry import Geometry
from ident.runtime import configure

CURVES = Path(__file__).resolve().parents[2] / "data" / "fe_beam" / "force_displacement.csv"
MOMENT = 2.1461529474e-5  # N·m, of the stress 90, 20, −10 MPa
_ELEMENTS = 16  # per segment
_RIGID = 1e2  # GA over EA
_CENTRE = np.array([0.0, 1.5e-3, 0.0])  # of the stage, seen from the beam's end, m
_STILL = 1e-13  # m and rad, largest change of a Newton step
_MOST = 60


class Curve(NamedTuple):
    """Force on one beam, N, at displacements z from the stressed equilibrium, m; least eigenvalue of the Hessian with
    the end held over that without stress; `rise`, height of the equilibrium, m."""

    z: np.ndarray
    force: np.ndarray
    margin: float
    rise: float


def _rotation(v: jax.Array) -> jax.Array:
    """exp of the cross product with v, smooth at zero."""
    angle2 = v @ v + 1e-24
    angle = jnp.sqrt(angle2)
    k = jnp.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return jnp.eye(3) + jnp.sin(angle) / angle * k + 2 * jnp.sin(angle / 2) ** 2 / angle2 * k @ k


def _logarithm(r: jax.Array) -> jax.Array:
    """Rotation vector of a rotation by less than a right angle."""
    axis = jnp.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    sine2 = axis @ axis + 1e-24
    sine = jnp.sqrt(sine2)
    return axis * jnp.arcsin(sine) / sine


def _energy(q: jax.Array, lift: jax.Array, curvature: jax.Array) -> jax.Array:
    """Elastic energy, J; `q`: six unknowns of every inner node and the turn of the stage, scaled by 1 mm."""
    g, n = Geometry(), _ELEMENTS
    lengths = np.repeat([g.length_2 / n, g.length_1 / n], n)
    along = np.repeat([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], n, axis=0)
    reference = np.vstack([np.zeros(3), np.cumsum(along * lengths[:, None], axis=0)])
    # Columns tangent t, normal z, and t × z, about which bending lifts.
    triads = np.stack([along, np.tile([0.0, 0.0, 1.0], (2 * n, 1)), np.cross(along, [0.0, 0.0, 1.0])], axis=-1)
    inner, turn = q[:-1].reshape(-1, 6), q[-1] * jnp.array([0.0, 0.0, 1.0])
    end = _CENTRE - _rotation(turn) @ _CENTRE + lift * jnp.array([0.0, 0.0, 1.0])
    moved = jnp.vstack([jnp.zeros(3), 1e-3 * inner[:, :3], end]) + reference
    turned = jnp.vstack([jnp.zeros(3), inner[:, 3:], turn])

    def element(a: jax.Array, b: jax.Array, va: jax.Array, vb: jax.Array, triad: jax.Array, h: float) -> jax.Array:
        first, last = _rotation(va) @ triad, _rotation(vb) @ triad
        relative = _logarithm(first.T @ last)
        strain = (first @ _rotation(relative / 2)).T @ (b - a) / h - jnp.array([1.0, 0.0, 0.0])
        bend = relative / h - curvature * jnp.array([0.0, 0.0, 1.0])
        stretch = g.axial * jnp.array([1.0, _RIGID, _RIGID])
        return h / 2 * (stretch @ strain**2 + jnp.array([g.twisting, g.axial * g.width**2 / 12, g.bending]) @ bend**2)

    return jnp.sum(jax.vmap(element)(moved[:-1], moved[1:], turned[:-1], turned[1:], triads, lengths))


@cache
def _compiled() -> tuple:
    slope = jax.grad(_energy)
    return jax.jit(slope), jax.jit(jax.jacfwd(slope)), jax.jit(jax.grad(_energy, argnums=1))


def _relax(q: np.ndarray, lift: float, curvature: float) -> np.ndarray:
    """Equilibrium with the end held, by Newton steps."""
    slope, bend, _ = _compiled()
    for _ in range(_MOST):
        step = np.linalg.solve(bend(q, lift, curvature), slope(q, lift, curvature))
        q = q - step * min(1.0, 0.2 / np.max(np.abs(step)))
        if np.max(np.abs(step)) < _STILL * 1e3:
            return q
    raise ArithmeticError(f"no equilibrium at {lift} m with a curvature of {curvature} 1/m")


def curve(multiple: float, z: np.ndarray) -> Curve:
    """Force of one beam at displacements from its equilibrium, under so many times the stress."""
    configure()
    whole = MOMENT / Geometry().bending
    q, lift = np.zeros(6 * (2 * _ELEMENTS - 1) + 1), 0.0
    _, bend, pull = _compiled()
    for part in np.linspace(0, multiple, int(np.ceil(4 * multiple)) + 2)[1:]:
        lift, q = _free(q, lift, part * whole)
    force, least, at = np.empty(len(z)), np.inf, {}
    for side in (np.argsort(z)[z[np.argsort(z)] >= 0], np.argsort(-z)[-z[np.argsort(-z)] > 0]):
        own = q
        for i in side:
            own = _relax(own, lift + z[i], multiple * whole)
            force[i] = pull(own, lift + z[i], multiple * whole)
            at[i] = own
            least = min(least, float(np.linalg.eigvalsh(bend(own, lift + z[i], multiple * whole))[0]))
    flat = float(np.linalg.eigvalsh(bend(np.zeros_like(q), 0.0, 0.0))[0])
    return Curve(z, force, least / flat, lift)


def _free(q: np.ndarray, lift: float, curvature: float) -> tuple[float, np.ndarray]:
    """Height and state at which the end carries no force, by the secant rule."""
    _, _, pull = _compiled()
    force = lambda at, state: float(pull(state, at, curvature))
    q = _relax(q, lift, curvature)
    here, step = force(lift, q), 1e-7
    for _ in range(_MOST):
        q = _relax(q, lift + step, curvature)
        there = force(lift + step, q)
        lift, here, step = lift + step, there, -there * step / (there - here)
        if abs(step) < 1e-12:
            return lift, q
    raise ArithmeticError(f"no height without force at a curvature of {curvature} 1/m")


def check(multiple: float) -> tuple[float, Curve]:
    """Largest deviation from the curve of data/fe_beam over its largest force, and the curve."""
    table = np.genfromtxt(CURVES, delimiter=",", names=True, dtype=None, encoding="utf-8")
    rows = table[(table["kappa_multiple"] == multiple) & (table["stage_constraint"] == "rotz_c")]
    found = curve(multiple, np.asarray(rows["z_m"]))
    return float(np.max(np.abs(found.force - rows["F_N_per_beam"])) / np.max(np.abs(rows["F_N_per_beam"]))), found
