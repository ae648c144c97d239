"""`ident simulate`: the forward model of every record, as a CSV file."""

from __future__ import annotations

from pathlib import Path

import click

from .options import effects_option, force_option, trust_option
from .output import progress, say, say_json


@click.command("simulate", short_help="Write the forward model of every record to a CSV file.")
@click.argument("source", nargs=-1, required=True, metavar="RUN|CAMPAIGN…")
@effects_option
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help='A parameter, e.g. platform.quality=40; "… MPa" is read.',
)
@click.option("--record", "wanted", multiple=True, metavar="FILE", help="Only this record; may be repeated.")
@click.option("-o", "--output", required=True, metavar="FILE.csv", help="File to write.")
@force_option
@click.option("--json", "as_json", is_flag=True, help="Print the parameters and records as JSON.")
@trust_option
def command(
    source: tuple[str, ...],
    effects: tuple[str, ...] | None,
    settings: tuple[str, ...],
    wanted: tuple[str, ...],
    output: str,
    force: bool,
    as_json: bool,
) -> None:
    """Compute what the model says for the drive of every record, and write time, drive and reading to one CSV file.

    With a RUN the parameters are those of its fit; with a CAMPAIGN they are the starting values of a fit. --set changes
    single ones. The initial state of a record that does not start at rest is fitted to that record.

    \b
    Example:
      ident simulate runs/first --set "platform.quality=40" -o what_if.csv
    """
    from ..errors import UserError

    if Path(output).exists() and not force:
        raise UserError("this exists already", where=output, do="choose another name, or --force to replace it")
    changes = dict(_setting(text) for text in settings)

    from ..fit.simulate import simulate, simulate_state
    from ..report.model_csv import write_model_csv

    if len(source) == 1 and (Path(source[0]) / "run.json").is_file():
        if effects is not None:
            do = "name the campaign instead of the run"
            raise UserError("a run has its effects already", where="--effects", do=do)
        from ..report.run_folder import load_state

        found = simulate_state(load_state(source[0]), changes, wanted, progress)
    else:
        found = simulate(list(source), effects, values=changes, records=wanted, report=progress)
    write_model_csv(found.records, found.readings, found.model.device, output, force=force)
    if as_json:
        names = [r.name for r in found.records]
        told = {"effects": list(found.model.names), "parameters": found.parameters, "records": names}
        say_json({"format": 1, "file": output, **told})
        return
    from ..report.words.quantity import show

    for parameter in found.model.parameters:
        value = found.parameters[parameter.name]
        say(f"{parameter.name} = {show(value, None, parameter.unit, found.model.device)}")
    say(f"{len(found.records)} records written to {output}")


def _setting(text: str) -> tuple[str, str]:
    """Name and value of one `--set NAME=VALUE`."""
    from ..errors import UserError

    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals:
        raise UserError(f"{text!r} is not NAME=VALUE", where="--set", do="write for example platform.quality=40")
    return name, value
