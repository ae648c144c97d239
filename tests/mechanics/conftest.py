"""The device whose reference numbers were computed in 30-digit arithmetic by an independent route."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pytest

from ident.mechanics import Beam, InitialShape, Section, initial_shape, l_beam, residual_moment, section


class Nominal(NamedTuple):
    """Section, lengths (m), stresses (Pa: σ12, σ23, σ2 of (90, 20, −10) MPa), stiffness constants, initial shape."""

    section: Section
    length_1: float
    length_2: float
    stresses: tuple[float, float, float]
    beam: Beam
    shape: InitialShape


def nominal() -> Nominal:
    """The nominal device at σ = (90, 20, −10) MPa."""
    layers = section(
        silicon_modulus=169e9,
        silicon_poisson=0.22,
        pzt_modulus=63e9,
        pzt_poisson=0.30,
        silicon_thickness=30e-6,
        pzt_thickness=17e-6,
        width=1e-3,
    )
    l1, l2 = 2.4e-3, 2.8e-3
    stresses = (70e6, 30e6, 20e6)
    shape = initial_shape(layers, l1, l2, residual_moment(layers, *stresses))
    return Nominal(layers, l1, l2, stresses, l_beam(layers, l1, l2), shape)


@pytest.fixture(scope="session")
def device() -> Nominal:
    """The nominal device."""
    return nominal()


@pytest.fixture(scope="session")
def finite_elements() -> pd.DataFrame:
    """Force-displacement curves of one L beam from geometrically exact beam elements."""
    return pd.read_csv(Path(__file__).parents[2] / "data" / "fe_beam" / "force_displacement.csv")
