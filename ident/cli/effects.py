"""`ident effects`: the library of effects, and the user's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .output import say, say_json, say_sheet

if TYPE_CHECKING:
    from ..effects import AbstractEffect
    from ..effects.registry import Registry


@click.command("effects", short_help="List the effects, or explain one.")
@click.argument("name", required=False)
@click.option("--file", "files", multiple=True, metavar="FILE", help="An effect file of your own; may be repeated.")
@click.option("--json", "as_json", is_flag=True, help="Print the same as JSON.")
def command(name: str | None, files: tuple[str, ...], as_json: bool) -> None:
    """List every effect, or explain the one called NAME: its equation, parameters and units, where it acts, where it
    comes from and what it is easily mistaken for.

    \b
    Example:
      ident effects cubic-stiffness
    """
    from ..campaign.trust import trust
    from ..effects.registry import find, registry
    from ..errors import UserError

    if name and name.endswith(".py"):
        what, do = "a file of effects is no name of one", f"write `ident effects --file {name}`"
        raise UserError(what, where=name, do=do)
    trust(*files)  # named at the command line: that is to ask for them
    known = registry([Path(file) for file in files])
    chosen = [find(name, known)] if name else list(known.values())
    if as_json:
        say_json({"format": 1, "effects": [_as_dict(effect, known) for effect in chosen]})
    elif name:
        _explain(chosen[0], known)
    else:
        _list(known)


_SIDES = {"force": "force on the stage", "drive": "drive", "sensor": "sensor"}


def _list(known: Registry) -> None:
    from ..report.words.sheet import Column, Sheet

    columns = (Column("effect"), Column("acts on"), Column("equation", wraps=True), Column("parameters", wraps=True))
    ordered = sorted(known.values(), key=lambda effect: (list(_SIDES).index(effect.acts_on), effect.name))
    rows = tuple(
        (effect.name, _SIDES[effect.acts_on], effect.equation, ", ".join(p.name for p in effect.parameters))
        for effect in ordered
    )
    say_sheet(Sheet("Effects", columns, rows))
    say("ident effects NAME explains one; docs/add-an-effect.md tells how to write your own.")


def _explain(effect: type[AbstractEffect], known: Registry) -> None:
    import inspect

    from ..report.words.sheet import Column, Sheet

    say(f"{effect.name}   {effect.equation}\n")
    say(inspect.cleandoc(effect.__doc__ or "") + "\n")
    columns = (Column("parameter"), Column("unit"), Column("meaning", wraps=True), Column("in a fit", wraps=True))
    rows = tuple((f"{effect.name}.{p.name}", p.unit, p.doc, _in_a_fit(p)) for p in effect.parameters)
    say_sheet(Sheet("Parameters", columns, rows))
    for choice in effect.choices:
        say(f"setting        {choice.name} = " + " | ".join(f'"{word}"' for word in choice.words))
    for word, text in _facts(effect):
        say(f"{word:<14} {text}")
    for likeness in _likenesses(effect, known):
        say(f"{'alike':<14} {', '.join(likeness['effects'])}: {likeness['why']}; apart by: {likeness['separate']}")


def _in_a_fit(parameter: Any) -> str:
    words = ["zero means absent" if parameter.kind == "amplitude" else "shape: searched on a grid"]
    words += ["positive"] if parameter.positive else []
    words += [] if parameter.fitted else ["held unless free"]
    return ", ".join(words)


def _facts(effect: type[AbstractEffect]) -> list[tuple[str, str]]:
    facts = [
        ("acts on", _SIDES[effect.acts_on]),
        ("needs", effect.needs),
        ("only for", "the platform, whose geometry it uses" if effect.platform_only else ""),
        ("mistaken for", ", ".join(effect.mistaken_for)),
        ("source", effect.source),
    ]
    return [(word, text) for word, text in facts if text]


def _likenesses(effect: type[AbstractEffect], known: Registry) -> list[dict[str, Any]]:
    """What it shares with others that are known, the closest first."""
    found = []
    for likeness in effect.alike:
        others = [name for name, other in known.items() if likeness in other.alike and name != effect.name]
        found.append({"effects": sorted(others), "why": likeness.why, "separate": likeness.separate})
    return [one for one in found if one["effects"]]


def _as_dict(effect: type[AbstractEffect], known: Registry) -> dict[str, Any]:
    return {
        "name": effect.name,
        "equation": effect.equation,
        "acts_on": effect.acts_on,
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "kind": p.kind,
                "meaning": p.doc,
                "positive": p.positive,
                "fitted": p.fitted,
            }
            for p in effect.parameters
        ],
        "settings": {choice.name: list(choice.words) for choice in effect.choices},
        "needs": effect.needs or None,
        "platform_only": effect.platform_only,
        "mistaken_for": list(effect.mistaken_for),
        "alike": _likenesses(effect, known),
        "source": effect.source,
    }
