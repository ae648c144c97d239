"""Whether what a campaign says about effects exists: names, words, parameters and priors, each error with its line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.device import Platform
from ..campaign.document import read_document
from ..effects.parameter import Choice
from ..effects.registry import Registry
from ..errors import UserError, nearest
from ..units import parse_quantity, to_si, unit
from .linear import MASS, linear_part
from .model import Model

LISTS = ("fixed", "free")
"""Settings that name parameters instead of giving them values."""


def place_of(campaign: Campaign, *keys: str) -> str:
    """File and line of a key of the campaign file, as far as they can be found."""
    if campaign.path is None or not campaign.path.is_file():
        return ""
    section = read_document(campaign.path, campaign.path.name)
    for key in keys[:-1]:
        values = section.values.get(key)
        if not isinstance(values, dict):
            return section.where(key)
        section = section.inside(key, values)
    return section.where(keys[-1])


def _one_of(name: str, names: Iterable[str]) -> str:
    names = sorted(names)
    return nearest(name, names, f"it has: {', '.join(names) or 'none'}")


def is_weighed(campaign: Campaign) -> bool:
    """Whether the fitted records of a platform have different loads, and so tell its mass."""
    loads = {record.load for record in (*campaign.fitted, *campaign.fitted_sweeps)}
    return isinstance(campaign.device, Platform) and len(loads) > 1


def as_weighed_by(campaign: Campaign, model: Model, values: np.ndarray) -> Model:
    """A model whose mass is known for records of a campaign that do not tell it: held at that of values (m,) SI."""
    if not model.weighed or is_weighed(campaign):
        return model
    name, start = model.parameters[MASS].name, dict(model.start)
    return replace(model, held=model.held | {name}, start=tuple({**start, name: float(values[MASS])}.items()))


def _linear_names(campaign: Campaign) -> tuple[str, tuple[str, ...]]:
    linear = linear_part(campaign.device)
    return linear.prefix, ("frequency", "quality", linear.gain_name, *(("mass",) if is_weighed(campaign) else ()))


def parameter_names(campaign: Campaign, known: Registry, owner: str) -> tuple[str, ...] | None:
    """Names of the parameters of an effect or of the linear part; None if there is no such thing."""
    prefix, linear = _linear_names(campaign)
    if owner == prefix:
        return linear
    return tuple(p.name for p in known[owner].parameters) if owner in known else None


def check_settings(campaign: Campaign, known: Registry) -> None:
    """Every `[effect.NAME]` names an effect or the linear part, and every key in it a choice, a parameter or a list."""
    prefix, _ = _linear_names(campaign)
    for owner, settings in campaign.settings.items():
        parameters = parameter_names(campaign, known, owner)
        if parameters is None:
            place = place_of(campaign, "effect", owner)
            raise UserError(f"there is no effect called {owner!r}", where=place, do=_one_of(owner, [*known, prefix]))
        choices = {} if owner == prefix else {c.name: c for c in known[owner].choices}
        for key, value in settings.items():
            try:
                _check_setting(owner, key, value, parameters, choices)
            except UserError as error:
                raise UserError(error.what, where=place_of(campaign, "effect", owner, key), do=error.do) from None
        both = set(listed(settings, "fixed")) & set(listed(settings, "free"))
        if both:
            what = f"[effect.{owner}]: {', '.join(sorted(both))} cannot be both fixed and free"
            raise UserError(what, where=place_of(campaign, "effect", owner, "free"), do="name it once")


def _check_setting(owner: str, key: str, value: Any, parameters: Sequence[str], choices: Mapping[str, Choice]) -> None:
    if key in choices:
        words = choices[key].words
        if value not in words:
            do = "write one of " + ", ".join(f'"{word}"' for word in words)
            raise UserError(f"[effect.{owner}] {key}: {value!r} is not known", do=do)
    elif key in LISTS:
        for name in listed({key: value}, key):
            if name not in parameters:
                what = f"[effect.{owner}] {key}: {owner} has no parameter {name!r}"
                raise UserError(what, do=_one_of(str(name), parameters))
    elif key not in parameters:
        near = _one_of(key, [*parameters, *choices, *LISTS])
        raise UserError(f"[effect.{owner}]: {owner} has no setting {key!r}", do=near)
    elif not isinstance(value, float) or isinstance(value, bool):
        do = 'write a number in SI units or a quantity ("80 MPa")'
        raise UserError(f"[effect.{owner}] {key}: {value!r} is not a number", do=do)


def listed(settings: Mapping[str, Any], key: str) -> tuple[str, ...]:
    """The names under `fixed` or `free`; a single word counts as a list of one."""
    value = settings.get(key, ())
    return value if isinstance(value, tuple) else (value,)


def check_priors(campaign: Campaign, known: Registry) -> None:
    """Every prior is on a parameter that exists, in the model or in an effect that may be added."""
    for full in campaign.priors:
        owner, _, name = full.rpartition(".")
        parameters = parameter_names(campaign, known, owner)
        if parameters is None or name not in parameters:
            prefix, linear = _linear_names(campaign)
            every = [f"{prefix}.{one}" for one in linear]
            every += [f"{effect.name}.{p.name}" for effect in known.values() for p in effect.parameters]
            do = nearest(full, every, 'write "effect.parameter"; `ident effects` lists them')
            raise UserError(
                f"[priors]: there is no parameter {full!r}", where=place_of(campaign, "priors", full), do=do
            )


def check_units(campaign: Campaign, known: Registry) -> None:
    """Quantities of settings and priors are of the kind of their parameter: no stress is given in nanometres.

    The file is read once more, because a campaign holds SI numbers only. An oscillator's units are its own.
    """
    told = campaign.settings or campaign.priors
    if not told or campaign.path is None or not isinstance(campaign.device, Platform):
        return
    document = read_document(campaign.path, campaign.path.name)
    parameters = {f"{effect.name}.{p.name}": p.unit for effect in known.values() for p in effect.parameters}
    linear = linear_part(campaign.device)
    units = {"frequency": "Hz", linear.gain_name: linear.gain_unit, "mass": "kg"}
    parameters |= {f"{linear.prefix}.{name}": unit for name, unit in units.items()}
    for owner, settings in campaign.settings.items():
        for key in settings:
            text, full = document.values["effect"][owner][key], f"{owner}.{key}"
            if isinstance(text, str) and full in parameters:
                parse_quantity(text, unit(parameters[full]).dimension, where=place_of(campaign, "effect", owner, key))
    for full in campaign.priors:
        name = _prior_table(document.values["priors"], full).get("unit")
        if name is not None and full in parameters:
            to_si(1.0, name, unit(parameters[full]).dimension, where=place_of(campaign, "priors", full))


def _prior_table(priors: Mapping[str, Any], full: str) -> Mapping[str, Any]:
    """The table of one prior, under its full name or nested as unquoted dots nest it."""
    owner, _, name = full.rpartition(".")
    return priors[full] if full in priors else priors[owner][name]


def check_starts(campaign: Campaign, model: Model) -> None:
    """What can only be judged with the model made: signs of starting values, and parameters without meaning."""
    told = dict(model.start)
    meaningless = {f"{effect.name}.{name}" for effect in model.effects for name in effect.unused()}
    for parameter in model.parameters:
        owner, _, name = parameter.name.rpartition(".")
        if parameter.name in model.freed & meaningless:
            what = f"[effect.{owner}] free: {name} has no meaning with the other settings"
            raise UserError(what, where=place_of(campaign, "effect", owner, "free"), do="take it off the list")
        if parameter.positive and parameter.fitted and told.get(parameter.name, 1.0) <= 0:
            what = f"[effect.{owner}] {name}: {told[parameter.name]:g} is not positive"
            raise UserError(what, where=place_of(campaign, "effect", owner, name), do="start from a positive value")
