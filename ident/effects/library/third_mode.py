"""One vibration mode more in what the sensor sees, where there are 2 already."""

from .second_mode import SecondMode


class ThirdMode(SecondMode):
    """A mode more beside the second one, of the same law: reading = z + … + a x₃.

    The modes of a linear structure superpose: none loads another, and which is called which means nothing.
    """

    name = "third-mode"
    equation = "reading = z + a x, ẍ + (ω₃/Q₃) ẋ + ω₃² x = ω₃² V, ω₃ = 2π/T₃"
    needs = "second-mode"
    mistaken_for = ()
    alike = ()
    further_mode = 3
