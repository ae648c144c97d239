"""An actuator whose push changes with the travel."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..likeness import CUBIC_LOSS


class ForceFactor(AbstractEffect):
    """A push that changes with the travel, as of a coil that leaves its gap: F = G (β − 1) V − G B (β² − 1) ż.

    β = 1 + a z + b z² is the force per current (Bl of a loudspeaker, a shaker, a voice coil) in shares of that at rest.
    Under voltage the current is (V − B β ż)/R, with B the voltage that a velocity induces at rest, so that the damping
    by the coil changes with β²; under current B is next to nothing, and a alone is voltage-stiffness. Typical: b < 0,
    and at the rated travel a loudspeaker has 70 to 80 % of β. The response to a sine has a third harmonic, and the
    resonance keeps its place. a, which refines the law, is 0 where the coil rests in the middle of its gap.
    """

    name = "force-factor"
    equation = "F = G (β − 1) V − G B (β² − 1) ż, β = 1 + a z + b z²"
    source = (
        "W. Klippel, Loudspeaker nonlinearities: causes, parameters, symptoms, 2006, J. Audio Eng. Soc. 54, 907, §3.2; "
        "A. J. M. Kaizer, Modeling of the nonlinear response of an electrodynamic loudspeaker by a Volterra series "
        "expansion, 1987, J. Audio Eng. Soc. 35, 421"
    )
    mistaken_for = ("cubic-damping", "voltage-stiffness")
    alike = (CUBIC_LOSS,)

    bend = amplitude("1/m^2", "relative change of the push per squared displacement, b")
    # Where 1 is all of the damping at the resonance, as far as the records reach it.
    induced = shape("V*s/m", "voltage that a velocity induces at rest, B", grid=(0.1, 0.4, 1.0), scale="induction",
                    limits=(0.003, 1.5))  # fmt: skip
    tilt = amplitude("1/m", "relative change of the push with the displacement, a", refines=True)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        more = (self.tilt + self.bend * state.z) * state.z
        return drive.gain * more * (drive.V - self.induced * (2.0 + more) * state.v)
