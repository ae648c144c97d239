"""A mass that two loads weigh is a direction of the scores, and records of one load are judged at the fitted one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ident.diagnosis.linearised.regression import prepare
from ident.fit import fit
from ident.model import as_weighed_by, build_model
from tests.fit.test_mass import campaign


def test_the_column_of_the_mass_has_its_inertia() -> None:
    there = campaign()
    found = fit(build_model(there), there)
    known = prepare(found).known
    sizes = np.linalg.svd(known / np.linalg.norm(known, axis=1, keepdims=True), compute_uv=False)
    assert sizes[-1] > 0.05  # without it the mass is what stiffness and damping are together


def test_records_of_one_load_take_the_mass_as_known() -> None:
    there = campaign()
    found = fit(build_model(there), there)
    only = replace(there, records=there.records[:1])
    alone = as_weighed_by(only, found.model, found.values)
    (mass,) = [p for p in alone.parameters if p.name == "platform.mass"]
    assert not mass.fitted and mass.value == found["mass"].value
    assert as_weighed_by(there, found.model, found.values) is found.model
    assert not fit(alone, only)["frequency"].flags
