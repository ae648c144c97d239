"""Force, drive and sensor laws of the hidden effects, written without a look at the tool's library.

Everything is dimensionless: time in 1/ω0, displacement in units of the largest linear response, voltage e in units of
the largest drive. The motion is z̈ = u − z − ż/Q + F(z, ż, e, …); the drive is u = G (e + …); the sensor reads z + ….
Each law has one coefficient `c` that scales it from zero and up to three shape numbers `s`, drawn at random. With the
detail "own" the curve differs from the textbook one (contact grows as the power 1.5, drifts are exponential, creep has
three rates); with "plain" it is the textbook one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit

from experiments.simulator.stiffness import segment_stiffness

Shape = Callable[[np.random.Generator, bool], tuple[float, float, float]]


@dataclass(frozen=True)
class Law:
    """A hidden effect.

    **Arguments:**

    - `name`: as in the tool's list of effects; names outside that list are never in a library.
    - `side`: "force", "drive" or "sensor"; `coordinates`: what the missing term depends on.
    - `shape`: draws the shape numbers, given whether the detail is "own".
    - `alike`: names that no data of this kind can tell from it.
    """

    name: str
    side: str
    coordinates: tuple[str, ...]
    shape: Shape = lambda rng, own: (0.0, 0.0, 0.0)
    in_library: bool = True
    alike: tuple[str, ...] = ()


def _one(low: float, high: float, plain: float) -> Shape:
    """One shape number: uniform for "own", fixed for "plain"."""
    return lambda rng, own: (rng.uniform(low, high) if own else plain, 0.0, 0.0)


def _flag(low: float, high: float) -> Shape:
    """A scale drawn in both cases, and whether the law is the own one."""
    return lambda rng, own: (rng.uniform(low, high), float(own), rng.uniform())


def _heat(rng: np.random.Generator, own: bool) -> tuple[float, float, float]:
    return rng.uniform(15, 60), rng.uniform(), 0.2 if own else 0.0


LAWS: tuple[Law, ...] = (
    # Width of the sign change (0: axial-force closure), stress, direct axial force at the largest drive (N/restraint).
    Law("residual-stress", "force", ("z", "e"), lambda rng, own: (
        rng.uniform(0.02, 0.15) * rng.integers(2) if own else 0.0,
        rng.choice([-1, 1]) * rng.uniform(40e6, 110e6), rng.uniform(-0.02, 0.02) if own else 0.0)),
    Law("arch-force", "force", ("z",), lambda rng, own: (0.0, rng.uniform(40e6, 110e6), 0.0),
        alike=("quadratic-stiffness",)),
    Law("cubic-stiffness", "force", ("z",), _one(0.05, 0.15, 0.0)),
    Law("quadratic-stiffness", "force", ("z",), _one(0.05, 0.15, 0.0), alike=("arch-force",)),
    Law("voltage-stiffness", "force", ("z", "e"), _one(0.05, 0.15, 0.0)),
    Law("stiffness-drift", "force", ("z", "t"), _flag(0.5, 1.5)),
    Law("end-stop", "force", ("z",), _flag(0.45, 0.75)),
    Law("static-force", "force", ("1",), alike=("sensor-offset",)),
    Law("second-mode", "force", ("history",), lambda rng, own: (rng.uniform(1.8, 3.2), rng.uniform(15, 60), 0.0)),
    Law("viscoelastic-support", "force", ("z", "history"), _flag(1.5, 8.0), alike=("creep",)),
    Law("coulomb-friction", "force", ("v",), lambda rng, own: (0.004 if own else 0.02, 0.0, 0.0)),
    Law("quadratic-damping", "force", ("v",), _one(0.03, 0.1, 0.0)),
    Law("cubic-damping", "force", ("v",), _one(0.05, 0.15, 0.0)),
    Law("squeeze-film-damping", "force", ("z", "v"), lambda rng, own: (rng.uniform(2.0, 4.0), 0.0, 0.0)),
    Law("damping-drift", "force", ("v", "t"), _flag(0.5, 1.5)),
    Law("bouc-wen", "force", ("z", "history"), lambda rng, own: (rng.uniform(0.15, 0.5), 2.0 if own else 1.0, 0.0)),
    Law("pzt-hysteresis", "drive", ("e", "de"),
        lambda rng, own: (rng.uniform(0.4, 1.6), rng.uniform(0.05, 0.15) if own else 0.0, 0.0)),
    Law("prandtl-ishlinskii", "drive", ("e", "history"),
        lambda rng, own: (rng.uniform(0.2, 0.5), 20.0 if own else 4.0, 0.0)),
    Law("bouc-wen-drive", "drive", ("e", "history"),
        lambda rng, own: (rng.uniform(0.15, 0.5), 2.0 if own else 1.0, 0.0)),
    Law("electrostriction", "drive", ("e",), _one(0.05, 0.15, 0.0)),
    Law("creep", "drive", ("e", "history"), _flag(6.0, 30.0), alike=("viscoelastic-support",)),
    Law("drive-lag", "drive", ("e", "history"), alike=("sensor-lag",)),
    Law("sensor-nonlinearity", "sensor", ("z",), _one(0.6, 1.0, 0.0)),
    Law("sensor-lag", "sensor", ("z", "history"), alike=("drive-lag",)),
    Law("sensor-crosstalk", "sensor", ("e",)),
    Law("sensor-drift", "sensor", ("t",), _flag(0.5, 1.5)),
    Law("sensor-offset", "sensor", ("1",), alike=("static-force",)),
    Law("sine-force", "force", ("z",), lambda rng, own: (rng.uniform(3.0, 6.0), 0.0, 0.0), in_library=False),
    # How the push falls off farther out, and the share of the damping that is the coil's.
    Law("force-factor", "force", ("z", "v", "e"),
        lambda rng, own: (rng.uniform(0.05, 0.15), rng.uniform(0.0, 0.9), 0.0) if own else (0.0, 0.0, 0.0)),
    Law("power-law-stiffness", "force", ("z",), lambda rng, own: (rng.uniform(1.3, 1.8) if own else 1.5, 0.0, 0.0)),
    Law("voltage-damping", "force", ("v", "e"), in_library=False),
    # On a platform near its resonance it is called Coulomb's, which leaves less of it than laws of one kind differ by.
    Law("stribeck-friction", "force", ("v",), lambda rng, own: (0.005, rng.uniform(0.5, 1.5), rng.uniform(0.1, 0.3)),
        alike=("coulomb-friction",)),
    # Where the plate is, in either direction.
    Law("electrostatic-force", "force", ("z", "e"),
        lambda rng, own: (rng.choice([-1, 1]) * rng.uniform(2.0, 5.0), 0.0, 0.0)),
    Law("power-law-damping", "force", ("v",),
        lambda rng, own: (rng.choice([rng.uniform(0.4, 0.7), rng.uniform(1.3, 1.7)]) if own else 1.5, 0.0, 0.0)),
    # Over how much of the travel a crack closes.
    Law("bilinear-stiffness", "force", ("z",), _one(0.005, 0.02, 0.0)),
    # How long it takes to warm up, what warms it (the drive below a half, else the motion), and how much it eases off.
    Law("stiffness-heating", "force", ("z", "history"), _heat),
    Law("damping-heating", "force", ("v", "history"), _heat),
    Law("drive-heating", "drive", ("e", "history"), _heat),
    # A brake at one place of the path: where, and how wide.
    Law("local-damping", "force", ("z", "v"), lambda rng, own: (rng.uniform(0.1, 0.5), rng.uniform(0.15, 0.4), 0.0),
        in_library=False),
    # By how much more moves along at one end of the path than at the other, for what does so at both.
    Law("variable-inertia", "force", ("z", "v"), _one(-1.0, 1.0, 0.0)),
)  # fmt: skip

NAMES = tuple(law.name for law in LAWS)
INDEX = {name: i for i, name in enumerate(NAMES)}

(STRESS, ARCH, CUBIC, QUADRATIC, VOLT, K_DRIFT, STOP, STATIC, MODE, VISCO, COULOMB, V2, V3, SQUEEZE, C_DRIFT, BOUC,
 PZT, PLAYS, BOUC_E, E2, CREEP, LAG_E, BEND, LAG_S, CROSS, S_DRIFT, OFFSET, SINE, COIL, POWER_Z, VE, STRIBECK,
 PLATE, POWER_V, BILINEAR, K_HEAT, C_HEAT, HEAT_E, BRAKE, INERTIA) = range(len(LAWS))  # fmt: skip

STATES = 9


@njit(error_model="numpy")
def progress(t, scale, own):
    """How far a drift has come at the fraction t of the record: linear, or exponential with the time `scale`."""
    t = max(t, 0.0)
    return (1.0 - math.exp(-t / scale)) if own > 0 else t


@njit(error_model="numpy")
def _stress(z, e, s, g):
    """Axial forces of the two segments per unit of restraint (N), and their rises (m).

    `g` holds the platform: unit of z (m), shares, rises per Pa, lengths, EI, corner ratios, A11, A12, A22, K(0).
    """
    zp = z * g[0]
    z1, z2, r1, r2 = g[1] * zp, g[2] * zp, g[3] * s[1], g[4] * s[1]
    if s[0] > 0:
        side = math.tanh(z / s[0])
        n1, n2 = g[10] * r1 * abs(r1) / g[5] * side, g[12] * r2 * abs(r2) / g[6] * side
    else:
        d1, d2 = (0.6 * z1 + r1) * z1 / g[5], (0.6 * z2 + r2) * z2 / g[6]
        n1, n2 = g[10] * d1 + g[11] * d2, g[11] * d1 + g[12] * d2
    return n1 + s[2] * e, n2 + s[2] * e, r1, r2


@njit(error_model="numpy")
def force(z, v, e, t, h, q1, q2, warm, u, quality, c, s, g):
    """F(z, ż, e, t; hidden states) at the fraction t of the record."""
    f = 0.0
    if c[STRESS] != 0:
        n1, n2, _, _ = _stress(z, e, s[STRESS], g)
        k1 = g[7] / g[5] ** 3 * segment_stiffness(c[STRESS] * n1 * g[5] ** 2 / g[7], g[8])
        k2 = g[7] / g[6] ** 3 * segment_stiffness(c[STRESS] * n2 * g[6] ** 2 / g[7], g[9])
        f -= (4 * k1 * k2 / (k1 + k2) / g[13] - 1.0) * z
    if c[ARCH] != 0:
        n1, n2, r1, r2 = _stress(z, e, s[ARCH], g)
        b1, b2 = r1 * g[1] / g[5], r2 * g[2] / g[6]
        linear = (g[10] * b1 * b1 + 2 * g[11] * b1 * b2 + g[12] * b2 * b2) * z * g[0]  # counted in ω0 already
        f -= 4 * c[ARCH] * (n1 * b1 + n2 * b2 - linear) / (g[13] * g[0])
    if c[CUBIC] != 0:
        f -= c[CUBIC] * z**3 / (1 + s[CUBIC, 0] * z * z)
    if c[QUADRATIC] != 0:
        f -= c[QUADRATIC] * z * z / (1 + s[QUADRATIC, 0] * z * z)
    if c[VOLT] != 0:
        f -= c[VOLT] * e * z / (1 + s[VOLT, 0] * e * e)
    if c[K_DRIFT] != 0:
        f -= c[K_DRIFT] * progress(t, s[K_DRIFT, 0], s[K_DRIFT, 1]) * z
    if c[STOP] != 0:
        power, gap = (1.5 if s[STOP, 1] > 0 else 1.0), s[STOP, 0]
        f -= c[STOP] * max(z - gap, 0.0) ** power
        if s[STOP, 2] > 0.5:
            f += c[STOP] * max(-z - gap, 0.0) ** power
    f += c[STATIC]
    if c[VISCO] != 0:
        f -= c[VISCO] * (z - (0.7 * q1 + 0.3 * q2 if s[VISCO, 1] > 0 else q1))
    if c[COULOMB] != 0:
        f -= c[COULOMB] * math.tanh(v / s[COULOMB, 0])
    if c[V2] != 0:
        f -= c[V2] * v * math.sqrt(v * v + s[V2, 0] ** 2)
    if c[V3] != 0:
        f -= c[V3] * v**3 / (1 + s[V3, 0] * v * v)
    if c[SQUEEZE] != 0:
        f -= c[SQUEEZE] * v * ((1 - min(z / s[SQUEEZE, 0], 0.9)) ** -3 - 1)
    if c[C_DRIFT] != 0:
        f -= c[C_DRIFT] * progress(t, s[C_DRIFT, 0], s[C_DRIFT, 1]) * v
    f -= c[BOUC] * h
    if c[SINE] != 0:
        f -= c[SINE] * math.sin(s[SINE, 0] * z)
    if c[COIL] != 0:
        less = min(c[COIL] * z * z / (1 + s[COIL, 0] * z * z), 1.0)
        f -= less * u - s[COIL, 1] * less * (2 - less) * v / quality
    f -= c[VE] * e * v
    if c[BRAKE] != 0:
        f -= c[BRAKE] * math.exp(-(((z - s[BRAKE, 0]) / s[BRAKE, 1]) ** 2)) * v
    if c[POWER_Z] != 0:
        f -= c[POWER_Z] * z * abs(z) ** (s[POWER_Z, 0] - 1)
    if c[POWER_V] != 0:
        f -= c[POWER_V] * math.copysign(abs(v) ** s[POWER_V, 0], v)
    if c[STRIBECK] != 0:
        peak = 1 + s[STRIBECK, 1] * math.exp(-((v / s[STRIBECK, 2]) ** 2))
        f -= c[STRIBECK] * math.tanh(v / s[STRIBECK, 0]) * peak
    if c[PLATE] != 0:
        f += c[PLATE] * math.copysign(e * e, s[PLATE, 0]) / max(1 - z / s[PLATE, 0], 0.1) ** 2
    if c[BILINEAR] != 0:
        f -= c[BILINEAR] * (math.sqrt(z * z + s[BILINEAR, 0] ** 2) - s[BILINEAR, 0])
    if c[K_HEAT] != 0:
        f -= c[K_HEAT] * warm[0] / (1 + s[K_HEAT, 2] * warm[0]) * z
    if c[C_HEAT] != 0:
        f -= c[C_HEAT] * warm[1] / (1 + s[C_HEAT, 2] * warm[1]) * v
    return f


@njit(error_model="numpy")
def rate(x, u, e, t, c, s, g, quality, out):
    """Rates of the state (z, ż, h, q1, q2, z2, ż2, w1, w2): oscillator, Bouc-Wen, Zener supports, second mode, warmth
    of the spring and of the damper."""
    z, v, h, q1, q2, m, mv = x[0], x[1], x[2], x[3], x[4], x[5], x[6]
    out[0] = v
    out[1] = u - z - v / quality + force(z, v, e, t, h, q1, q2, x[7:], u, quality, c, s, g)
    if c[INERTIA] != 0:  # of its kinetic energy
        more, change = c[INERTIA] * (s[INERTIA, 0] + z) * z, c[INERTIA] * (s[INERTIA, 0] + 2 * z)
        out[1] = (out[1] - 0.5 * change * v * v) / (1 + more)
    out[2] = out[3] = out[4] = out[5] = out[6] = out[7] = out[8] = 0.0
    if c[BOUC] != 0:
        grip = abs(h / s[BOUC, 0]) ** s[BOUC, 1]
        out[2] = v * (1 - grip) if v * h > 0 else v
    if c[VISCO] != 0:
        out[3] = (z - q1) / s[VISCO, 0]
        out[4] = (z - q2) / (8 * s[VISCO, 0])
    if c[MODE] != 0:
        w2 = s[MODE, 0]
        out[5] = mv
        out[6] = w2 * w2 * (u - m) - w2 / s[MODE, 1] * mv
    if c[K_HEAT] != 0:
        out[7] = ((e * e if s[K_HEAT, 1] < 0.5 else v * v) - x[7]) / s[K_HEAT, 0]
    if c[C_HEAT] != 0:
        out[8] = ((e * e if s[C_HEAT, 1] < 0.5 else v * v) - x[8]) / s[C_HEAT, 0]


@njit(error_model="numpy")
def march(x0, u, e, h, substeps, t0, span, c, s, g, quality):
    """Runge-Kutta over half-step arrays `u` and `e` (2N+1,); z, ż and z2 after every step, (3, N+1)."""
    n = (u.size - 1) // 2
    out = np.empty((3, n + 1))
    x, y = x0.copy(), np.empty(STATES)
    k1, k2, k3, k4 = np.empty(STATES), np.empty(STATES), np.empty(STATES), np.empty(STATES)
    out[0, 0], out[1, 0], out[2, 0] = x[0], x[1], x[5]
    for k in range(n):
        t = t0 + k * h / span
        i = 2 * k
        rate(x, u[i], e[i], t, c, s, g, quality, k1)
        for j in range(STATES):
            y[j] = x[j] + 0.5 * h * k1[j]
        rate(y, u[i + 1], e[i + 1], t + 0.5 * h / span, c, s, g, quality, k2)
        for j in range(STATES):
            y[j] = x[j] + 0.5 * h * k2[j]
        rate(y, u[i + 1], e[i + 1], t + 0.5 * h / span, c, s, g, quality, k3)
        for j in range(STATES):
            y[j] = x[j] + h * k3[j]
        rate(y, u[i + 2], e[i + 2], t + h / span, c, s, g, quality, k4)
        for j in range(STATES):
            x[j] += h / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j])
        out[0, k + 1], out[1, k + 1], out[2, k + 1] = x[0], x[1], x[5]
        if not abs(x[0]) < 1e3:
            out[:, k + 1 :] = np.nan
            break
    return out


@njit(error_model="numpy")
def lag(x, h, tau):
    """First-order lag of samples `x` at spacing `h`, exact for straight lines between samples, from x[0]."""
    out = np.empty_like(x)
    out[0] = x[0]
    decay = math.exp(-h / tau)
    mean = tau / h * (1 - decay)
    for k in range(1, x.size):
        out[k] = decay * out[k - 1] + (mean - decay) * x[k - 1] + (1 - mean) * x[k]
    return out


@njit(error_model="numpy")
def plays(e, reach, number):
    """Sum of play operators with evenly spaced half-widths up to `reach` and exponentially falling weights."""
    out = np.zeros_like(e)
    for j in range(number):
        width = reach * (j + 1.0) / number
        weight, p = math.exp(-2.0 * width / reach) / number, 0.0
        for k in range(e.size):
            p = min(max(p, e[k] - width), e[k] + width)
            out[k] += weight * p
    return out


@njit(error_model="numpy")
def bouc_wen_drive(e, limit, power):
    """Bouc-Wen state of the voltage; it does not depend on the rate, so it is stepped in the voltage itself.

    A drive that starts with a jump has risen from zero, as for the other laws: in as many steps as there are samples.
    """
    out = np.zeros_like(e)
    h = 0.0
    for k in range(1 - e.size, e.size):
        d = e[0] / e.size if k < 1 else e[k] - e[k - 1]
        half = h + 0.5 * d * (1 - (abs(h / limit) ** power if d * h > 0 else 0.0))
        h += d * (1 - (abs(half / limit) ** power if d * half > 0 else 0.0))
        out[max(k, 0)] = h
    return out


def driven(e: np.ndarray, de: np.ndarray, reference: float, h: float, c: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The effective drive u/G on the half-step grid of spacing `h`; `reference` is the drive's own frequency."""
    u = e.copy()
    if c[LAG_E] > 0:  # at rest before: a drive that starts with a jump is followed late from zero
        u = lag(e, h, c[LAG_E]) - e[0] * np.exp(-h * np.arange(len(e)) / c[LAG_E])
    if c[PZT]:
        u += c[PZT] * (s[PZT, 0] * (de / reference) ** 3 - e**3 - s[PZT, 1] * e**5)
    if c[PLAYS]:
        u += c[PLAYS] * plays(e, s[PLAYS, 0], int(s[PLAYS, 1]))
    if c[BOUC_E]:
        u += c[BOUC_E] * bouc_wen_drive(e, s[BOUC_E, 0], s[BOUC_E, 1])
    if c[E2]:
        u += c[E2] * e**2 / (1 + s[E2, 0] * e**2)
    if c[CREEP]:
        parts = ((0.5, 1.0), (0.3, 6.0), (0.2, 36.0)) if s[CREEP, 1] else ((1.0, 1.0),)
        u += c[CREEP] * sum(w * (lag(e, h, k * s[CREEP, 0]) - e[0] * np.exp(-h * np.arange(len(e)) / (k * s[CREEP, 0])))
                            for w, k in parts)  # fmt: skip
    if c[HEAT_E]:
        cold = np.exp(-h * np.arange(len(e)) / s[HEAT_E, 0])
        warm = lag(e * e, h, s[HEAT_E, 0]) - e[0] ** 2 * cold
        u -= c[HEAT_E] * warm / (1 + s[HEAT_E, 2] * warm) * e
    return u


def sensed(
    z: np.ndarray, m: np.ndarray, e: np.ndarray, t: np.ndarray, h: float, c: np.ndarray, s: np.ndarray
) -> np.ndarray:
    """What the sensor reads on the step grid of spacing `h`; `m` is the second mode, `t` the fraction of the record."""
    y = lag(z, h, c[LAG_S]) if c[LAG_S] > 0 else z.copy()
    y += c[MODE] * m + c[CROSS] * e + c[OFFSET]
    if c[BEND]:
        p = s[BEND, 0]
        y += c[BEND] * ((np.tanh(p * z) / p - z) * 3 / p**2 if p else -(z**3))
    if c[S_DRIFT]:
        y += c[S_DRIFT] * np.array([progress(x, s[S_DRIFT, 0], s[S_DRIFT, 1]) for x in t])
    return y
