"""Fit a physical model to measured vibration records, and learn which effect is missing.

    import ident

    fit = ident.fit("data/platform_clean")
    print(fit["quality"].value, fit["quality"].error)

What the command line does is a function here, on files, DataFrames or arrays (see `read_campaign`): check, fit,
diagnose, add, remove, discover, sample, compare, attribute, simulate. Names are imported when they are first used, so
that `import ident` costs nothing.
"""

from __future__ import annotations

import difflib
import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import Oscillator as Oscillator
    from .campaign import Platform as Platform
    from .campaign import read_campaign as read_campaign
    from .campaign.trust import trust as trust
    from .diagnosis.diagnose import diagnose as diagnose
    from .diagnosis.diagnose import discover as discover
    from .diagnosis.judged import attribute as attribute
    from .diagnosis.judged import compare as compare
    from .diagnosis.judged import sample as sample
    from .diagnosis.search.change import add as add
    from .diagnosis.search.change import remove as remove
    from .effects import AbstractEffect as AbstractEffect
    from .effects import amplitude as amplitude
    from .effects import choice as choice
    from .effects import shape as shape
    from .errors import UserError as UserError
    from .fit import Fit as Fit
    from .fit.fit_data import fit_data as fit  # noqa: F401
    from .fit.profile import profile as profile
    from .fit.simulate import simulate as simulate
    from .model import build_model as build_model
    from .report.check import check as check
    from .report.run_folder import load_run as load_run
    from .report.run_folder import write_run as write_run

# name: (module, name there)
_STORY = {
    "read_campaign": ("campaign", "read_campaign"),
    "check": ("report.check", "check"),
    "fit": ("fit.fit_data", "fit_data"),
    "diagnose": ("diagnosis.diagnose", "diagnose"),
    "add": ("diagnosis.search.change", "add"),
    "remove": ("diagnosis.search.change", "remove"),
    "discover": ("diagnosis.diagnose", "discover"),
    "sample": ("diagnosis.judged", "sample"),
    "compare": ("diagnosis.judged", "compare"),
    "attribute": ("diagnosis.judged", "attribute"),
    "simulate": ("fit.simulate", "simulate"),
    "profile": ("fit.profile", "profile"),
    "write_run": ("report.run_folder", "write_run"),
    "load_run": ("report.run_folder", "load_run"),
    "Fit": ("fit", "Fit"),
    "Campaign": ("campaign", "Campaign"),
    "Platform": ("campaign", "Platform"),
    "Oscillator": ("campaign", "Oscillator"),
    "UserError": ("errors", "UserError"),
    "trust": ("campaign.trust", "trust"),
    "AbstractEffect": ("effects", "AbstractEffect"),
    "amplitude": ("effects", "amplitude"),
    "shape": ("effects", "shape"),
    "choice": ("effects", "choice"),
    "build_model": ("model", "build_model"),
}

__all__ = list(_STORY)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> Any:
    if name not in _STORY:
        near = difflib.get_close_matches(name, _STORY, 1, 0.6)
        raise AttributeError(f"module 'ident' has no attribute {name!r}" + (f": {near[0]!r}?" if near else ""))
    module, there = _STORY[name]
    return getattr(importlib.import_module(f".{module}", __name__), there)


def __dir__() -> list[str]:
    return sorted([*globals(), *_STORY])
