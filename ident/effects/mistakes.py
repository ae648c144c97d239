"""What is wrong in an effect file, in words about the file: the place, and what to write instead."""

from __future__ import annotations

import inspect
import traceback
from pathlib import Path

import jax

from ..campaign.tables.opening import read_bytes
from ..errors import UserError
from .effect import AbstractEffect, Drive, State

_TRACED = (
    "Python asks here for a number that JAX does not know yet, with `if`, `and`, `or`, `min`, `max` or a comparison",
    "write jnp.where(condition, a, b), jnp.minimum or jnp.maximum",
)
_NUMPY = (
    "numpy or math is applied here to a number that JAX does not know yet",
    "use jax.numpy in its place: `import jax.numpy as jnp`, jnp.exp(…), jnp.sqrt(…)",
)


def place_of_class(effect: type[AbstractEffect], file: Path) -> str:
    """File and line where the class of an effect begins."""
    lines = read_bytes(file, str(file)).decode("utf-8", "replace").splitlines()
    number = next((i for i, line in enumerate(lines, 1) if line.startswith(f"class {effect.__name__}")), 1)
    return f"{file}, line {number}"


def place_of_method(effect: type[AbstractEffect], method: str) -> str:
    """File and line where a method of an effect begins; "" if it is none that a file defines."""
    code = getattr(inspect.unwrap(getattr(effect, method, None) or len), "__code__", None)
    return "" if code is None else f"{code.co_filename}, line {code.co_firstlineno}"


def answered(error: Exception, file: Path) -> UserError:
    """An exception that a user's file has raised, as a sentence with its line in that file."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    where = f"{file}, line {lines[-1]}" if lines else str(file)
    if isinstance(error, UserError):
        return UserError(error.what, where=error.where or where, do=error.do)
    what, do = _words(error)
    return UserError(what, where=where, do=do)


def _words(error: Exception) -> tuple[str, str]:
    if isinstance(error, jax.errors.TracerBoolConversionError):
        return _TRACED
    if isinstance(error, (jax.errors.TracerArrayConversionError, jax.errors.ConcretizationTypeError)):
        return _NUMPY  # float(), int() and an index ask in the same way as math does
    what = f"running this effect file failed: {type(error).__name__}: {error}"
    return what, _has(error) or "correct it, or take it out of effect_files"


def _has(error: Exception) -> str:
    """What may be read where a name was asked for that is not there."""
    asked = error.obj if isinstance(error, AttributeError) else None
    if isinstance(asked, (State, Drive)):
        name = type(asked).__name__.lower()
        return "there are " + ", ".join(f"{name}.{field}" for field in asked._fields)
    if isinstance(asked, AbstractEffect):
        declared = [entry.name for entry in (*asked.parameters, *asked.choices)]
        return "it declares " + (", ".join(f"self.{name}" for name in declared) or "no parameter")
    return ""
