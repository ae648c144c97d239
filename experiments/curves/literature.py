"""Steady responses against closed forms and harmonic balance: `python -m experiments.curves.literature`.

The Duffing oscillator z̈ + 2ζ ż + z + γ z³ = P cos Ωt of Krack and Gross (ζ 0.05, γ 0.1, P 0.18). Its backbone is an
elliptic integral, the determinant of its period map is exp(−4πζ/Ω) (Liouville), its two jumps have closed forms of
first order; where these end, a harmonic balance with alternating frequency-time, written here, goes on with as many
harmonics as one likes. The same balance with friction shows what corners ask of it.

Sources: M. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, §2, §5.1 (the case, AFT); I.
Kovacic, M. J. Brennan (eds.), The Duffing Equation, 2011, §2.2 (the period), §5 (the response); M. J. Brennan, I.
Kovacic, A. Carrella, T. P. Waters, On the jump-up and jump-down frequencies of the Duffing oscillator, J. Sound Vib.
318 (2008) 1250.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import root
from scipy.special import ellipk

from ident import runtime

runtime.configure()

from ident.campaign.device import Oscillator  # noqa: E402  (JAX must be configured first)
from ident.effects.registry import built_in  # noqa: E402
from ident.model import Model  # noqa: E402
from ident.response import Equation  # noqa: E402
from ident.response.branches import follow  # noqa: E402
from ident.response.controlled import Controlled, Points, at_amplitude  # noqa: E402
from ident.response.periodic import Periodic  # noqa: E402

ZETA, GAMMA, PUSH = 0.05, 0.1, 0.18
STEPS = (48, 64, 96, 128, 256)  # per period
AMPLITUDES = (0.5, 1.0, 2.0, 4.0)  # of the backbone: γA² from 0.025 to 1.6, half as much again as the linear spring
HARMONICS = (1, 3, 5, 7, 9, 15)
FRICTION, SHARP = 0.02, 0.02  # of the corner: force, and velocity over which it turns
CORNERS = (1, 3, 9, 15, 31, 63, 127)
MANY = 255  # harmonics that stand for all
OWN = 1 / (2 * np.pi)  # Hz, where the linear oscillator has 1 rad/s


def oscillator(steps: int, zeta: float = ZETA) -> Periodic:
    """The oscillator as `ident` takes it, of unit mass."""
    device = Oscillator()
    model = Model(device) + built_in()["cubic-stiffness"](device)
    return Periodic(Equation(model), np.array([OWN, 0.5 / zeta, 1.0, GAMMA, 0.0]), steps)


def answer(model: Periodic, pulsation: float, amplitude: float, swing: bool = False) -> Controlled:
    """The response with an amplitude (half the peak-to-peak value if `swing`) at a pulsation, rad/s."""
    one = lambda x: np.array([float(x)])
    return at_amplitude(model, Points(one(pulsation * OWN), one(1), one(amplitude), one(0), np.array([swing])))


def backbone(steps: int) -> float:
    """Largest relative error of the pulsation at which no force in phase is needed, over the amplitudes.

    Exactly: Ω = π √(1 + γA²)/(2 K(m)), m = γA²/(2 (1 + γA²)), with the complete elliptic integral K.
    """
    model, worst = oscillator(steps, 1e-6), 0.0
    for amplitude in AMPLITUDES:
        bend = GAMMA * amplitude**2
        exact = np.pi * np.sqrt(1 + bend) / (2 * ellipk(0.5 * bend / (1 + bend)))
        sides = np.array([-0.03, -0.01, 0.01, 0.03])  # nearer no force is left that has a phase
        found = [answer(model, exact * (1 + side), amplitude, True) for side in sides]
        assert all(one.converged[0] for one in found)
        cubic = np.polyfit([one.needed[0].real for one in found], sides, 3)
        worst = max(worst, abs(float(cubic[-1])))
    return worst


def jumps(steps: int) -> tuple[np.ndarray, float, float]:
    """Pulsations of the lower and the upper fold; how far the largest multiplier is from one there, and the determinant
    of the period map from Liouville's along the whole curve, relative."""
    model = oscillator(steps)
    branch = follow(model, np.array([PUSH]), np.zeros(1), np.array([[0.5, 1.6]]) * OWN, np.array([1.9]))[0]

    def off(x: np.ndarray) -> list[float]:
        there = answer(model, x[0], x[1])
        return [abs(there.needed[0]) / PUSH - 1, float(np.real(there.by_amplitude[0] / there.needed[0]))]

    found, multipliers = [], []
    for fold in sorted(branch.folds, key=lambda fold: fold.frequency):
        pulsation, amplitude = root(off, [fold.frequency / OWN, fold.amplitude], tol=1e-11).x
        found.append(pulsation)
        multipliers.append(np.max(np.abs(answer(model, pulsation, amplitude).multipliers())))
    some = slice(None, None, 10)
    frequency, zero = branch.frequency[some], np.zeros(len(branch.frequency[some]))
    points = Points(frequency, zero + PUSH, np.abs(branch.tone[some]), zero, zero > 0)
    product = np.real(np.prod(at_amplitude(model, points).multipliers(), axis=1))
    liouville = np.exp(-2 * ZETA / points.frequency)
    farthest = lambda ratio: float(np.max(np.abs(np.array(ratio) - 1)))
    return np.array(found), farthest(multipliers), farthest(product / liouville)


