"""Write `docs/library.md` from what `ident effects --json` says: `python -m experiments.docs_library`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from ident.cli.main import ident

PAGE = Path(__file__).resolve().parents[1] / "docs" / "library.md"

_HEAD = """\
# The library of effects

Made by `python -m experiments.docs_library` from what `ident effects --json` prints; `ident effects NAME` tells more.
z is the displacement, ż the velocity, V the drive voltage, E = V/T_PZT the field, G and K_f the force per volt and per
strain. (x)₊ is x where it is positive, else zero. Parameters in *italics* are shapes: without meaning while the effect
is off, and searched on a grid. Parameters in (brackets) are held unless the campaign frees them, or a
walk does where they refine a law.
"""
_SIDES = {"force": "Forces on the stage", "drive": "In the drive", "sensor": "In the sensor"}


def effects() -> list[dict[str, Any]]:
    """Every effect of the library, as the command prints it."""
    result = CliRunner().invoke(ident, ["effects", "--json"], catch_exceptions=False)
    return json.loads(result.stdout)["effects"]


def page() -> str:
    """The whole page."""
    known = effects()
    parts = [_HEAD]
    for side, title in _SIDES.items():
        chosen = [effect for effect in known if effect["acts_on"] == side]
        rows = [f"| {_name(e)} | {_cell(e['equation'])} | {_parameters(e)} | {_mistaken(e)} |" for e in chosen]
        heading = ["| effect | equation | parameters | mistaken for |", "|---|---|---|---|"]
        parts.append("\n".join([f"## {title}\n", *heading, *rows]) + "\n")
    settings = [
        f"- `{e['name']}`: `{name}` is " + ", ".join(f'`"{word}"`' for word in words) + "."
        for e in known
        for name, words in e["settings"].items()
    ]
    if settings:
        defaults = (
            "The first word is the default of `ident fit`; `diagnose`, `discover` and `add` take one that explains far "
            "more, where the\ncampaign says none. `begins` is chosen by how the records begin."
        )
        parts.append(f"## Settings\n\n{defaults}\n\n" + "\n".join(settings) + "\n")
    sources = [f"- `{e['name']}`: {e['source']}." for e in known if e["source"]]
    parts.append("## Sources\n\n" + "\n".join(sources) + "\n")
    return "\n".join(parts)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _name(effect: dict[str, Any]) -> str:
    return f"`{effect['name']}`" + (" (platform only)" if effect["platform_only"] else "")


def _parameters(effect: dict[str, Any]) -> str:
    words = []
    for parameter in effect["parameters"]:
        name = f"*{parameter['name']}*" if parameter["kind"] == "shape" else parameter["name"].replace("_", "\\_")
        word = name + (f" {_unit(parameter['unit'])}" if parameter["unit"] != "1" else "")
        words.append(word if parameter["fitted"] else f"({word})")
    return ", ".join(words)


def _unit(text: str) -> str:
    """A unit as one writes it by hand; a bare * would be read as emphasis."""
    return re.sub(r"\^(\d)", lambda found: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(found[1])], text.replace("*", "·"))


def _mistaken(effect: dict[str, Any]) -> str:
    return ", ".join(f"`{name}`" for name in effect["mistaken_for"]) or "–"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
