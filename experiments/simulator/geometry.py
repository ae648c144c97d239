"""The nominal device reduced to the constants that the equation of motion needs.

Everything is derived here by a route of its own (strip integrals, a minimised in-plane energy), so that an error in the
tool's formulas cannot hide in the data that it is judged on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Geometry:
    """Dimensions (m), elastic constants (Pa) and stage mass (kg) of the nominal platform."""

    silicon_modulus: float = 169e9
    silicon_poisson: float = 0.22
    pzt_modulus: float = 63e9
    pzt_poisson: float = 0.30
    silicon_thickness: float = 30e-6
    pzt_thickness: float = 17e-6
    width: float = 1.0e-3
    length_1: float = 2.4e-3
    length_2: float = 2.8e-3
    stage_mass: float = 60e-6

    def _layers(self) -> tuple[tuple[float, float, float], ...]:
        top = self.silicon_thickness + self.pzt_thickness
        return (
            (0.0, self.silicon_thickness, self.silicon_modulus),
            (self.silicon_thickness, top, self.pzt_modulus),
        )

    @property
    def neutral_axis(self) -> float:
        """Height of the neutral axis, m: ∫E z dz / ∫E dz."""
        first = sum(e * (b**2 - a**2) / 2 for a, b, e in self._layers())
        return first / sum(e * (b - a) for a, b, e in self._layers())

    @property
    def bending(self) -> float:
        """EI about the neutral axis, N·m²: b ∫E (z − z_n)² dz."""
        n = self.neutral_axis
        return self.width * sum(e * ((b - n) ** 3 - (a - n) ** 3) / 3 for a, b, e in self._layers())

    @property
    def axial(self) -> float:
        """EA, N."""
        return self.width * sum(e * (b - a) for a, b, e in self._layers())

    @property
    def twisting(self) -> float:
        """GJ of the solid rectangle with the thickness-weighted mean shear modulus, N·m²."""
        h = self.silicon_thickness + self.pzt_thickness
        shear = (
            self.silicon_thickness * self.silicon_modulus / (1 + self.silicon_poisson)
            + self.pzt_thickness * self.pzt_modulus / (1 + self.pzt_poisson)
        ) / (2 * h)
        odd = np.arange(1, 400, 2)
        series = np.sum(np.tanh(odd * np.pi * self.width / (2 * h)) / odd**5)
        return shear * self.width * h**3 / 3 * (1 - 192 / np.pi**5 * h / self.width * series)

    @property
    def corner_ratios(self) -> tuple[float, float]:
        """EI/(k_r l) of the segments; each segment's end turns against the twist of the other."""
        ratio = self.bending / self.twisting
        return ratio * self.length_2 / self.length_1, ratio * self.length_1 / self.length_2

    @property
    def segment_stiffness(self) -> tuple[float, float]:
        """Stiffness of each segment without axial force, N/m."""
        (r1, r2), ei = self.corner_ratios, self.bending
        return (
            12 * ei / self.length_1**3 * (1 + r1) / (1 + 4 * r1),
            12 * ei / self.length_2**3 * (1 + r2) / (1 + 4 * r2),
        )

    @property
    def shares(self) -> tuple[float, float]:
        """Share of the stage displacement taken by each segment."""
        k1, k2 = self.segment_stiffness
        return k2 / (k1 + k2), k1 / (k1 + k2)

    @property
    def stage_stiffness(self) -> float:
        """Stiffness of the stage on four beams without axial force, N/m."""
        k1, k2 = self.segment_stiffness
        return 4 * k1 * k2 / (k1 + k2)

    @property
    def drive_gain(self) -> float:
        """K_f, force on the stage per unit of piezoelectric strain, N."""
        arm = self.silicon_thickness + self.pzt_thickness / 2 - self.neutral_axis
        curvature = self.pzt_modulus * self.width * self.pzt_thickness * arm / self.bending
        return self.stage_stiffness * curvature * (self.length_1**2 + self.length_2**2) / 4

    def residual_moment(self, stress_1: float, stress_2: float, stress_3: float) -> float:
        """Moment about the neutral axis of a piecewise linear stress (top, interface, bottom), N·m."""
        n, interface = self.neutral_axis, self.silicon_thickness
        top = interface + self.pzt_thickness
        nodes, weights = np.polynomial.legendre.leggauss(4)
        moment = 0.0
        for a, b, sa, sb in ((0.0, interface, stress_3, stress_2), (interface, top, stress_2, stress_1)):
            z = (a + b) / 2 + (b - a) / 2 * nodes
            stress = sa + (sb - sa) * (z - a) / (b - a)
            moment += float(np.sum(weights * stress * (z - n))) * (b - a) / 2
        return self.width * moment

    def initial_shape(self, moment: float) -> tuple[float, float]:
        """Rise of segment 1 and of segment 2 under a residual moment, m."""
        (r1, r2), curvature = self.corner_ratios, moment / self.bending
        return (
            -curvature * self.length_1**2 / 2 * r1 / (1 + r1),
            curvature * self.length_2**2 / 2 * r2 / (1 + r2),
        )

    def frame_stiffness(self) -> np.ndarray:
        """Axial force of each segment per unit shortening of each, (2, 2) N/m.

        The L is clamped at the substrate and at the stage; the corner (u_x, u_y, θ) takes the position of least
        in-plane energy. Segment 2 lies along x, segment 1 along y.
        """
        ea, eiz, l1, l2 = self.axial, self.axial * self.width**2 / 12, self.length_1, self.length_2
        stretch = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])  # elongation of segments 1, 2 from (u_x, u_y, θ)
        stiff = np.diag([ea / l1, ea / l2])

        def bend(length: float, sign: float) -> np.ndarray:
            return eiz / length**3 * np.array([[12, sign * 6 * length], [sign * 6 * length, 4 * length**2]])

        hessian = stretch.T @ stiff @ stretch
        hessian[np.ix_([1, 2], [1, 2])] += bend(l2, -1)
        hessian[np.ix_([0, 2], [0, 2])] += bend(l1, -1)  # its slope is −θ
        corner = -np.linalg.solve(hessian, stretch.T @ stiff)
        return stiff @ (stretch @ corner + np.eye(2))
