"""A folder is replaced whole or not at all, whenever the process that writes it is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ident.report import new_folder as folders
from ident.report.new_folder import new_folder

WRITER = """
import sys
from pathlib import Path
from ident.report.new_folder import new_folder
target = Path(sys.argv[1])
print("started", flush=True)
for round in range(10**9):
    with new_folder(target) as folder:
        (folder / "run.json").write_text("x" * 200)
        (folder / "lineage.json").write_text("y" * 200)
"""


def test_what_fails_leaves_the_old_folder_and_nothing_else(tmp_path):
    target = tmp_path / "run"
    with new_folder(target) as folder:
        (folder / "run.json").write_text("old")
    with pytest.raises(ZeroDivisionError), new_folder(target) as folder:
        (folder / "run.json").write_text("new")
        raise ZeroDivisionError
    assert (target / "run.json").read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["run"]


def test_a_writer_killed_at_any_moment_leaves_one_whole_run(tmp_path):
    target = tmp_path / "run"
    with new_folder(target) as folder:
        for name, letter in (("run.json", "x"), ("lineage.json", "y")):
            (folder / name).write_text(letter * 200)
        (folder / "notes.txt").write_text("mine")
    root = Path(__file__).parent.parent.parent
    for k in range(6):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(target)], stdout=subprocess.PIPE, cwd=root,
            env={**os.environ, "PYTHONPATH": str(root)},
        )  # fmt: skip
        assert writer.stdout is not None and writer.stdout.readline()
        time.sleep(0.003 * k)
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        writer.stdout.close()
        assert (target / "run.json").read_text() == "x" * 200
        assert (target / "lineage.json").read_text() == "y" * 200
        assert (target / "notes.txt").read_text() == "mine"
    with new_folder(target) as folder:  # the next writer cleans up
        (folder / "run.json").write_text("z")
    assert [p.name for p in tmp_path.iterdir()] == ["run"]


def test_where_folders_cannot_change_names_at_once_and_no_process_may_be_asked(tmp_path, monkeypatch):
    """As on Windows, where a signal 0 is Ctrl-C, and a program is no library."""

    def no_library(name, **_):
        raise TypeError("bad argument type for built-in operation")

    def kill(process, number):
        raise AssertionError("somebody was sent Ctrl-C")

    target = tmp_path / "run"
    monkeypatch.setattr(folders.ctypes, "CDLL", no_library)
    for text in ("old", "new"):
        with new_folder(target) as folder:
            (folder / "run.json").write_text(text)
    assert (target / "run.json").read_text() == "new" and [p.name for p in tmp_path.iterdir()] == ["run"]
    with monkeypatch.context() as there:
        there.setattr(folders.sys, "platform", "win32")
        there.setattr(folders.os, "kill", kill)
        assert folders._lives(2**22 + 1)