def balance(harmonics: int, force: Callable, slope: Callable, samples: int) -> tuple[Callable, Callable]:
    """Residual and Jacobian (of the coefficients X) of a harmonic balance with odd harmonics up to some order; `force`
    and `slope` (two, by displacement and velocity) of what is not linear, evaluated in time."""
    orders = np.arange(1, harmonics + 1, 2)
    angle = 2 * np.pi * np.arange(samples) / samples
    cosine, sine = np.cos(np.outer(angle, orders)), np.sin(np.outer(angle, orders))
    there, back = np.hstack([cosine, sine]), 2 / samples * np.hstack([cosine, sine]).T
    faster = np.hstack([-orders * sine, orders * cosine])  # times Ω: the velocity
    n = len(orders)

    def linear(pulsation: float) -> np.ndarray:
        even, odd = np.diag(1 - (orders * pulsation) ** 2), np.diag(2 * ZETA * orders * pulsation)
        return np.block([[even, odd], [-odd, even]])

    def residual(x: np.ndarray, pulsation: float) -> np.ndarray:
        found = linear(pulsation) @ x + back @ force(there @ x, pulsation * faster @ x)
        found[0] -= PUSH
        return found

    def jacobian(x: np.ndarray, pulsation: float) -> np.ndarray:
        by_z, by_v = slope(there @ x, pulsation * faster @ x)
        return linear(pulsation) + back @ (by_z[:, None] * there + by_v[:, None] * pulsation * faster)

    assert len(there) >= 2 * n
    return residual, jacobian


