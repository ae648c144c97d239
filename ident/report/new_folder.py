"""A folder, or a file, that takes its final name complete or not at all, in one step of the file system where that has
one."""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import UserError

OWN = frozenset(
    [
        "run.json",
        "lineage.json",
        "parts.json",
        "walk.json",
        "diagnosis.json",
        "profiles.json",
        "posterior.json",
        "posterior.nc",
        "chain.h5",
        "compare.json",
        "attribution.json",
        "report.html",
        "figures",
    ]
)
"""What ident itself writes into a run folder; whatever else lies there is its user's and stays."""


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """A folder beside `target` to write into, which becomes `target` if all goes well.

    What lay under that name is replaced, but for what is not ident's own. A process that is killed leaves either the
    old folder or the new one, and what it left beside is removed by the next that writes there.
    """
    mark = f".ident-{hashlib.sha256(f'{platform.node()}/{target.name}'.encode('utf-8', 'replace')).hexdigest()[:12]}-"
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _clean(target.parent, mark)
        temporary = Path(tempfile.mkdtemp(prefix=f"{mark}{os.getpid()}-", dir=target.parent))
    except OSError as error:
        raise UserError(error.strerror or "cannot be written", where=str(target), do="choose another folder") from None
    try:
        temporary.chmod(0o777 & ~_mask())
        yield temporary
        try:
            if target.is_dir() and any(target.iterdir()):
                _keep_foreign(target, temporary)
                _exchange(temporary, target)
            else:
                temporary.rename(target)  # an empty folder gives way
        except OSError as error:
            what = error.strerror or "cannot be written"
            raise UserError(what, where=str(target), do="choose another folder") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file whole or not at all."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)


def _keep_foreign(old: Path, new: Path) -> None:
    """The user's own files of the old folder, also in the new one; linked, where that can be, instead of copied."""
    for entry in old.iterdir():
        if entry.name in OWN or entry.name.endswith(".part") or (new / entry.name).exists():
            continue
        if entry.is_dir() and not entry.is_symlink():
            shutil.copytree(entry, new / entry.name, symlinks=True, copy_function=link_or_copy)
        else:
            link_or_copy(entry, new / entry.name)


def link_or_copy(source: str | Path, target: str | Path) -> None:
    """The same file under a second name, or a copy where the file system has no such thing."""
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)


_SWAP = 2  # RENAME_EXCHANGE of Linux and RENAME_SWAP of macOS
_HERE = -100  # AT_FDCWD of Linux


def _exchange(new: Path, old: Path) -> None:
    """The two folders change names, at once; where a system cannot do that, one after the other."""
    names = os.fsencode(new), os.fsencode(old)
    with suppress(OSError, AttributeError, TypeError):  # the last is Windows, which has no library of its own program
        library = ctypes.CDLL(None, use_errno=True)
        if sys.platform == "darwin":
            done = library.renamex_np(*names, _SWAP)
        else:
            done = library.renameat2(_HERE, names[0], _HERE, names[1], _SWAP)
        if done == 0:
            return
    aside = old.with_name(new.name + "-old")
    old.rename(aside)
    try:
        new.rename(old)
    except BaseException:  # also Ctrl-C: the old run keeps its name
        aside.rename(old)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _clean(parent: Path, mark: str) -> None:
    """Removes what a process that lives no more has left; what it had moved aside is somebody's run and stays."""
    for entry in parent.glob(f"{mark}*"):
        match = re.fullmatch(re.escape(mark) + r"(\d+)-[^/]*", entry.name)
        aside = entry.name.endswith("-old")
        if match and not aside and entry.is_dir() and not entry.is_symlink() and not _lives(int(match[1])):
            shutil.rmtree(entry, ignore_errors=True)


def _lives(process: int) -> bool:
    if sys.platform == "win32":  # where signal 0 is no question but Ctrl-C: what was left stays there
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
