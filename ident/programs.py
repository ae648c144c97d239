"""Compiled programs, counted, and kept between processes.

A program is a function of a static value (a model, say) and of arrays. It is traced and compiled once for each static
value and each set of shapes; the machine code then lies in the cache folder, so that no later process traces or
compiles it again. Shapes are few on purpose: records are cut into chunks of one size (`response.tape`).

What is kept is what XLA compiled, not an exported computation: `jax.export` needs a further package, and what it keeps
must be compiled again. Loading takes 0.04 s where tracing and compiling take 0.4 s or more. The name of a file tells
everything on which the code depends: the sources of ident, the static value (an effect file by its checksum), the
shapes, JAX, and the processor.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import tempfile
import threading
from collections import Counter, OrderedDict
from collections.abc import Callable, Hashable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import jax
import numpy as np

from . import runtime

COUNTS: Counter[str] = Counter()
"""How often this process has `traced` a program, or `loaded` one that an earlier process compiled."""


_MOST = 120
"""Programs that are held at a time, the last used: each takes 4 to 7 MB (of 50 and of 120, measured), and a walk that
finds no way refits hundreds of models."""


class _Held:
    """The programs that were used last, by function, static value and shapes."""

    def __init__(self) -> None:
        self._programs: OrderedDict[Any, Callable[..., Any]] = OrderedDict()
        self._locks: dict[Any, threading.Lock] = {}
        self._lock = threading.Lock()

    def get(self, key: Any, obtain: Callable[[], Callable[..., Any]]) -> Callable[..., Any]:
        """The program of a key; obtained once, whoever asks."""
        with self._lock:
            if (held := self._programs.get(key)) is not None:
                self._programs.move_to_end(key)
                return held
            lock = self._locks.setdefault(key, threading.Lock())
        with lock:
            if (held := self._programs.get(key)) is not None:
                return held
            held = obtain()
            with self._lock:  # before those who wait for it go on: they would obtain it again
                self._programs[key] = held
                self._locks.pop(key, None)
                while len(self._programs) > _MOST:
                    self._programs.popitem(last=False)
        return held


_HELD = _Held()


class Static(Hashable, Protocol):
    """What decides a program besides shapes; `fingerprint` says so in words that hold for every process, or is None if
    that cannot be said."""

    @property
    def fingerprint(self) -> str | None: ...


class Program:
    """A function `f(static, *arrays)` whose compiled code is kept; arrays in, arrays out."""

    def __init__(self, function: Callable[..., Any]):
        self.function = function
        self._name = f"{function.__module__}.{function.__qualname__}"
        self.__doc__ = function.__doc__

    def __call__(self, static: Static | None, *arrays: Any) -> Any:
        leaves, tree = jax.tree.flatten(arrays)
        leaves = [x if isinstance(x, jax.Array) else np.asarray(x) for x in leaves]
        key = (self.function, static, tree, tuple((x.shape, x.dtype) for x in leaves))
        return _HELD.get(key, lambda: self._obtain(static, tree, leaves))(*leaves)

    def _obtain(self, static: Static | None, tree: Any, leaves: list[Any]) -> Callable[..., Any]:
        file = self._file(static, tree, leaves)
        kept = None if file is None else _load(file, len(leaves))
        if kept is not None:
            COUNTS["loaded"] += 1
            return kept
        COUNTS["traced"] += 1
        shapes: list[Any] = []

        def flat(*leaves: Any) -> tuple[Any, ...]:
            found = self.function(static, *jax.tree.unflatten(tree, leaves))
            flattened, structure = jax.tree.flatten(found)
            shapes.append(jax.tree.unflatten(structure, range(len(flattened))))
            return tuple(flattened)

        compiled = jax.jit(flat).lower(*leaves).compile(compiler_options=runtime.compiler_options())
        if file is not None:
            _keep(compiled, shapes[-1], file)
        return _Kept(compiled, shapes[-1])

    def _file(self, static: Static | None, tree: Any, leaves: list[Any]) -> Path | None:
        told = "" if static is None else static.fingerprint
        folder = _folder()
        if told is None or folder is None:
            return None
        shapes = [(x.shape, x.dtype.str) for x in leaves]
        name = hashlib.sha256(repr((self._name, told, str(tree), shapes)).encode()).hexdigest()[:32]
        return folder / f"{name}.xla"


def program(function: Callable[..., Any]) -> Program:
    """Decorator: a function of a static value and arrays as a `Program`."""
    return Program(function)


class _Kept:
    """Compiled code that takes and gives arrays; `shape`: nested tuples that say which array goes where."""

    def __init__(self, compiled: Callable[..., Any], shape: Any):
        self._compiled, self._shape = compiled, shape

    def __call__(self, *leaves: Any) -> Any:
        return _placed(self._shape, self._compiled(*leaves))


def _placed(shape: Any, found: Sequence[Any]) -> Any:
    if shape is None:
        return None
    return found[shape] if isinstance(shape, int) else tuple(_placed(part, found) for part in shape)


@lru_cache(maxsize=1)
def _folder() -> Path | None:
    """Where this version of ident keeps its programs on this machine; None if nothing is to be kept."""
    cache = runtime.cache_folder()
    if cache is None:
        return None
    told = (_sources(), jax.__version__, _processor(), os.environ.get("XLA_FLAGS", ""), runtime.compiler_options())
    folder = cache / "programs" / hashlib.sha256(repr(told).encode()).hexdigest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None  # a read-only home costs time, not correctness
    return folder


def _sources() -> str:
    """Checksum of ident's own code: an edited effect must not meet the program of its old text."""
    found = hashlib.sha256()
    root = Path(__file__).parent
    for file in sorted(root.rglob("*.py")):
        found.update(str(file.relative_to(root)).encode() + file.read_bytes())
    return found.hexdigest()


def _processor() -> str:
    """The instructions that this processor knows: code compiled for more would not run."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    told = {line.split(":")[0].strip(): line for line in lines}
    return told.get("model name", platform.processor()) + told.get("flags", told.get("Features", platform.machine()))


@lru_cache(maxsize=1)
def _have_lapack() -> None:
    """JAX looks up the functions of LAPACK when it first lowers a call of one; code that is only loaded finds none, and
    calls nothing."""
    try:
        from jaxlib.lapack import prepare_lapack_call
    except ImportError:  # not the public way, which lowers a call and takes a quarter of a second
        jax.jit(jax.numpy.linalg.cholesky).lower(np.eye(1))
    else:
        prepare_lapack_call("potrf_ffi", np.float64)


def _load(file: Path, count: int) -> Callable[..., Any] | None:
    from jax.experimental.serialize_executable import deserialize_and_load

    try:
        text, shape, given = pickle.loads(file.read_bytes())
        if b"lapack" in text:
            _have_lapack()
        trees = (jax.tree.structure(((0,) * count, {})), jax.tree.structure((0,) * given))
        return _Kept(deserialize_and_load(text, *trees), shape)
    except FileNotFoundError:
        return None
    except Exception:  # noqa: BLE001  (whatever is wrong with a kept program, compiling it again mends it)
        return None


def _keep(compiled: Any, shape: Any, file: Path) -> None:
    from jax.experimental.serialize_executable import serialize

    try:
        text, _, out = serialize(compiled)
        with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as new:
            new.write(pickle.dumps((text, shape, out.num_leaves)))
        Path(new.name).replace(file)  # in one piece, whatever another process does
    except (OSError, ValueError, TypeError, jax.errors.JaxRuntimeError):
        return  # it runs all the same
