"""One vibration mode more in what the sensor sees, where there are 5 already."""

from .second_mode import SecondMode


class SixthMode(SecondMode):
    """A mode more beside the fifth one, of the same law: reading = z + … + a x₆.

    The modes of a linear structure superpose: none loads another, and which is called which means nothing.
    """

    name = "sixth-mode"
    equation = "reading = z + a x, ẍ + (ω₆/Q₆) ẋ + ω₆² x = ω₆² V, ω₆ = 2π/T₆"
    needs = "fifth-mode"
    mistaken_for = ()
    alike = ()
    further_mode = 6
