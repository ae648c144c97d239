"""One vibration mode more in what the sensor sees, where there are 4 already."""

from .second_mode import SecondMode


class FifthMode(SecondMode):
    """A mode more beside the fourth one, of the same law: reading = z + … + a x₅.

    The modes of a linear structure superpose: none loads another, and which is called which means nothing.
    """

    name = "fifth-mode"
    equation = "reading = z + a x, ẍ + (ω₅/Q₅) ẋ + ω₅² x = ω₅² V, ω₅ = 2π/T₅"
    needs = "fourth-mode"
    mistaken_for = ()
    alike = ()
    further_mode = 5
