"""One vibration mode more in what the sensor sees, where there are 3 already."""

from .second_mode import SecondMode


class FourthMode(SecondMode):
    """A mode more beside the third one, of the same law: reading = z + … + a x₄.

    The modes of a linear structure superpose: none loads another, and which is called which means nothing.
    """

    name = "fourth-mode"
    equation = "reading = z + a x, ẍ + (ω₄/Q₄) ẋ + ω₄² x = ω₄² V, ω₄ = 2π/T₄"
    needs = "third-mode"
    mistaken_for = ()
    alike = ()
    further_mode = 4
