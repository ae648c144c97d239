"""Motion of the stage on its stressed beams, integrated in fine fixed steps.

    (M + m) z̈ + (M ω0/Q) ż + M ω0² z + k3 z³ + R(z, V) + D(z, ż) = K_f (d31 E − η E³ + (ζ/ω³) Ė³),   E = V/T_PZT

with D = F_c ż/√(ż² + v_c²), dry friction. R = [K(N(z, V)) − K(0)] z for the axial-force and the sign-change closure (K
from the closed form of `stiffness`), and R = 4 F(z) − K(0) z with a finite-element curve F(z) per beam for the closure
"curve".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from scipy.interpolate import CubicSpline

from .geometry import Geometry
from .signals import Drive, reference_rate, sine
from .stiffness import segment_stiffness

Closure = Literal["none", "axial-force", "sign-change", "curve"]
_CODE = {"none": 0, "axial-force": 1, "sign-change": 2, "curve": 3}


@dataclass(frozen=True)
class Stage:
    """The parameters of one device, SI units, named as in `truth.toml`.

    **Arguments:**

    - `frequency` Hz, `quality`, `d31` m/V: the linear platform without axial force.
    - `sigma12`, `sigma23` Pa: stress steps σ1−σ2 (PZT) and σ2−σ3 (silicon); σ2 = 0.
    - `restraint`, `voltage_force` N/V, `width` m: ρ, β_V and the transition width of the closures.
    - `cubic` N/m³: the spring k3 of large deformations.
    - `eta`, `zeta` m³/V³: the hysteresis polynomial.
    - `friction` N, `friction_speed` m/s: dry friction F_c and the speed v_c over which it turns.
    """

    frequency: float
    quality: float
    d31: float
    closure: Closure = "none"
    sigma12: float = 0.0
    sigma23: float = 0.0
    restraint: float = 1.0
    voltage_force: float = 0.0
    width: float = 1e-6
    cubic: float = 0.0
    eta: float = 0.0
    zeta: float = 0.0
    friction: float = 0.0
    friction_speed: float = 1e-3
    geometry: Geometry = Geometry()


class _Constants(NamedTuple):
    code: int
    mass: float
    damping: float
    linear: float
    gain: float
    d31: float
    eta: float
    zeta: float
    layer: float
    length_1: float
    length_2: float
    bending: float
    ratio_1: float
    ratio_2: float
    share_1: float
    share_2: float
    rise_1: float
    rise_2: float
    a11: float
    a12: float
    a22: float
    restraint: float
    voltage_force: float
    width: float
    unstressed: float
    cubic: float
    friction: float
    friction_speed: float
    knot: float
    spacing: float


def _constants(stage: Stage, load: float, reference: float, knot: float, spacing: float) -> _Constants:
    g = stage.geometry
    rise = g.initial_shape(g.residual_moment(stage.sigma12, 0.0, -stage.sigma23))
    frame, w0 = g.frame_stiffness(), 2 * np.pi * stage.frequency
    return _Constants(
        _CODE[stage.closure], g.stage_mass + load, g.stage_mass * w0 / stage.quality, g.stage_mass * w0**2,
        g.drive_gain, stage.d31, stage.eta, stage.zeta / reference**3, g.pzt_thickness, g.length_1, g.length_2,
        g.bending, *g.corner_ratios, *g.shares, *rise, frame[0, 0], frame[0, 1], frame[1, 1], stage.restraint,
        stage.voltage_force, stage.width, g.stage_stiffness, stage.cubic, stage.friction, stage.friction_speed,
        knot, spacing,
    )  # fmt: skip


@njit
def stage_stiffness(n1, n2, c):
    """Stiffness of the stage (N/m) when the segments carry the axial forces n1 and n2 (N)."""
    k1 = c.bending / c.length_1**3 * segment_stiffness(n1 * c.length_1**2 / c.bending, c.ratio_1)
    k2 = c.bending / c.length_2**3 * segment_stiffness(n2 * c.length_2**2 / c.bending, c.ratio_2)
    return 4.0 * k1 * k2 / (k1 + k2)


@njit
def extra_force(z, volt, c, curve):
    """What residual stress adds to the restoring force, N."""
    if c.code == 0:
        return 0.0
    if c.code == 3:
        at = (z - c.knot) / c.spacing
        i = min(max(int(at), 0), curve.shape[1] - 1)
        d = z - c.knot - i * c.spacing
        beam = ((curve[0, i] * d + curve[1, i]) * d + curve[2, i]) * d + curve[3, i]
        return 4.0 * beam - c.unstressed * z
    if c.code == 1:
        z1, z2 = c.share_1 * z, c.share_2 * z
        d1 = (0.6 * z1 + c.rise_1) * z1 / c.length_1
        d2 = (0.6 * z2 + c.rise_2) * z2 / c.length_2
        n1, n2 = c.a11 * d1 + c.a12 * d2, c.a12 * d1 + c.a22 * d2
    else:
        side = np.tanh(z / c.width)
        n1 = c.a11 * c.rise_1 * abs(c.rise_1) / c.length_1 * side
        n2 = c.a22 * c.rise_2 * abs(c.rise_2) / c.length_2 * side
    axial = c.voltage_force * volt
    return (stage_stiffness(c.restraint * n1 + axial, c.restraint * n2 + axial, c) - c.unstressed) * z


@njit
def dry_friction(v, c):
    """A force of constant size against the motion, N."""
    return c.friction * v / np.sqrt(v * v + c.friction_speed**2)


@njit
def acceleration(z, v, volt, volt_rate, c, curve):
    """z̈ from the equation of motion, m/s²."""
    field, field_rate = volt / c.layer, volt_rate / c.layer
    strain = c.d31 * field - c.eta * field**3 + c.zeta * field_rate**3
    return (
        c.gain * strain
        - c.damping * v
        - c.linear * z
        - c.cubic * z**3
        - extra_force(z, volt, c, curve)
        - dry_friction(v, c)
    ) / c.mass


@njit
def _march(z, v, volt, volt_rate, h, substeps, c, curve):
    n = (volt.size - 1) // (2 * substeps) + 1
    out = np.empty((2, n))
    out[0, 0], out[1, 0] = z, v
    i = 0
    for k in range(1, n):
        for _ in range(substeps):
            a1 = acceleration(z, v, volt[i], volt_rate[i], c, curve)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(z + 0.5 * h * v, v2, volt[i + 1], volt_rate[i + 1], c, curve)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(z + 0.5 * h * v2, v3, volt[i + 1], volt_rate[i + 1], c, curve)
            v4 = v + h * a3
            a4 = acceleration(z + h * v3, v4, volt[i + 2], volt_rate[i + 2], c, curve)
            z += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            i += 2
        out[0, k], out[1, k] = z, v
    return out


def prepare(
    stage: Stage, drive: Drive, t: np.ndarray, load: float = 0.0, curve: tuple[np.ndarray, np.ndarray] | None = None
) -> tuple[_Constants, np.ndarray]:
    """The constants and spline coefficients that `acceleration` takes.

    `curve` is (z in m on a uniform grid, force per beam in N), for the closure "curve".
    """
    knot, spacing, table = 0.0, 1.0, np.zeros((4, 1))
    if curve is not None:
        spline = CubicSpline(*curve)
        knot, spacing, table = float(spline.x[0]), float(spline.x[1] - spline.x[0]), np.ascontiguousarray(spline.c)
    return _constants(stage, load, reference_rate(drive, t), knot, spacing), table


def simulate(
    stage: Stage,
    drive: Drive,
    t: np.ndarray,
    *,
    load: float = 0.0,
    start: tuple[float, float] = (0.0, 0.0),
    curve: tuple[np.ndarray, np.ndarray] | None = None,
    substeps: int = 8,
) -> np.ndarray:
    """Displacement and velocity of the stage at the times `t`, (2, n) in m and m/s.

    **Arguments:**

    - `t`: (n,) s, uniform. `start`: state at t[0]. `load`: extra mass, kg.
    - `curve`: z (m) and force per beam (N), for the closure "curve".
    - `substeps`: Runge-Kutta steps per sample.

    Raises ValueError if the motion leaves all bounds (a beam has buckled).
    """
    constants, table = prepare(stage, drive, t, load, curve)
    fine = np.linspace(t[0], t[-1], 2 * substeps * (len(t) - 1) + 1)
    out = _march(*start, drive.value(fine), drive.rate(fine), 2 * (fine[1] - fine[0]), substeps, constants, table)
    if not np.all(np.isfinite(out)) or np.max(np.abs(out[0])) > 1e-3:
        raise ValueError("The stage left all bounds: a beam has buckled.")
    return out


def resonance(stage: Stage, volts: float, frequencies: np.ndarray, periods: int = 120) -> np.ndarray:
    """Half peak-to-peak amplitude of stepped sines in the given order, each started from the last state, (n,) m."""
    state, amplitude = (0.0, 0.0), np.empty(len(frequencies))
    for k, f in enumerate(frequencies):
        t = np.linspace(0, periods / f, 48 * periods + 1)
        out = simulate(stage, sine(volts, f), t, start=state, substeps=2)
        state = (float(out[0, -1]), float(out[1, -1]))
        amplitude[k] = np.ptp(out[0, -48 * 4 :]) / 2
    return amplitude
