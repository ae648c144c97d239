"""From what a campaign says about its model to the model: effects by name, their settings and starting values."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from ..campaign.campaign import Campaign
from ..effects.effect import AbstractEffect
from ..effects.registry import Registry, find, registry
from ..errors import UserError
from .model import Model
from .settings import (
    LISTS,
    check_priors,
    check_settings,
    check_starts,
    check_units,
    is_weighed,
    listed,
    parameter_names,
    place_of,
)


def build_model(campaign: Campaign, effects: Sequence[str] | None = None) -> Model:
    """The model with which a campaign is to be fitted.

    Every `[effect.NAME]` of the campaign counts, also of an effect that is not in the model yet: its starting values
    and its `fixed` and `free` parameters wait in the model, its words in `make_effect`.

    **Arguments:** `effects`: names of the effects, instead of those of the campaign; () is the plain linear part.

    **Raises:** UserError, naming the line, for an effect, a setting or a prior that does not exist.
    """
    known = registry(campaign.effect_files)
    names = campaign.effects if effects is None else tuple(effects)
    where = place_of(campaign, "model", "effects") if effects is None else ""
    check_settings(campaign, known)
    check_priors(campaign, known)
    check_units(campaign, known)
    try:
        model = Model(campaign.device)
        for name in _needed_first(names, known):
            model = model + make_effect(campaign, name, known)
        order = {name: position for position, name in enumerate(names)}
        model = replace(model, effects=tuple(sorted(model.effects, key=lambda effect: order[effect.name])))
    except UserError as error:
        raise UserError(error.what, where=error.where or where, do=error.do) from None
    start, held, freed = told_of(campaign, known)
    model = replace(model, start=start, held=held, freed=freed, weighed=is_weighed(campaign))
    check_starts(campaign, model)
    return model


def make_effect(
    campaign: Campaign, name: str, known: Registry | None = None, words: Mapping[str, str] | None = None
) -> AbstractEffect:
    """One effect as a campaign wants it: with the words of `[effect.NAME]`, ready for `model + effect`.

    **Arguments:** `known`: the effects to choose from; if not given, the library and the campaign's own files; `words`
    of choices that the campaign leaves open (see `open_words`).
    """
    effect = find(name, registry(campaign.effect_files) if known is None else known)
    return effect(campaign.device, {**(words or {}), **_told_words(campaign, effect)})


def open_words(campaign: Campaign, effect: type[AbstractEffect]) -> list[dict[str, str]]:
    """Every combination of words of those choices of an effect that neither the campaign nor its records decide; the
    defaults first."""
    told = _told_words(campaign, effect)
    undecided = [choice for choice in effect.choices if choice.name not in told]
    names = [choice.name for choice in undecided]
    return [dict(zip(names, words, strict=True)) for words in itertools.product(*(c.words for c in undecided))]


def _told_words(campaign: Campaign, effect: type[AbstractEffect]) -> dict[str, str]:
    choices = {choice.name for choice in effect.choices}
    told = {**effect.told_by(campaign.fitted), **campaign.settings.get(effect.name, {})}
    return {key: value for key, value in told.items() if key in choices}


def _needed_first(names: Iterable[str], known: Registry) -> list[str]:
    """The names in an order in which every effect follows the one that it builds on."""

    def depth(name: str) -> int:
        needs = find(name, known).needs
        return 1 + depth(needs) if needs else 0

    return sorted(names, key=depth)


def told_of(
    campaign: Campaign, known: Registry
) -> tuple[tuple[tuple[str, float], ...], frozenset[str], frozenset[str]]:
    """Starting values, held and freed parameters by full name, of all settings."""
    start: list[tuple[str, float]] = []
    named: dict[str, list[str]] = {key: [] for key in LISTS}
    for owner, settings in campaign.settings.items():
        parameters = parameter_names(campaign, known, owner) or ()
        start += [(f"{owner}.{key}", float(value)) for key, value in settings.items() if key in parameters]
        for key in LISTS:
            named[key] += [f"{owner}.{name}" for name in listed(settings, key)]
    return tuple(start), frozenset(named["fixed"]), frozenset(named["free"])
