"""The house rules that a program can check; CONTRIBUTING.md says why they exist."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
LONGEST_FILE = 400


def _sources(*folders: str) -> list[Path]:
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _at(path: Path, node: ast.AST | None = None) -> str:
    place = path.relative_to(ROOT).as_posix()
    return place if node is None else f"{place}:{getattr(node, 'lineno', 0)}"


def _imported(path: Path) -> Iterator[tuple[str, ast.AST]]:
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Import):
            yield from ((alias.name.split(".")[0], node) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module.split(".")[0], node


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _name(requirement: str) -> str:
    return _normal(re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0])


def _project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def _needed_by_users() -> set[str]:
    project = _project()["project"]
    extras = [name for names in project["optional-dependencies"].values() for name in names]
    return {_name(requirement) for requirement in [*project["dependencies"], *extras]}


def test_no_file_outgrows_one_idea():
    lengths = {
        _at(p): len(p.read_text(encoding="utf-8").splitlines()) for p in _sources("ident", "experiments", "tests")
    }
    assert lengths, "no sources found"
    assert {place: n for place, n in lengths.items() if n > LONGEST_FILE} == {}


def test_every_module_says_what_it_is():
    modules = [p for p in _sources("ident", "experiments", "tests") if p.read_text(encoding="utf-8").strip()]
    assert [_at(path) for path in modules if not ast.get_docstring(_tree(path))] == []


def test_every_folder_of_the_package_is_a_package():
    # A folder without __init__.py imports well, but the import contract does not see it.
    assert [_at(p.parent) for p in _sources("ident") if not (p.parent / "__init__.py").exists()] == []


def test_every_public_function_and_class_is_documented():
    bare = [
        f"{_at(path, node)} {node.name}"
        for path in _sources("ident")
        for node in _tree(path).body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        and not node.name.startswith("_")
        and not ast.get_docstring(node)
    ]
    assert bare == []


def test_only_the_command_line_prints():
    prints = [
        _at(path, node)
        for path in _sources("ident")
        if (ROOT / "ident" / "cli") not in path.parents
        for node in ast.walk(_tree(path))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    ]
    assert prints == []


def test_every_import_is_a_declared_dependency():
    declared = _needed_by_users()
    undeclared = [
        f"{_at(path, node)} {name}"
        for path in _sources("ident")
        for name, node in _imported(path)
        if name not in sys.stdlib_module_names and name != "ident"
        if _normal(name) not in declared
    ]
    assert undeclared == []


def test_the_lock_pins_every_dependency_and_names_no_host():
    lines = (ROOT / "requirements-dev.txt").read_text(encoding="utf-8").splitlines()
    entries = [line for line in lines if line and not line.startswith("#")]
    assert [line for line in entries if not re.fullmatch(r"[\w.-]+==[\w.]+( ; .+)?", line)] == []
    tools = {_name(requirement) for requirement in _project()["dependency-groups"]["dev"]}
    assert (_needed_by_users() | tools) - {_name(line) for line in entries} == set()


def test_every_dependency_has_its_reason_in_the_documents():
    table = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
    explained = {
        _normal(name) for row in re.findall(r"^\| ([\w ,.-]+) \|", table, re.MULTILINE) for name in row.split(", ")
    }
    assert _needed_by_users() - explained == set()


def test_help_loads_nothing_heavy():
    script = (
        "import sys; sys.argv = ['ident', '--help']\n"
        "from ident.cli.main import main\n"
        "try:\n"
        "    main()\n"
        "except SystemExit as stop:\n"
        "    assert not stop.code, stop.code\n"
        "print('loaded:', *sorted({'jax', 'pandas', 'matplotlib'} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    assert "Usage" in done.stdout
    assert done.stdout.splitlines()[-1] == "loaded:"


def test_a_fit_and_its_page_load_nothing_that_they_can_do_without():
    script = (
        "import sys, ident.cli.fit, ident.fit, ident.report.run_folder\n"
        "print('loaded:', *sorted({'scipy.signal', 'scipy.stats', 'pandas', 'matplotlib.pyplot'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "loaded:"
