"""A file with an effect that acts as the missing one does, to be fitted, kept and improved like any other."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from ...campaign.trust import trust_for_now
from ...effects.dependence import Side
from ...errors import UserError
from .find import Unknown
from .formula import Formula
from .splines import UNITS
from .table_code import Shapes, written_table
from .terms import Term, amplitude_unit

_STATE = {"z": "state.z", "v": "state.v", "V": "drive.V", "t": "t", "rate": "drive.rate"}
_LOOP = "    dV = drive.rate / jnp.where(drive.omega > 0, drive.omega, jnp.inf)\n"


class _Written(NamedTuple):
    """One term in the file: its product, the parameters it declares, and the rate of its hidden state."""

    product: str
    declared: tuple[str, ...]
    rate: str
    hidden_unit: str


def write_effect(unknown: Unknown, path: Path, name: str) -> None:
    """Write a Python file that defines the missing term as an effect, its amplitudes starting from the estimate.

    **Raises:** UserError if the name is not one of lower-case words joined by hyphens, no term describes what is
    missing, or the file exists.
    """
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        raise UserError(f"{name!r} is no name of an effect", do='use lower-case words, as in "unknown-effect"')
    if unknown.written is None:
        raise UserError("no term describes what is missing", do="leave out records whose motion forgets how it began")
    path = Path(path)
    if path.exists():
        raise UserError("this file exists already", where=str(path), do="choose another name, or move it away")
    path.parent.mkdir(parents=True, exist_ok=True)  # beside a run folder that is not there yet
    path.write_text(effect_source(unknown.written, name, unknown.sentences[0]), encoding="utf-8")
    trust_for_now(path)  # our own words; `diagnose` remembers those that it keeps


def effect_source(formula: Formula, name: str, found: str = "") -> str:
    """The text of that file."""
    shapes: Shapes = {}
    terms, hidden = [], 0
    for i, (term, amplitude) in enumerate(zip(formula.terms, formula.coefficients, strict=True), 1):
        terms.append(_term(i, term, float(amplitude), formula.side, shapes, hidden))
        hidden += bool(term.memory)
    table = written_table(formula.terms, shapes)
    products = [t.product for t, term in zip(terms, formula.terms, strict=True) if term.knot is None]
    products += [table.product] if table.product else []
    product = " + ".join(products)
    if len(product) > 90:
        product = "(\n            " + "\n            + ".join(products) + "\n        )"
    signature = {"force": "force(self, state, drive, t)", "drive": "drive(self, hidden, drive, t)",
                 "sensor": "sensor(self, state, drive, t)"}[formula.side]  # fmt: skip
    store = "hidden" if formula.side == "drive" else "state.hidden"
    names = sorted({n for term in formula.terms for n in term.names})
    body = _locals(names) + table.body + f"        return {product.replace('{hidden}', store)}\n"
    declared = "".join(f"    {line}\n" for term in terms for line in term.declared)
    rates = [term.rate for term in terms if term.rate]
    memory = _memory(rates) if rates else ""
    units = "    hidden_units = " + _tuple([f'"{t.hidden_unit}"' for t in terms if t.rate]) + "\n" if rates else ""
    whole = table.prepare + body + memory
    imports = "import jax.numpy as jnp\n\n" if "jnp." in whole else ""
    kinds = "AbstractEffect, amplitude" + (", shape" if "= shape(" in declared else "")
    helpers = "from ident.effects.memory import dragged\n" if "dragged(" in whole else ""
    helpers += "from ident.effects.table import spline\n" if table.product else ""
    sharp = next((n for mark, n in (("tanh", 250), ("dragged(", 120), ("maximum(", 120)) if mark in whole), 0)
    fine = f"    steps_per_period = {sharp}\n" if sharp else ""
    if "tanh" in whole or "maximum(" in whole:
        fine += "    has_kink = True\n"
    found = found.replace("\\", "/").replace('"', "'")  # a unit of the user's own stands in it
    head = f'"""{found or "What a fit could not explain, as a formula."}\n\nEdit it as you learn what it is."""\n\n'
    title = "".join(word.capitalize() for word in name.split("-"))
    text = formula.text if len(formula.text) < 90 else f"{len(formula.terms)} terms in {', '.join(names)}"
    return (
        f"{head}{imports}from ident import {kinds}\n{helpers}\n\n"
        f'class {title}(AbstractEffect):\n    """{text}."""\n\n'
        f'    name = "{name}"\n    equation = "{text}"\n{units}{fine}\n{declared}\n'
        f"{table.prepare}    def {signature}:\n{body}{memory}"
    )


def _term(i: int, term: Term, amplitude: float, side: Side, shapes: Shapes, hidden: int) -> _Written:
    unit = amplitude_unit(side, term.powers)
    declared = [f'c{i} = amplitude("{unit}", "of {term.text}", default={amplitude:.9g})']
    own = {"{n}": "", "{w}": ""}
    for place, number in (("{n}", term.number), ("{w}", term.width)):
        if number is None:
            continue
        key = (number.name, number.value, number.fitted)
        if key not in shapes:
            taken = [n for n in shapes.values() if n == key[0] or n.startswith(f"{key[0]}_")]
            shapes[key] = f"{key[0]}_{len(taken) + 1}" if taken else key[0]
            held = "" if number.fitted else ", fitted=False"
            declared.append(f'{shapes[key]} = shape("{number.unit}", "{number.doc}", grid=({number.value:.9g},){held})')
        own[place] = f"self.{shapes[key]}"
    code = term.code.replace("{n}", own["{n}"]).replace("{w}", own["{w}"]).replace("{h}", f"{{hidden}}[{hidden}]")
    rate = ""
    if term.memory:
        x, h = _STATE[term.names[0]], f"state.hidden[{hidden}]"
        speed = "state.v" if term.names[0] == "z" else "drive.rate"
        rate = f"({x} - {h}) / {own['{n}']}"
        if term.memory == "play":
            rate = f"{speed} * dragged({rate}, {speed})"
    return _Written(f"self.c{i} * {code}" if code != "1.0" else f"self.c{i}", tuple(declared), rate,
                    UNITS[term.names[0]] if term.memory else "")  # fmt: skip


def _locals(names: list[str]) -> str:
    lines = "".join(f"        {n} = {_STATE[n]}\n" for n in names if n not in ("dV", "t"))
    return lines + ("    " + _LOOP if "dV" in names else "")


def _tuple(items: list[str]) -> str:
    return f"({', '.join(items)}{',' if len(items) == 1 else ''})"


def _memory(rates: list[str]) -> str:
    start = _tuple(["0.0"] * len(rates))
    listed = "".join(f"            {rate},\n" for rate in rates)
    return (
        f"\n    def state0(self):\n        return {start}\n"
        f"\n    def rate(self, state, drive, t):\n        return (\n{listed}        )\n"
    )
