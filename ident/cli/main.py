"""`ident`: finds the command, runs it, and turns whatever goes wrong into one line and an exit code.

Exit codes: 0 success, 2 wrong usage or unusable input, 1 failure. A command is a file of this folder with a click
command called `command`; it is imported only when it is needed, so that `ident --help` answers at once.
"""

from __future__ import annotations

import gc
import importlib
import importlib.util
import io
import logging
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress

import click

from ..errors import UserError, nearest, visible

COMMANDS = (
    "new",
    "check",
    "fit",
    "diagnose",
    "add",
    "remove",
    "discover",
    "sample",
    "compare",
    "attribute",
    "report",
    "workbench",
    "simulate",
    "effects",
)
"""Every command, in the order of the help page; those whose file does not exist are not offered."""

_DEBUG = "IDENT_DEBUG"


class _Commands(click.Group):
    """Commands that are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return [name for name in COMMANDS if importlib.util.find_spec(f"ident.cli.{name}") is not None]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.list_commands(ctx):
            return None
        return importlib.import_module(f"ident.cli.{cmd_name}").command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            do = nearest(args[0], self.list_commands(ctx))
            raise click.UsageError(f"there is no command {args[0]!r}{do and f' — {do}'}", ctx)
        return super().resolve_command(ctx, args)


def _version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib.metadata import version

        click.echo(f"ident {version('ident')}")
        ctx.exit()


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_version, help="Print the version."
)
def ident() -> None:
    """Fit a physical model to measured vibration records, and learn which effect is missing.

    \b
    A first walk:
      ident new mine                         a campaign to start from
      ident check mine                       what its data are worth
      ident fit mine -o runs/first           least squares and a report

    `ident COMMAND --help` explains one command, with an example.
    """


def run(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit code."""
    debug = bool(os.environ.get(_DEBUG))
    _prepare(debug)
    try:
        code = ident.main(args=None if arguments is None else list(arguments), prog_name="ident", standalone_mode=False)
        if debug:
            _say_counts()
        return code if isinstance(code, int) else 0
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.message, err=True)
        return 2
    except click.ClickException as error:
        return _fail(_usage(error), 2)
    except UserError as error:
        if debug:
            raise
        return _fail(str(error), 2)
    except (KeyboardInterrupt, click.Abort):
        return _fail("stopped; nothing was left half written", 1)
    except BrokenPipeError:  # `ident effects | head`: the reader has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if debug:
            raise
        place = str(error.filename or "")
        place = f"{place[:60]}…" if len(place) > 200 else place
        where = f"{place}: " if place else ""  # a full disk tells no file
        return _fail(f"{where}{error.strerror or error} — check that it can be read and written", 2)
    except MemoryError:
        return _fail("there is not enough memory for these records; thin them out, or fit fewer", 1)
    except Exception as error:  # the last resort of the program: whatever it is, the user gets one line
        if debug:
            raise
        cause = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        return _fail(f"something went wrong inside ident ({cause}); {_DEBUG}=1 shows where", 1)


def _say_counts() -> None:
    """How many programs the command compiled, and how many it found compiled; nothing if it needed none."""
    programs = sys.modules.get("ident.programs")
    if programs is not None:
        counts = programs.COUNTS
        click.echo(f"programs: {counts['traced']} traced and compiled, {counts['loaded']} loaded", err=True)


def _usage(error: click.ClickException) -> str:
    """A click error in one line, with the page that explains."""
    context = getattr(error, "ctx", None)
    path = context.command_path if context is not None else "ident"
    return " ".join(f"{error.format_message()} (see {path} --help)".split())


def _fail(message: str, code: int) -> int:
    click.echo(visible(f"ident: {message}"), err=True)
    return code


def _prepare(debug: bool) -> None:
    """Set up the process: warnings of libraries are for developers, and the user gets one line per error."""
    # Our matrices are tall and thin; OpenBLAS's threads, which wait by spinning, made reading a campaign ten times
    # slower on a busy machine. JAX has threads of its own. It works because nothing has imported numpy yet.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(1_000_000, 20, 100)  # a run makes 10⁵ objects that stay and 10³ that only this would find
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console without "µ" prints "?" instead of failing
    if not debug and not sys.warnoptions:
        warnings.simplefilter("ignore")
        logging.getLogger("jax").setLevel(logging.ERROR)


def main() -> None:
    """The console entry point."""
    with suppress(ValueError):  # not in the main thread: then whoever started it ends it
        signal.signal(signal.SIGTERM, _interrupt)  # a batch system asks like Ctrl-C, and gets the same order
    code = run()
    gc.freeze()  # what is left goes with the process: looking through it once more took 0.4 s
    sys.exit(code)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


if __name__ == "__main__":
    main()
