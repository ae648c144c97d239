"""The one exception that a user may meet: a sentence that says what is wrong, where, and what to do; and what is said
where an optional package is missing."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Iterable
from functools import partial
from typing import Any


def visible(text: str) -> str:
    """A text without what would steer a terminal: control and invisible characters as their numbers, lines kept."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else "    " if c == "\t" else f"\\x{ord(c):02x}" for c in text)


_LONGEST = 1000  # characters of one word: no path is longer, but what stands in a broken file may be


class UserError(Exception):
    """Unusable input. The command line prints it as one line and exits with 2.

    **Arguments:**

    - `what`: what is wrong, in the user's words.
    - `where`: file, line and column, as far as they are known ("a.csv, line 12, column 3").
    - `do`: what the user can do about it.
    """

    def __init__(self, what: str, *, where: str = "", do: str):
        self.what, self.where, self.do = what, where, do
        place = f"{where}: " if where else ""
        advice = f" — {do}" if do else ""
        words = f"{place}{what}{advice}".split()
        super().__init__(visible(" ".join(word if len(word) <= _LONGEST else f"{word[:60]}…" for word in words)))

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        """It passes between processes."""
        return partial(UserError, where=self.where, do=self.do), (self.what,)


_ALIKE = 0.5  # of `difflib`: from which on one word is taken for another


def nearest(name: object, known: Iterable[str], otherwise: str = "", most: int = 1) -> str:
    """Advice on a word that nobody knows: which of the known ones it may be, at most so many; `otherwise` where it is
    like none."""
    near = difflib.get_close_matches(str(name), sorted(known), most, _ALIKE)
    return f"did you mean {' or '.join(map(repr, near))}?" if near else otherwise


def need(module: str, what: str, extra: str, *, where: str = "", otherwise: str = "") -> Any:
    """An optional module, which is installed with an `extra` of ident.

    **Raises:** UserError that says `what` needs it, how to install it, and what else could be done.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.partition(".")[0].replace("_", "-")
        do = f"in the folder of ident: pip install '.[{extra}]'" + (f" (or {otherwise})" if otherwise else "")
        raise UserError(f"{what} needs the package {package}", where=where, do=do) from None
