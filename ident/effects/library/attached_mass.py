"""A part that the stage carries on a spring of its own."""

import math
from collections.abc import Mapping

from ..effect import AbstractEffect, Drive, Linear, Scalar, State, amplitude, shape


class AttachedMass(AbstractEffect):
    """A mass on the stage, on a spring and a damper: F = −k (z − x) − c (ż − ẋ), ẍ = ω_a² (z − x) + (ω_a/Q_a)(ż − ẋ).

    c = k/(ω_a Q_a), and the mass is k/ω_a². As of a vibration absorber, a loose part, a package, the next storey of a
    structure: two resonances, and an antiresonance of the stage at ω_a, where drive and sensor are on the stage. On a
    device that is linear otherwise this is the same transfer function as `second-mode`, and is called that. Where a law
    of the stage bends they differ: there it acts on all of the displacement and moves both modes, not one of them.
    The drive acts on the stage alone, not on the part.
    """

    name = "attached-mass"
    equation = "F = −k (z − x) − k/(ω_a Q_a) (ż − ẋ), ẍ = ω_a² (z − x) + (ω_a/Q_a)(ż − ẋ), ω_a = 2π/T_a"
    source = "J. P. Den Hartog, Mechanical Vibrations, 1956, §3.2 (the dynamic vibration absorber)"
    mistaken_for = ("second-mode",)
    form_of = ("second-mode",)
    steps_per_period = 120
    hidden_units = ("m", "m/s")

    stiffness = amplitude("N/m", "stiffness between stage and part, k", one_sided=True)
    period = shape(
        "s", "period of the part on a stage held still, T_a", scale="period",
        grid=(0.17, 0.2, 0.25, 0.32, 0.4, 0.5, 0.63, 0.8, 0.9, 1.0, 1.1, 1.3, 1.6, 2.2, 3.0),
    )  # fmt: skip
    quality = shape("1", "its quality factor, Q_a", grid=(30.0,))

    @classmethod
    def in_its_form(cls, there: Linear, usual: Mapping[str, float]) -> tuple[Linear, dict[str, float]] | None:
        """Poles and zeros of z/V compared: (s² + c₀ s + ω₀²) A + μ s² B = D₁ D₂ with A = s² + B, B = c_a s + ω_a², the
        zeros; μ = k/(m ω_a²). None where the modes have no zero between them, as modes of opposite sign."""
        w1, w2 = there.omega**2, (2 * math.pi / usual["period"]) ** 2
        c1, c2 = there.omega / there.quality, w2**0.5 / usual["quality"]
        own, other = there.push / there.mass, usual["travel"] * w2
        whole = own + other
        if not own * whole > 0:
            return None
        zero, loss = (own * w2 + other * w1) / whole, (own * c2 + other * c1) / whole
        if not (zero > 0 and loss > 0):
            return None
        stage = w1 * w2 / zero
        damping = (c1 * w2 + c2 * w1 - stage * loss) / zero
        share = (w1 + w2 + c1 * c2 - damping * loss - stage - zero) / zero
        if not (share > 0 and damping > 0):
            return None
        part = {"stiffness": there.mass * share * zero, "period": 2 * math.pi / zero**0.5, "quality": zero**0.5 / loss}
        return Linear(there.mass, stage**0.5, stage**0.5 / damping, there.mass * whole), part

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        x, speed = state.hidden
        omega = 2 * math.pi / self.period
        return -self.stiffness * (state.z - x + (state.v - speed) / (omega * self.quality))

    def state0(self) -> tuple[Scalar, ...]:
        return (0.0, 0.0)

    def swing(self) -> Scalar:
        return max(1.0, self.quality)

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        x, speed = state.hidden
        omega = 2 * math.pi / self.period
        return speed, omega**2 * (state.z - x) + omega / self.quality * (state.v - speed)
