"""The model with which a campaign starts: its effects, on the linear model that its records ask for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from ...campaign.campaign import Campaign
from ...campaign.device import Oscillator
from ...effects.linear_side import MODE, constant_on, further_modes
from ...effects.registry import registry
from ...errors import UserError
from ...model import Model, build_model, make_effect
from ...pulse import Report
from .choice import LinearChoice, choose_linear, side_of_constant

_ENOUGH = 100_000  # samples that compare linear models: of many records a part tells it, and the fit then sees all


@lru_cache(maxsize=8)
def linear_choice(campaign: Campaign) -> LinearChoice | None:
    """How the linear candidates compare on the fitted records of a campaign; None for a platform, whose linear part is
    known, and where there is nothing to fit."""
    if not isinstance(campaign.device, Oscillator) or not campaign.fitted:
        return None
    records = campaign.fitted
    every = math.ceil(sum(len(record.time) for record in records) / _ENOUGH)
    told = 1 if _names_a_mode(campaign) else campaign.modes
    try:
        return choose_linear(records[::every], campaign.linear, modes=told, base=not campaign.sweeps)
    except UserError as error:
        raise UserError(error.what, where=_place(campaign), do=error.do) from None


def modes_of(campaign: Campaign) -> tuple[str, ...]:
    """The effects that the further modes of an oscillator are, the second mode first."""
    return further_modes(registry(campaign.effect_files))


def _names_a_mode(campaign: Campaign) -> bool:
    known = registry(campaign.effect_files) if campaign.effects else {}
    return any(known[name].further_mode for name in campaign.effects if name in known)


def with_drives(campaign: Campaign) -> Campaign:
    """The campaign with its drives between the samples as its records choose them, where it does not say what they are
    there: smooth curves, or held values (`Trace.edge`)."""
    free = [r for r in campaign.traces if r.between == "auto" and r.driven]
    choice = linear_choice(campaign) if free else None
    if choice is None or all(r.edge == choice.chosen.edges.of(r.drive) for r in free):
        return campaign
    records = (replace(r, edge=choice.chosen.edges.of(r.drive)) if r in free else r for r in campaign.records)
    return replace(campaign, records=tuple(records))


def _place(campaign: Campaign) -> str:
    """Where a campaign says what its linear model is."""
    return f"{campaign.path}, [model]" if campaign.path else ""


def start_model(campaign: Campaign, effects: Sequence[str] | None = None, report: Report = lambda _: None) -> Model:
    """The model of `build_model`, on the linear form that the records choose, with the constant that they need and the
    starting values found on the way. What the campaign says of the linear part is left as it is said.

    **Arguments:** as of `build_model`; `report`: called with progress in words.
    """
    model = build_model(campaign, effects)
    if isinstance(campaign.device, Oscillator) and campaign.fitted:
        report("comparing linear models")
    choice = linear_choice(campaign)
    if choice is None:
        if campaign.linear not in ("auto", "oscillator"):
            raise UserError(f'linear = "{campaign.linear}", but the linear part of a platform is an oscillator',
                            where=_place(campaign),
                            do='remove it, or write device = { kind = "oscillator" }')  # fmt: skip
        if campaign.modes is not None and campaign.modes > 1:
            what = f"modes = {campaign.modes} needs time records with their drive"
            raise UserError(what, where=_place(campaign), do="remove it")
        return model
    chosen = choice.chosen
    model = replace(model, form=chosen.form)
    first, second, gain = (p.name for p in model.parameters[:3])
    found = [(first, chosen.first), (second, chosen.second)]
    found += [(gain, chosen.gain * model.linear.mass / model.linear.force_per_gain)] if chosen.gain else []
    known = registry(campaign.effect_files)
    constant = constant_on(side_of_constant(chosen.form), known)
    if chosen.level and constant and not any(effect.is_constant for effect in model.effects):
        model = model + make_effect(campaign, constant.name, known)
        found.append((model.parameters[-1].name, chosen.constant))
    if not any(effect.further_mode for effect in model.effects):
        for name, mode in zip(further_modes(known), chosen.further, strict=False):
            model = model + make_effect(campaign, name, known)
            travel = mode.gain / (2 * math.pi * mode.frequency) ** 2
            values = zip(MODE, (travel, 1 / mode.frequency, mode.quality), strict=True)
            found += [(f"{name}.{key}", value) for key, value in values]
    told = {name for name, _ in model.start}
    return replace(model, start=(*model.start, *((name, value) for name, value in found if name not in told)))
