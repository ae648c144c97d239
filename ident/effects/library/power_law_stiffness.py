"""A spring whose stiffness follows any power of the displacement."""

from ..effect import AbstractEffect, Drive, Scalar, State, amplitude, shape
from ..power import beyond_linear


class PowerLawStiffness(AbstractEffect):
    """A spring that hardens or softens by a power of the displacement: F = −k z (|z/z₀|ⁿ⁻¹ − 1)/(n − 1), n fitted.

    z₀ is the largest displacement measured; there the linear spring has its whole force, and k is how much the
    stiffness F/z grows with ln z. k > 0 hardens, k < 0 softens, whatever n. A law |z|ⁿ with no linear spring beside it
    is k = (n − 1) times the linear stiffness: contacts of round bodies have n = 3/2 (Hertz), of cones 2, rubber and
    wire ropes 0.7-1.3; n = 3 is a cubic spring, n → 1 the stiffness k ln z; the current of an iron core that
    saturates, over its flux, has 5-11. Below a hundred-thousandth of z₀ it is
    constant.
    """

    name = "power-law-stiffness"
    equation = "F = −k z (|z/z₀|ⁿ⁻¹ − 1)/(n − 1)"
    source = (
        "I. Kovacic, Nonlinear Oscillations: Exact Solutions and their Approximations, 2020, ch. 2; "
        "contacts: K. L. Johnson, Contact Mechanics, 1985, §4.2 and §5.2; "
        "iron cores: A. Ben-Tal, V. Kirk, G. Wake, 2001, IEEE Trans. Power Delivery 16, 105"
    )
    mistaken_for = ("end-stop",)
    contains = ("cubic-stiffness",)
    has_kink = True

    stiffness = amplitude("N/m", "growth of F/z with ln z at the reference displacement, k")
    # What stands in the middle of a grid is the value that is held where nobody fits it.
    exponent = shape("1", "power of the displacement, n", grid=(0.6, 4.5, 1.4, 2.0, 8.0), limits=(0.3, 12.0))
    displacement = shape("m", "reference displacement, z₀", grid=(1.0,), scale="displacement", fitted=False)

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return -self.stiffness * self.displacement * beyond_linear(state.z / self.displacement, self.exponent)
