"""The paper's figures: each statement holds, and each picture is drawn."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from experiments.paper import finite_elements, sheet
from ident.report.figures.style import png

QUICK = ("fig08", "fig09", "fig10", "fig13", "slips")
LONG = ("fig03", "fig11", "fig12", "closures")


@pytest.mark.parametrize("name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in LONG)])
def test_a_figure_shows_what_the_paper_states(name):
    script = importlib.import_module(f"experiments.paper.{name}")
    found = script.study()
    assert script.check(found)
    assert len(png(script.draw(found))) > 10_000


def test_a_page_shows_every_figure():
    page = (sheet.FOLDER.parents[1] / "paper.md").read_text(encoding="utf-8")
    for name in (*QUICK, *LONG):
        assert f"figures/paper/{name}.png" in page
        assert (sheet.FOLDER / f"{name}.png").is_file()


@pytest.mark.slow
def test_the_finite_elements_are_those_of_the_data():
    deviation, curve = finite_elements.check(1.0)
    assert deviation < 0.003
    assert abs(curve.rise - 2.715e-6) < 2e-8  # docs/physics.md, "yaw"
    assert np.all(np.diff(curve.force) > 0)
