"""The peers: what a careful programmer would write without `ident`, for speed ratios in one process.

One stage, axial-force closure, hysteresis polynomial, eight parameters `theta`:

    0 frequency (Hz)   1 quality   2 d31 (m/V)   3 sigma12 (Pa)   4 restraint   5 voltage_force (N/V)
    6 eta (m³/V³)      7 zeta (m³/V³)

Three of them: numba with fixed Runge-Kutta steps and the rational stiffness; the same with finite differences inside
SciPy's `lm`; SciPy's adaptive solver inside `least_squares`. The drive comes as arrays at half steps: `volt` and
`volt_rate`, (2·substeps·(n − 1) + 1,), V and V/s.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.optimize import OptimizeResult, least_squares

from experiments.simulator.geometry import Geometry

NAMES = ("frequency", "quality", "d31", "sigma12", "restraint", "voltage_force", "eta", "zeta")
SCALE = np.array([500.0, 30.0, 6e-11, 8e7, 0.4, 5e-3, 2e-23, 2e-23])

_G = Geometry()
_MASS, _GAIN, _LAYER = _G.stage_mass, _G.drive_gain, _G.pzt_thickness
_L1, _L2 = _G.length_1, _G.length_2
_R1, _R2 = _G.corner_ratios
_S1, _S2 = _G.shares
_RISE_1, _RISE_2 = _G.initial_shape(_G.residual_moment(1.0, 0.0, -17.0 / 30.0))  # per Pa of sigma12
(_A11, _A12), (_, _A22) = _G.frame_stiffness()
_B1, _B2 = _G.bending / _L1**3, _G.bending / _L2**3
_X1, _X2 = _L1**2 / _G.bending / 4, _L2**2 / _G.bending / 4  # s = N l²/(4 EI)
_K0 = _G.stage_stiffness


def _continued_fraction(last: int = 25) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Polynomials (B, A) in s, lowest power first, with B/A = 1/(3 + s/(5 + … s/last))."""
    b, a = np.array([1.0]), np.array([float(last)])
    for k in range(last - 2, 2, -2):
        b, a = a, np.polynomial.polynomial.polyadd(k * a, np.concatenate([[0.0], b]))
    return tuple(b / a[0]), tuple(a / a[0])


_NUMERATOR, _DENOMINATOR = _continued_fraction()
_NB, _NA = len(_NUMERATOR), len(_DENOMINATOR)


@njit(fastmath=True, error_model="numpy")
def _fraction(s, r):
    """Numerator and denominator of K l³/(4 EI), so that two segments in series cost one division."""
    b, a = _NUMERATOR[_NB - 1], _DENOMINATOR[_NA - 1]
    for i in range(_NB - 2, -1, -1):
        b = b * s + _NUMERATOR[i]
    for i in range(_NA - 2, -1, -1):
        a = a * s + _DENOMINATOR[i]
    q = a + s * b
    return q * a + r * q * q + r * s * a * a, b * (a + r * q) + r * a * a


@njit(fastmath=True, error_model="numpy")
def _stress_force(z, volt, sigma, restraint, direct):
    """[K(N(z, V)) − K(0)] z, N."""
    z1, z2 = _S1 * z, _S2 * z
    d1 = (0.6 * z1 + _RISE_1 * sigma) * z1 / _L1
    d2 = (0.6 * z2 + _RISE_2 * sigma) * z2 / _L2
    axial = direct * volt
    p1, q1 = _fraction(_X1 * (restraint * (_A11 * d1 + _A12 * d2) + axial), _R1)
    p2, q2 = _fraction(_X2 * (restraint * (_A12 * d1 + _A22 * d2) + axial), _R2)
    p1 *= 4.0 * _B1
    p2 *= 4.0 * _B2
    return (4.0 * p1 * p2 / (p1 * q2 + p2 * q1) - _K0) * z


@njit(fastmath=True, error_model="numpy")
def _accelerate(z, v, volt, force, w2, damp, sigma, restraint, direct):
    return force - damp * v - w2 * z - _stress_force(z, volt, sigma, restraint, direct) / _MASS


