"""Whether a class says what an effect needs to say, before it is run: a law, an amplitude, the names and arguments that
the simulation will call. What is misspelt would otherwise be a method that nobody calls, and the effect no effect."""

from __future__ import annotations

import difflib
import inspect
from types import FunctionType

from ..errors import UserError
from .effect import AbstractEffect
from .likeness import Likeness
from .linear_side import MODE
from .mistakes import place_of_method

LAWS = ("force", "drive", "sensor")
"""Where an effect can act; one of them it must."""
HOOKS = (*LAWS, "inertia", "rate", "follow", "state0", "begun", "settled", "prepare", "can_be")
_CLOSE = 0.75  # of `difflib`: a letter too many, too few or exchanged, or another case


def check_written(effect: type[AbstractEffect]) -> None:
    """**Raises:** UserError if no law or no amplitude is declared, a method is called almost as one that is run, or has
    other arguments than it is given."""
    own = _own_methods(effect)
    called = {name for function in own.values() for name in function.__code__.co_names}
    for name in own:
        near = _nearest_hook(name)
        # A method that the others call is a helper, whatever its name.
        if near and name not in called and not effect.overrides(near):
            listed = "" if _acts(effect) else f": it defines none of {', '.join(LAWS)}"
            what = f"{effect.__name__} defines {name}, which nothing calls{listed}"
            raise UserError(what, where=place_of_method(effect, name), do=f"did you mean {near}?")
    if not _acts(effect):
        what = f"{effect.__name__} defines none of {', '.join(LAWS)}, so it does nothing"
        raise UserError(what, do="write the one that says where it acts, as in `def force(self, state, drive, t):`")
    if effect.overrides("inertia") and not effect.overrides("force"):
        what = f"{effect.__name__} has an inertia and no force, but a mass that changes has one"
        do = "write `def force(self, state, drive, t):` and return −m'(z) v²/2 of the mass m(z) that inertia returns"
        raise UserError(what, where=place_of_method(effect, "inertia"), do=do)
    for name in HOOKS:
        if effect.overrides(name):
            _check_arguments(effect, name)
    if effect.overrides("state0") and not (effect.overrides("rate") or effect.overrides("follow")):
        what = f"{effect.__name__} has hidden states and neither rate nor follow, so they never change"
        raise UserError(what, where=place_of_method(effect, "state0"), do="write `def rate(self, state, drive, t):`")
    if not any(p.kind == "amplitude" for p in effect.parameters):
        what = f"{effect.__name__} declares no amplitude, so nothing could switch it off"
        do = 'declare the number that makes it zero, as in `k = amplitude("N/m", "stiffness")`'
        raise UserError(what, do=do)
    _check_told(effect)


def _check_told(effect: type[AbstractEffect]) -> None:
    """Whether what it says of itself is what others read: one word in brackets is no tuple, and would be read letter
    by letter."""
    names = [(name, str, '("cubic-stiffness",)') for name in ("mistaken_for", "contains", "form_of")]
    for name, kind, said in (*names, ("alike", Likeness, "(SAME_LOSS,)")):
        told = getattr(effect, name)
        if type(told) not in (tuple, list) or not all(isinstance(one, kind) for one in told):
            what = f"{effect.__name__}.{name} is no tuple of {'names' if kind is str else 'likenesses'}"
            raise UserError(what, do=f"write `{name} = {said}`, with the comma")
    names = {p.name for p in effect.parameters}
    if effect.further_mode and names != {*MODE}:
        what = f"{effect.__name__} is a further mode with other parameters than {', '.join(MODE)}"
        raise UserError(what, do="give it those, as second-mode has them, or further_mode = 0")
    if effect.is_constant and len(names) != 1:
        what = f"{effect.__name__} is a constant of {len(names)} numbers"
        raise UserError(what, do="give it one, or is_constant = False")
    if missing := {*effect.gains} - names:
        what = f"{effect.__name__}.gains names {', '.join(sorted(missing))}, which it does not have"
        raise UserError(what, do='write a tuple of names of its parameters, as in `gains = ("travel",)`')


def _acts(effect: type[AbstractEffect]) -> bool:
    return any(effect.overrides(law) for law in LAWS)


def _own_methods(effect: type[AbstractEffect]) -> dict[str, FunctionType]:
    """The methods that are not those of every effect, by name."""
    classes = [c for c in effect.__mro__ if c is not AbstractEffect and issubclass(c, AbstractEffect)]
    return {name: f for c in reversed(classes) for name, f in vars(c).items() if isinstance(f, FunctionType)}


def _nearest_hook(name: str) -> str:
    if hasattr(AbstractEffect, name) or name.startswith("__"):
        return ""
    return next(iter(difflib.get_close_matches(name.lower().strip("_"), HOOKS, 1, _CLOSE)), "")


def _check_arguments(effect: type[AbstractEffect], name: str) -> None:
    wanted = list(inspect.signature(getattr(AbstractEffect, name)).parameters)
    written = inspect.getattr_static(effect, name)
    if isinstance(written, FunctionType):  # whoever decorates it knows what he does
        try:
            inspect.signature(written).bind(*wanted)
        except TypeError:
            what = f"{effect.__name__}.{name} does not take the arguments that it is given"
            do = f"write `def {name}({', '.join(wanted)}):`"
            raise UserError(what, where=place_of_method(effect, name), do=do) from None
