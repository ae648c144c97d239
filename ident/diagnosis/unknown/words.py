"""An unknown effect in sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...effects.dependence import Side
from ...fit.judge import GOOD

if TYPE_CHECKING:
    from .find import Unknown
    from .products import Product

_NAMES = {"z": "the displacement z", "v": "the velocity v", "V": "the drive V",
          "dV": "the rate of the drive (dV = V̇/ω)", "t": "the time t"}  # fmt: skip
_SIDES = {"force": "a force on the stage", "drive": "a force through the drive", "sensor": "an error of the sensor"}
_FOLLOWED = 0.97  # error over noise below which functions of the measured motion must have followed its noise


def what(side: Side, coordinates: tuple[str, ...], product: Product | None = None) -> str:
    """ "a force on the stage that depends on the displacement z"."""
    if product is not None:
        return f"{_SIDES[side]} that is {product.name} times a function of {_NAMES[product.of]}"
    if coordinates == ("1",):
        return f"{_SIDES[side]} that is constant"
    names = [_NAMES[name] for name in coordinates if name != "history"]
    words = " and ".join(names)
    if "history" in coordinates:
        words += " and on what came before of it"
    return f"{_SIDES[side]} that depends on {words}"


def describe(found: Unknown) -> tuple[str, ...]:
    """What was found, how sure it is, and what it could be instead."""
    before, after = np.sqrt(found.chi2_before), np.sqrt(found.chi2_after)
    text = f"What the model lacks acts like {what(found.side, found.coordinates, found.product)}: that explains"
    left = f"{after:.2f}" if after > _FOLLOWED else f"the noise floor (to {after:.2f}: some noise is followed too)"
    sentences = [
        f"{text} {percent(found.share)} of the error above the noise, and error/noise falls from {before:.2f} to "
        f"{left}."
    ]
    if found.p_value > 1e-3:
        sentences.append(
            f"Noise of the colour seen here would do as much by chance with probability {found.p_value:.2g}: there may "
            "be nothing missing at all."
        )
    elif after > GOOD:
        sentences.append(
            f"Along the measured motion it leaves an error of {after:.2f} noise floors; noise moves that motion, so "
            "that only a simulation tells whether more is missing."
        )
    if found.alike:
        listed = "; ".join(what(r.side, r.coordinates, r.product) for r in found.alike)
        sentences.append(f"These records cannot tell it from: {listed}.")
    if found.others:
        best = found.others[0]
        words = what(best.side, best.coordinates, best.product)
        sentences.append(f"The best of the others, {words}, explains {percent(best.share)}.")
    sentences += _formula(found)
    return tuple(sentences)


def noise_followed(kept: float) -> str:
    """What it means that an estimated law explains nothing once it is simulated."""
    return (
        f"Simulated, it lowers the error by {percent(kept)} only: it follows what was measured, noise included, and is "
        "no law. Slow noise may be more than its floor says: record some periods at rest, or one drive twice."
    )


def _formula(found: Unknown) -> list[str]:
    if found.formula is None or found.written is None:
        return ["No simple term describes it."]
    share = percent(found.explained(found.formula))
    if found.formula.complete:
        lead = "As a table" if found.formula.tabled else "In a formula"
        return [f"{lead} (SI): {found.formula.text}, which explains {share}."]
    longer = percent(found.explained(found.written))
    terms = len(found.written.terms)
    return [f"No short formula says as much: {found.formula.text} explains {share}, {terms} terms {longer}."]


def percent(share: float) -> str:
    """A share as people read it."""
    share = min(max(share, 0.0), 1.0)
    return f"{100 * share:.1f} %" if share > 0.9 else f"{100 * share:.0f} %"
