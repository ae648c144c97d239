"""The code of a law that is a table: its splines computed together, the four of them that are not zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from .terms import Number, Term

Shapes = dict[tuple[str, float, bool], str]
"""Names in the file of the shape numbers of terms, by name, value and whether they are fitted."""

_WIDTH = 100  # characters of a line of numbers


class TableCode(NamedTuple):
    """`prepare`, the method that gathers the numbers of the table; `body`, lines of the law; and the `product` that
    joins those of other terms."""

    prepare: str
    body: str
    product: str


def written_table(terms: Sequence[Term], shapes: Shapes) -> TableCode:
    """The code of those terms of a formula that are splines of a table; no text if there are none.

    `c1`, `c2` … are the numbers of the terms in their order. What of each spline is a constant or a straight line the
    model has in its linear part already, and is taken off.
    """
    splines = [(i, term, term.knot) for i, term in enumerate(terms, 1) if term.knot is not None]
    if not splines:
        return TableCode("", "", "")
    _, term, knot = splines[0]
    if term.number is None or any(other.table != knot.table for _, _, other in splines):
        raise ValueError("a formula has one table, and that a scale")
    by_index = {other.index: (f"self.c{i}", other.level, other.slope) for i, _, other in splines}
    numbers, level, slope = zip(*(by_index.get(k, ("0.0", 0.0, 0.0)) for k in range(knot.count)), strict=True)
    ends = f"{knot.low:.6g}, {knot.high:.6g}"
    taken = {"level": (level, ""), "slope": (slope, f" * jnp.clip(x, {ends})")}
    taken = {word: given for word, given in taken.items() if any(given[0])}
    prepare = "    def prepare(self):\n" + _array("c", numbers)
    for word, (values, _) in taken.items():
        prepare += _array(word, [f"{value:.9g}" for value in values], "  # of each spline: the linear part has it")
    known = "".join(f", c @ {word}" for word in taken)
    prepare += f"        return c{known}\n\n"
    body = f"        {', '.join(['c', *taken])} = self.prepared\n"
    body += f"        x = {knot.name} / self.{_name(term.number, shapes)}\n"
    law = f"spline(x, {ends}, c)" + "".join(f" - {word}{by}" for word, (_, by) in taken.items())
    factor = term.code.replace("{w}", f"self.{_name(term.width, shapes)}" if term.width else "")
    if factor == "1.0":
        return TableCode(prepare, body, law)
    return TableCode(prepare, body, f"({law}) * {factor}" if taken else f"{law} * {factor}")


def _name(number: Number, shapes: Shapes) -> str:
    return shapes[number.name, number.value, number.fitted]


def _array(name: str, words: Sequence[str], remark: str = "") -> str:
    """The line that makes an array, of as many words as there are."""
    lines, line = [], ""
    for word in words:
        if len(line) + len(word) > _WIDTH:
            lines, line = [*lines, line], ""
        line += f"{word}, "
    inner = "".join(f"            {one.rstrip()}\n" for one in [*lines, line])
    return f"        {name} = jnp.array([{remark}\n{inner}        ])\n"
