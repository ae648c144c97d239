"""The figure of the closures shows the numbers that it claims."""

from __future__ import annotations

from experiments.closures import closures


def test_the_closures_miss_the_finite_elements_as_stated():
    closures.check(closures.study())


def test_the_figure_is_drawn(tmp_path):
    closures.draw(closures.EXPECTED, tmp_path / "closures.png")
    assert (tmp_path / "closures.png").stat().st_size > 10_000
