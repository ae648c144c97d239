"""`ident simulate`: the forward model of every record, as a CSV file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .options import effects_option, force_option, trust_option
from .output import progress, say, say_json

if TYPE_CHECKING:
    import numpy as np

    from ident.campaign import Campaign
    from ident.model import Model


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
    from ident.errors import UserError

    if Path(output).exists() and not force:
        raise UserError("this exists already", where=output, do="choose another name, or --force to replace it")
    model, campaign, values = _model(source, effects)
    values = _changed(model, values, settings)
    records = [r for r in campaign.traces if not wanted or r.name in wanted]
    missing = set(wanted) - {r.name for r in records}
    if missing or not records:
        what = f"there is no trace called {min(missing)}" if missing else "the campaign has no traces"
        raise UserError(what, do=f"the traces are {', '.join(r.name for r in campaign.traces) or 'none'}")

    from ident.fit.reading import read
    from ident.report.model_csv import write_model_csv

    progress(f"compiling the model and simulating {len(records)} records")
    write_model_csv(records, read(model, values, records), campaign.device, output, force=force)
    numbers = {p.name: float(v) for p, v in zip(model.parameters, values, strict=True)}
    if as_json:
        names = [r.name for r in records]
        say_json({"format": 1, "file": output, "effects": list(model.names), "parameters": numbers, "records": names})
        return
    from ident.report.quantity import show

    for parameter in model.parameters:
        say(f"{parameter.name} = {show(numbers[parameter.name], None, parameter.unit, model.device)}")
    say(f"{len(records)} records written to {output}")


def _model(source: tuple[str, ...], effects: tuple[str, ...] | None) -> tuple[Model, Campaign, np.ndarray]:
    from ident.campaign import read_campaign
    from ident.errors import UserError

    if len(source) == 1 and (Path(source[0]) / "run.json").is_file():
        if effects is not None:
            raise UserError(
                "a run has its effects already", where="--effects", do="name the campaign instead of the run"
            )
        from ident.report.run_folder import load_state

        return load_state(source[0])
    campaign = read_campaign(source)

    from ident.fit.guess import data_scales, guess_linear
    from ident.fit.starts import base_values
    from ident.model import build_model

    model = build_model(campaign, effects)
    if not campaign.traces:
        raise UserError("the campaign has no traces", do="a forward model needs the drive of a trace")
    guess = guess_linear(campaign.traces, model.linear.nominal_frequency)
    return model, campaign, base_values(model, guess, data_scales(campaign.traces, guess.frequency))


def _changed(model: Model, values: Any, settings: tuple[str, ...]) -> np.ndarray:
    """The parameter values with those of `--set NAME=VALUE`."""
    import difflib
    import math

    import numpy as np

    from ident.campaign.table import is_number
    from ident.errors import UserError
    from ident.units import parse_quantity, unit

    values = np.array(values, float)
    index = {p.name: i for i, p in enumerate(model.parameters)}
    for setting in settings:
        name, equals, text = (part.strip() for part in setting.partition("="))
        if not equals:
            raise UserError(f"{setting!r} is not NAME=VALUE", where="--set", do="write for example platform.quality=40")
        if name not in index:
            near = difflib.get_close_matches(name, index, 1, 0.4)
            do = f"did you mean {near[0]}?" if near else f"the parameters are {', '.join(index)}"
            raise UserError(f"the model has no parameter {name!r}", where="--set", do=do)
        if is_number(text):
            value = float(text)
        else:
            value = parse_quantity(text, unit(model.parameters[index[name]].unit).dimension, where=f"--set {name}")
        if not math.isfinite(value) or (model.parameters[index[name]].positive and value < 0):
            raise UserError(
                f"{text} is not possible", where=f"--set {name}", do="give a finite value of the right sign"
            )
        values[index[name]] = value
    return values
