"""What is opened at all: plain files of a bearable size. Everything else is refused before a byte of it is read.

And how the path of one is written in a file that lies elsewhere.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ...errors import UserError

MOST_DATA = 1 << 29
"""Bytes of one data file, and of the numbers it unfolds to: 2·10⁶ samples of ten columns take a third of it."""

MOST_TEXT = 1 << 20
"""Bytes of what people write: a campaign, a device, an effect; and of one line of a table, or of all above it."""

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def seen_from(folder: Path, path: Path) -> str:
    """A path as it is written in a file of a folder."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive
        return path.resolve().as_posix()


def exists(path: Path) -> bool:
    """Whether there is anything of that name; a name that no file can have is no error."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def check_file(path: Path, name: str, most: int = MOST_DATA) -> Path:
    """The path, if it is a plain file of at most `most` bytes. **Raises:** UserError, at once and without reading.

    **Arguments:** `name`: the file as its user calls it.
    """
    try:
        found = os.stat(path)
    except (OSError, ValueError) as error:
        what = getattr(error, "strerror", None) or "this is no name of a file"
        raise UserError(what, where=name, do="check that the file is there and can be read") from None
    for is_kind, words in _KINDS:
        if is_kind(found.st_mode):
            raise UserError(f"this is {words}, not a file", where=name, do="copy its content to a plain file")
    if found.st_size > most:
        raise UserError(f"the file has {_size(found.st_size)}", where=name, do=f"at most {_size(most)} are read")
    return path


def read_bytes(path: Path, name: str, most: int = MOST_TEXT) -> bytes:
    """The content of a plain file of at most `most` bytes, also of one whose size is told wrongly."""
    with open(check_file(path, name, most), "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise UserError("the file does not end", where=name, do=f"at most {_size(most)} are read")
    return content


def check_unfolded(count: float, name: str) -> None:
    """Refuses a file whose numbers would take more than `MOST_DATA` bytes; `count` bytes are what it promises."""
    if count > MOST_DATA:
        do = f"at most {_size(MOST_DATA)} are read; export fewer columns, or thin the record out"
        raise UserError(f"the file unfolds to {_size(count)} of numbers", where=name, do=do)


def _size(count: float) -> str:
    for power, unit in ((1 << 30, "GB"), (1 << 20, "MB"), (1 << 10, "kB")):
        if count >= power:
            return f"{count / power:.3g} {unit}"
    return f"{count:.0f} bytes"
