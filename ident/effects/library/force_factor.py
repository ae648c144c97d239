"""An actuator that pushes less as the stage leaves the place for which it is made."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CUBIC_LOSS, SECOND_ORDER


class ForceFactor(AbstractEffect):
    """A push that depends on the place, as of a coil that leaves its gap: F = G (β − 1) V − G B (β² − 1) ż.

    β = 1 + b₁ z + b₂ z² is the force per current (Bl of a loudspeaker, a shaker, a voice coil), in shares of that at
    rest. Under voltage the current is (V − B β ż)/R, with B the voltage that a velocity induces at rest, so that the
    damping by the coil changes with β²; under current B is next to nothing. b₁ z is a coil off the middle of its gap;
    b₂ < 0: at its travel a loudspeaker has lost half of β. A drive at ω moves force to 0 and 2ω, and b₂ bends the
    resonance's height, not its place.
    """

    name = "force-factor"
    equation = "F = G (β − 1) V − G B (β² − 1) ż, β = 1 + b1 z + b2 z²"
    source = (
        "W. Klippel, Loudspeaker nonlinearities: causes, parameters, symptoms, 2006, J. Audio Eng. Soc. 54, 907, §3.2; "
        "A. J. M. Kaizer, Modeling of the nonlinear response of an electrodynamic loudspeaker by a Volterra series "
        "expansion, 1987, J. Audio Eng. Soc. 35, 421"
    )
    mistaken_for = ("voltage-stiffness", "cubic-damping")
    alike = (SECOND_ORDER, CUBIC_LOSS)
    contains = ("voltage-stiffness",)

    b1 = amplitude("1/m", "relative change of the push per displacement, b₁")
    b2 = amplitude("1/m^2", "relative change of the push per squared displacement, b₂")
    induced = shape("V*s/m", "voltage that a velocity induces at rest, B", grid=(0.1, 0.4, 1.0), scale="induction",
                    limits=(0.003, 5.0))  # fmt: skip

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        more = (self.b1 + self.b2 * state.z) * state.z
        return drive.gain * more * (drive.V - self.induced * (2.0 + more) * state.v)
