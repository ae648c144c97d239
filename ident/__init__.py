"""Fit a physical model to measured vibration records, and learn which effect is missing.

    import ident

    campaign = ident.read_campaign("data/platform_clean")
    fit = ident.fit_model(ident.build_model(campaign), campaign)
    ident.write_run(fit, "runs/first")

Names are imported when they are first used, so that `import ident` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import Oscillator as Oscillator
    from .campaign import Platform as Platform
    from .campaign import Sweep as Sweep
    from .campaign import Trace as Trace
    from .campaign import read_campaign as read_campaign
    from .campaign.trust import trust as trust
    from .effects import AbstractEffect as AbstractEffect
    from .effects import amplitude as amplitude
    from .effects import choice as choice
    from .effects import shape as shape
    from .effects.registry import registry as registry
    from .errors import UserError as UserError
    from .fit import Fit as Fit
    from .fit.fit import fit as fit_model  # noqa: F401
    from .fit.profile import profile as profile
    from .fit.start_model import start_model as start_model
    from .model import Model as Model
    from .model import build_model as build_model
    from .model import make_effect as make_effect
    from .report.run_folder import load_run as load_run
    from .report.run_folder import write_run as write_run

# name: (module, name there). `fit` is the package, so the function has a name of its own here.
_STORY = {
    "UserError": ("errors", "UserError"),
    "read_campaign": ("campaign", "read_campaign"),
    "Campaign": ("campaign", "Campaign"),
    "trust": ("campaign.trust", "trust"),
    "Trace": ("campaign", "Trace"),
    "Sweep": ("campaign", "Sweep"),
    "Platform": ("campaign", "Platform"),
    "Oscillator": ("campaign", "Oscillator"),
    "AbstractEffect": ("effects", "AbstractEffect"),
    "amplitude": ("effects", "amplitude"),
    "shape": ("effects", "shape"),
    "choice": ("effects", "choice"),
    "registry": ("effects.registry", "registry"),
    "Model": ("model", "Model"),
    "build_model": ("model", "build_model"),
    "make_effect": ("model", "make_effect"),
    "fit_model": ("fit.fit", "fit"),
    "Fit": ("fit", "Fit"),
    "profile": ("fit.profile", "profile"),
    "start_model": ("fit.start_model", "start_model"),
    "write_run": ("report.run_folder", "write_run"),
    "load_run": ("report.run_folder", "load_run"),
}

__all__ = list(_STORY)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _STORY:
        raise AttributeError(f"module 'ident' has no attribute {name!r}")
    module, there = _STORY[name]
    return getattr(importlib.import_module(f".{module}", __name__), there)


def __dir__() -> list[str]:
    return sorted([*globals(), *_STORY])
