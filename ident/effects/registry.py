"""Finding effects by name: the built-in library, and the user's own files."""

from __future__ import annotations

import importlib
import linecache
import pkgutil
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

from ..campaign.tables.opening import read_bytes
from ..campaign.trust import check_trusted
from ..errors import UserError, nearest
from .dimensions import check_units
from .effect import AbstractEffect
from .mistakes import answered, place_of_class
from .probe import check_runs
from .written import check_written

Registry = Mapping[str, type[AbstractEffect]]


@lru_cache(maxsize=1)
def built_in() -> Registry:
    """Every effect of the library, by name; a new file in `effects/library` is found without being listed."""
    from . import library

    modules = [importlib.import_module(f"{library.__name__}.{m.name}") for m in pkgutil.iter_modules(library.__path__)]
    return {effect.name: effect for module in modules for effect in _effects_of(module)}


def effect_class(given: Any) -> type[AbstractEffect]:
    """What was given for an effect of one's own. **Raises:** UserError if it is no class of one."""
    if isinstance(given, type) and issubclass(given, AbstractEffect):
        return given
    raise UserError(f"{given!r} is neither the name of an effect nor a class of one", do="see docs/add-an-effect.md")


def registry(files: Iterable[Path] = ()) -> Registry:
    """The library and the effects defined in the user's files.

    **Raises:** UserError, naming file and line, if a file was never trusted (see `trust`), cannot be run, defines no
    effect, takes a name that exists, or defines one whose units do not match.
    """
    found = dict(built_in())
    contents = [(Path(file), _content(Path(file))) for file in files]
    check_trusted(contents)
    for file, content in contents:
        for effect in _load(file, content, found):
            if effect.name in found:
                raise UserError(
                    f"the name {effect.name!r} is taken",
                    where=place_of_class(effect, file),
                    do="give the effect another name",
                )
            found[effect.name] = effect
    return found


def find(name: str, known: Registry) -> type[AbstractEffect]:
    """The effect of that name. **Raises:** UserError with the nearest names."""
    if name not in known:
        do = nearest(name, known, "`ident effects` lists them", most=3)
        raise UserError(f"there is no effect called {name!r}", do=do)
    return known[name]


def _effects_of(module: ModuleType) -> list[type[AbstractEffect]]:
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, AbstractEffect) and value.name
        and value.__module__ == module.__name__
    ]  # fmt: skip


def _content(file: Path) -> bytes:
    if not file.exists():
        raise UserError("this effect file does not exist", where=str(file), do="check effect_files in the campaign")
    return read_bytes(file, str(file))


def _load(file: Path, content: bytes, before: Registry) -> list[type[AbstractEffect]]:
    """The effects of a file, from the very bytes that were found to be trusted; `before`: those that were loaded."""
    name = f"ident_user_effect_{file.stem}"
    module = ModuleType(name)
    module.__file__ = str(file)
    try:
        linecache.cache[str(file)] = (len(content), None, content.decode("utf-8").splitlines(True), str(file))
        exec(compile(content, str(file), "exec", dont_inherit=True), vars(module))  # noqa: S102 (trusted above)
    except UnicodeDecodeError:
        raise UserError("this is no text in UTF-8", where=str(file), do="an effect file is a Python file") from None
    except SyntaxError as error:
        raise UserError(
            f"not valid Python: {error.msg}", where=f"{file}, line {error.lineno}", do="correct it"
        ) from error
    except Exception as error:  # whatever a user's file does wrong, it is answered with its place in that file
        raise answered(error, file) from error
    except SystemExit as error:
        raise UserError(
            "this effect file ends the program",
            where=str(file),
            do="remove the exit: an effect file only defines classes",
        ) from error
    effects = _effects_of(module)
    if not effects:
        raise UserError(
            "no effect is defined here",
            where=str(file),
            do='write a class that inherits AbstractEffect and has a name = "…"',
        )
    if content not in _sound:
        known = dict(before)
        for effect in effects:
            _check(effect, known, file)
            known[effect.name] = effect
        _sound.add(content)
    return effects


_sound: set[bytes] = set()  # files that this process has checked, which takes some tenths of a second


def _check(effect: type[AbstractEffect], known: Registry, file: Path) -> None:
    try:
        check_written(effect)
        check_runs(effect, known)
        check_units(effect, known)
    except UserError as error:
        raise UserError(error.what, where=error.where or place_of_class(effect, file), do=error.do) from error
    except Exception as error:  # the formulas are the user's too
        raise answered(error, file) from error