@njit(fastmath=True, error_model="numpy")
def _drive_force(volt, volt_rate, d31, eta, zeta):
    field, rate = volt / _LAYER, volt_rate / _LAYER
    return _GAIN / _MASS * (d31 * field - eta * field**3 + zeta * rate**3)


@njit(fastmath=True, error_model="numpy")
def simulate(theta, volt, volt_rate, reference, h, substeps, out):
    """Displacement from rest at every sample, written to `out` (n,) m; `h` is the Runge-Kutta step, s.

    `reference` is the drive's angular frequency (rad/s) of the hysteresis polynomial.
    """
    w0 = 2.0 * math.pi * theta[0]
    w2, damp, d31, sigma, restraint, direct = w0 * w0, w0 / theta[1], theta[2], theta[3], theta[4], theta[5]
    eta, zeta = theta[6], theta[7] / reference**3
    z, v, i = 0.0, 0.0, 0
    out[0] = 0.0
    f0 = _drive_force(volt[0], volt_rate[0], d31, eta, zeta)
    for k in range(1, out.size):
        for _ in range(substeps):
            u0, um, u1 = volt[i], volt[i + 1], volt[i + 2]
            fm = _drive_force(um, volt_rate[i + 1], d31, eta, zeta)
            f1 = _drive_force(u1, volt_rate[i + 2], d31, eta, zeta)
            a1 = _accelerate(z, v, u0, f0, w2, damp, sigma, restraint, direct)
            v2 = v + 0.5 * h * a1
            a2 = _accelerate(z + 0.5 * h * v, v2, um, fm, w2, damp, sigma, restraint, direct)
            v3 = v + 0.5 * h * a2
            a3 = _accelerate(z + 0.5 * h * v2, v3, um, fm, w2, damp, sigma, restraint, direct)
            v4 = v + h * a3
            a4 = _accelerate(z + h * v3, v4, u1, f1, w2, damp, sigma, restraint, direct)
            z += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            f0 = f1
            i += 2
        out[k] = z
    return out


@njit(error_model="numpy")
def jacobian(theta, scale, volt, volt_rate, reference, h, substeps, out):
    """One-sided finite differences ∂z/∂(theta/scale), (n, 8) m, at a relative step of 1e-6; `out` is z at theta."""
    simulate(theta, volt, volt_rate, reference, h, substeps, out)
    result, moved, other = np.empty((out.size, theta.size)), theta.copy(), np.empty(out.size)
    for j in range(theta.size):
        moved[j] = theta[j] + 1e-6 * scale[j]
        simulate(moved, volt, volt_rate, reference, h, substeps, other)
        moved[j] = theta[j]
        for k in range(out.size):
            result[k, j] = (other[k] - out[k]) / 1e-6
    return result


def fit_numba(
    theta: np.ndarray,
    volt: np.ndarray,
    volt_rate: np.ndarray,
    reference: float,
    h: float,
    substeps: int,
    response: np.ndarray,
    sigma: float,
) -> OptimizeResult:
    """SciPy's `lm` on the numba simulation with finite-difference Jacobian; `x` of the result is theta/SCALE."""
    out = np.empty(len(response))

    def residuals(x: np.ndarray) -> np.ndarray:
        r = (simulate(x * SCALE, volt, volt_rate, reference, h, substeps, out) - response) / sigma
        return np.where(np.isfinite(r), r, 1e6)

    def slope(x: np.ndarray) -> np.ndarray:
        j = jacobian(x * SCALE, SCALE, volt, volt_rate, reference, h, substeps, np.empty(len(response))) / sigma
        return np.where(np.isfinite(j), j, 0.0)

    return least_squares(residuals, theta / SCALE, jac=slope, method="lm", xtol=1e-10, ftol=1e-10)


