"""Every figure of the paper: `python -m experiments.paper`, or some of them: `python -m experiments.paper fig08`."""

from __future__ import annotations

import importlib
import sys

from .sheet import show

FIGURES = ("fig03", "fig08", "fig09", "fig10", "fig11", "fig12", "fig13", "slips", "closures")


def main() -> None:
    """Print each statement, with its numbers."""
    for name in sys.argv[1:] or FIGURES:
        print(f"{name}: {show(importlib.import_module(f'.{name}', __package__))}", flush=True)


if __name__ == "__main__":
    main()
