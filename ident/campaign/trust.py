"""Effect files are programs. One runs only if this user has run or written the same bytes before, or asks for it.

What was trusted is remembered by checksum, in the user's own folder of settings (`IDENT_CONFIG` names another).
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

from ..errors import UserError
from .tables.opening import read_bytes

_session: set[str] = set()  # where the folder cannot be written, this process still knows
_asked = [False]


def trust_what_runs(asked: bool) -> None:
    """Whether this command was told to trust whatever effect files it meets (`--trust`)."""
    _asked[0] = asked


def checksum(content: bytes) -> str:
    """SHA-256, as it stands in run.json."""
    return hashlib.sha256(content).hexdigest()


def trust(*files: str | os.PathLike[str]) -> tuple[str, ...]:
    """Lets effect files run, now and later, as long as they do not change; returns their checksums (SHA-256).

    Look at a file that is not yours before you trust it: it can do whatever a program can.
    """
    sums = trust_for_now(*files)
    fresh = [one for one in sums if not _kept(one)]
    if fresh:
        try:
            _list().parent.mkdir(parents=True, exist_ok=True)
            with open(_list(), "a", encoding="ascii") as file:
                file.writelines(f"{one}\n" for one in fresh)
        except OSError:
            pass  # trusted in this process only, and asked again in the next
    return sums


def trust_for_now(*files: str | os.PathLike[str]) -> tuple[str, ...]:
    """`trust` in this process alone: of files that may not outlive it."""
    sums = tuple(_sum_of(file) for file in files)
    _session.update(sums)
    return sums


def is_trusted(file: Path) -> bool:
    """Whether an effect file would run as it is."""
    return _known(_sum_of(file))


def check_trusted(contents: Iterable[tuple[Path, bytes]]) -> None:
    """**Raises:** UserError that lists the files, if any of them was never trusted."""
    strange = [str(file) for file, content in contents if not _known(checksum(content))]
    if strange and _asked[0]:
        trust(*strange)
    elif strange:
        many = len(strange) > 1
        what = f"{'these effect files have' if many else 'this effect file has'} not run here before, or changed since"
        do = f"read {'them' if many else 'it'}: to run is to trust a program; then repeat the command with --trust"
        raise UserError(what, where=", ".join(strange), do=f"{do} (Python: ident.trust(file))")


def _list() -> Path:
    told = os.environ.get("IDENT_CONFIG")
    if told:
        return Path(told) / "trusted-effects.txt"
    from platformdirs import user_config_path

    return user_config_path("ident") / "trusted-effects.txt"


def _sum_of(file: str | os.PathLike[str]) -> str:
    return checksum(read_bytes(Path(file), str(file)))


def _known(one: str) -> bool:
    return one in _session or _kept(one)


def _kept(one: str) -> bool:
    try:
        return one in read_bytes(_list(), str(_list())).decode("ascii", "replace").split()
    except UserError:
        return False
