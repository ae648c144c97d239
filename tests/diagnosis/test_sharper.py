"""Noise floors that the last model of a walk tells better: when is the walk gone again?"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.diagnosis.search import conclude


@pytest.mark.parametrize(
    ("errors", "raised", "again"),
    [
        ((3.0, 5.0), (3.0, 1.0), True),  # what the first record leaves is the hum
        ((7.5, 7.5), (1.1, 1.0), False),  # the model lacks something else
        ((3.0, 3.0), (0.5, 0.5), False),  # lower floors say nothing new to it
    ],
)
def test_for_floors_that_are_most_of_what_is_left(
    monkeypatch: pytest.MonkeyPatch, errors: tuple[float, ...], raised: tuple[float, ...], again: bool
) -> None:
    trace = lambda sigma: SimpleNamespace(noise=SimpleNamespace(sigma=sigma))
    final = SimpleNamespace(
        trace_scores=[SimpleNamespace(error_over_noise=error) for error in errors],
        campaign=SimpleNamespace(traces=[trace(1.0)] * 2),
    )
    other = SimpleNamespace(traces=[trace(sigma) for sigma in raised])
    monkeypatch.setattr(conclude, "sharpened", lambda _: other)
    monkeypatch.setattr(conclude, "adequate", lambda _: False)
    told = conclude._sharper(cast(Any, final), cast(Any, None))
    assert (told is other) == again and (again or told is None)
