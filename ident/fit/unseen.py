"""What the sensor does that no curve shows: it is held.

A part of a characteristic that reads alike on both sides of zero makes a mean and even overtones of a motion that is
nearly a sine, and no fundamental. Its slope in a fit to curves is the error of the solver, which would lead it away.
"""

from __future__ import annotations

from dataclasses import replace

from ..campaign.campaign import Campaign
from ..effects.dependence import depends_on
from ..effects.effect import AbstractEffect, Drive, State
from ..model import Model

_ASIDE = 1e-6  # m: a law that is even anywhere is so here


def hold_unseen(model: Model, campaign: Campaign) -> Model:
    """The model with even parts of bent characteristics held where they are, if curves alone are fitted."""
    if campaign.fitted or any(one.order % 2 == 0 for sweep in campaign.fitted_sweeps for one in sweep.overtones):
        return model
    names = {f"{effect.name}.{name}" for effect in model.effects for name in _even_parts(effect)}
    return replace(model, held=model.held | names) if names else model


def _even_parts(effect: AbstractEffect) -> list[str]:
    """Amplitudes of an effect with which its sensor reads the same of z and −z."""
    if depends_on(effect) != ("sensor", ("z",)):
        return []
    amplitudes = [p.name for p in effect.declared() if p.kind == "amplitude"]
    found = []
    for name in amplitudes:
        alone = effect.with_values(**{other: float(other == name) for other in amplitudes})
        above, below = (float(alone.sensor(State(z, 0.0), Drive(0.0, 0.0, 1.0, 1.0), 0.0)) for z in (_ASIDE, -_ASIDE))
        if above == below:
            found.append(name)
    return found
