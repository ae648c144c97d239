"""Whether the records see an effect that a model lacks: then none of its intervals is final, small as its residual is.

An omnibus test of what a model leaves spreads its power over every way in which noise could not be noise. The score
test asks each effect of the library alone, and so sees one long before the size of what is left does. What even it does
not see may still be there: an interval holds only as far as the model is the device.

Source: as in `score`.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..effects.effect import AbstractEffect
from ..fit import Fit
from ..pulse import Report
from .bench import prepare
from .score import score, significant
from .shorten import working


def missing(fit: Fit, library: Mapping[str, type[AbstractEffect]], report: Report = lambda _: None) -> tuple[str, ...]:
    """Why the model is not the whole device, in words; none if the records see no effect of the library in what it
    leaves."""
    seen = significant(score(prepare(working(fit)), library, report))
    if not seen:
        return ()
    best = min(seen, key=lambda candidate: candidate.p_value)
    others = f", as {len(seen) - 1} more would" if len(seen) > 1 else ""
    by_chance = "less than 1e-16" if best.p_value < 1e-16 else f"{best.p_value:.1g}"
    return (
        f"an effect is missing: {best.name} would explain part of what the model leaves{others} (probability by chance "
        f"{by_chance}); ask `ident diagnose`",
    )