def _hermite(volt: np.ndarray, volt_rate: np.ndarray, half: float) -> Callable[[float], tuple[float, float]]:
    """Voltage and its rate at any time from values and rates on a grid of spacing `half`, in plain floats."""
    value, rate, last = volt.tolist(), volt_rate.tolist(), len(volt) - 2

    def at(t: float) -> tuple[float, float]:
        i = min(max(int(t / half), 0), last)
        x = t / half - i
        a, b, da, db = value[i], value[i + 1], rate[i] * half, rate[i + 1] * half
        c3, c2 = 2 * (a - b) + da + db, 3 * (b - a) - 2 * da - db
        return a + x * (da + x * (c2 + x * c3)), (da + x * (2 * c2 + 3 * x * c3)) / half

    return at


def _closed_form(x: float, r: float) -> float:
    """K l³/EI in hyperbolic or circular functions, as a paper prints it."""
    if abs(x) < 1e-3:
        flexibility = (1 + 4 * r) / (12 * (1 + r))
        return (1 + x * (r * (1 + 3 * r) / (24 * (1 + r) ** 2) + 1 / 120) / flexibility) / flexibility
    u = math.sqrt(abs(x))
    c, s = (math.cosh(u), math.sinh(u) / u) if x > 0 else (math.cos(u), math.sin(u) / u)
    return x / (1 - s + (c - 1) * (c - 1 + r * x * s) / (x * (s + r * c)))


def simulate_adaptive(
    theta: np.ndarray,
    volt: np.ndarray,
    volt_rate: np.ndarray,
    reference: float,
    h: float,
    substeps: int,
    n: int,
    method: str = "LSODA",
    rtol: float = 1e-6,
) -> np.ndarray:
    """Displacement from rest at every sample by `solve_ivp`, (n,) m; the arguments of `simulate`."""
    frequency, quality, d31, sigma, restraint, direct, eta, zeta = (float(x) for x in theta)
    w0, drive = 2 * math.pi * frequency, _hermite(volt, volt_rate, h / 2)
    rise_1, rise_2, zeta = _RISE_1 * sigma, _RISE_2 * sigma, zeta / reference**3

    def rate(t: float, state: np.ndarray) -> tuple[float, float]:
        z, v = state.tolist()
        u, du = drive(t)
        z1, z2 = _S1 * z, _S2 * z
        d1, d2 = (0.6 * z1 + rise_1) * z1 / _L1, (0.6 * z2 + rise_2) * z2 / _L2
        n1 = restraint * (_A11 * d1 + _A12 * d2) + direct * u
        n2 = restraint * (_A12 * d1 + _A22 * d2) + direct * u
        k1, k2 = _B1 * _closed_form(4 * _X1 * n1, _R1), _B2 * _closed_form(4 * _X2 * n2, _R2)
        strain = d31 * u / _LAYER - eta * (u / _LAYER) ** 3 + zeta * (du / _LAYER) ** 3
        extra = (4 * k1 * k2 / (k1 + k2) - _K0) * z
        return v, (_GAIN * strain - extra) / _MASS - w0 / quality * v - w0 * w0 * z

    t = np.arange(n) * (h * substeps)
    scale = rtol * np.array([1e-6, 1e-6 * w0])
    return np.asarray(solve_ivp(rate, (0.0, t[-1]), (0.0, 0.0), method, t, rtol=rtol, atol=scale).y[0])


def fit_adaptive(
    theta: np.ndarray,
    volt: np.ndarray,
    volt_rate: np.ndarray,
    reference: float,
    h: float,
    substeps: int,
    response: np.ndarray,
    sigma: float,
    rtol: float = 1e-7,
    evaluations: int = 30,
) -> OptimizeResult:
    """SciPy's `least_squares` on `simulate_adaptive`, differences of relative step 1e-4; `x` is theta/SCALE."""

    def residuals(x: np.ndarray) -> np.ndarray:
        z = simulate_adaptive(x * SCALE, volt, volt_rate, reference, h, substeps, len(response), rtol=rtol)
        return (z - response) / sigma

    return least_squares(residuals, theta / SCALE, diff_step=1e-4, max_nfev=evaluations)