def balanced_fold(harmonics: int, start: tuple[float, float]) -> float:
    """Pulsation of the fold near a pulsation and an amplitude, by harmonic balance: R = 0, J v = 0, |v| = 1."""
    still = lambda z: np.zeros_like(z)
    residual, jacobian = balance(
        harmonics, lambda z, v: GAMMA * z**3, lambda z, v: (3 * GAMMA * z**2, still(z)), 8 * (harmonics + 1)
    )
    n, (pulsation, amplitude) = harmonics + 1, start
    spring = 1 + 0.75 * GAMMA * amplitude**2 - pulsation**2
    tone = PUSH / (spring + 2j * ZETA * pulsation)
    x = np.zeros(n)
    x[0], x[n // 2] = tone.real, -tone.imag
    _, _, right = np.linalg.svd(jacobian(x, pulsation))

    def off(w: np.ndarray) -> np.ndarray:
        x, v, pulsation = w[:n], w[n : 2 * n], w[-1]
        return np.concatenate([residual(x, pulsation), jacobian(x, pulsation) @ v, [v @ v - 1]])

    found = root(off, np.concatenate([x, right[-1], [pulsation]]), tol=1e-13)
    assert found.success, found.message
    return float(found.x[-1])


def with_friction(harmonics: int) -> complex:
    """Fundamental at Ω = 0.9 with friction in place of the cubic spring, by harmonic balance."""
    turn = lambda v: np.tanh(v / SHARP)
    residual, jacobian = balance(
        harmonics, lambda z, v: FRICTION * turn(v), lambda z, v: (0 * z, FRICTION / SHARP * (1 - turn(v) ** 2)), 4096
    )
    x = np.zeros(harmonics + 1)
    x[0] = PUSH / (1 - 0.81)
    x = root(lambda x: residual(x, 0.9), x, jac=lambda x: jacobian(x, 0.9), tol=1e-12).x
    return complex(x[0] - 1j * x[len(x) // 2])


def friction_by_shooting(steps: int) -> complex:
    """The same by `ident`."""
    device, expected = Oscillator(), with_friction(MANY)
    model = Model(device) + built_in()["coulomb-friction"](device)
    there = Periodic(Equation(model), np.array([OWN, 0.5 / ZETA, 1.0, FRICTION, SHARP]), steps)
    found = answer(there, 0.9, abs(expected))
    # The amplitude is given, the force is the answer; to first order they are in proportion.
    return abs(expected) * PUSH / found.needed[0]


def main() -> None:
    """Compare, print and assert."""
    exact = np.array([balanced_fold(MANY // 8, start) for start in first_order_folds()])
    print("solver steps a period: backbone, folds (against a balance of 31 harmonics), multiplier at a fold, Liouville")
    errors = []
    for steps in STEPS:
        folds, multiplier, liouville = jumps(steps)
        errors.append([backbone(steps), float(np.max(np.abs(folds / exact - 1))), multiplier, liouville])
        print(f"  {steps:4d}: " + ", ".join(f"{x:.1e}" for x in errors[-1]))
    print("harmonics of a balance: folds; fundamental with friction")
    folds_of = lambda h: [start[0] if h == 1 else balanced_fold(h, start) for start in first_order_folds()]
    balances = [float(np.max(np.abs(np.array(folds_of(h)) / exact - 1))) for h in HARMONICS]
    for h, off in zip(HARMONICS, balances, strict=True):
        print(f"  {h:4d}: {off:.1e}")
    everything = with_friction(MANY)
    corners = [abs(with_friction(h) / everything - 1) for h in CORNERS]
    for h, off in zip(CORNERS, corners, strict=True):
        print(f"  {h:4d}, with friction: {off:.1e}")
    shot = [abs(friction_by_shooting(steps) / everything - 1) for steps in STEPS]
    print("  friction, solver steps a period: " + ", ".join(f"{n}: {x:.1e}" for n, x in zip(STEPS, shot, strict=True)))
    down = np.sqrt(0.5 + 0.5 * np.sqrt(1 + 0.75 * GAMMA * PUSH**2 / ZETA**2))
    up = np.sqrt(1 + 1.5 ** (4 / 3) * (GAMMA * PUSH**2) ** (1 / 3))
    print(f"jumps up, down: {exact[0]:.4f}, {exact[1]:.4f}; first order (Brennan et al.) {up:.4f}, {down:.4f}")
    backbones, folds, at_folds, determinants = np.array(errors).T
    rate = np.log(folds[0] / folds[-1]) / np.log(STEPS[-1] / STEPS[0])
    print(f"order of convergence of the folds {rate:.1f}")
    assert backbones[0] < 1e-5 and backbones[-1] < 1e-6  # Newton's method leaves its own 1e-7
    assert folds[0] < 1e-6 and folds[-1] < 1e-9 and rate > 3.8
    assert at_folds[-1] < 1e-9 and determinants[-1] < 1e-6
    assert corners[-2] > 1e-7 > shot[-1]  # 63 harmonics, and the steps that `ident` takes for friction
    assert balances[0] > 1e-4 and balances[-1] < 1e-9
    assert abs(down / exact[1] - 1) < 0.01 and abs(up / exact[0] - 1) < 0.02


def first_order_folds() -> list[tuple[float, float]]:
    """Pulsation and amplitude of the folds to first order: |1 + ¾γA² − Ω² + 2iζΩ| A = P has a double root A."""
    found: list[tuple[float, float]] = []
    down = np.sqrt(0.5 + 0.5 * np.sqrt(1 + 0.75 * GAMMA * PUSH**2 / ZETA**2))
    up = np.sqrt(1 + 1.5 ** (4 / 3) * (GAMMA * PUSH**2) ** (1 / 3))
    for start in ((up, (2 * PUSH / (3 * GAMMA)) ** (1 / 3)), (down, PUSH / (2 * ZETA * down))):

        def off(x: np.ndarray) -> list[float]:
            bend, damp = 0.75 * GAMMA * x[1] ** 2, (2 * ZETA * x[0]) ** 2
            spring = 1 - x[0] ** 2
            return [((spring + bend) ** 2 + damp) * x[1] ** 2 - PUSH**2, (spring + bend) * (spring + 3 * bend) + damp]

        pulsation, amplitude = root(off, start).x
        found.append((float(pulsation), float(amplitude)))
    return found


if __name__ == "__main__":
    main()
