"""`ident attribute`: which mechanism explains the zero-point offset."""

from __future__ import annotations

import click

from .options import figures_option, json_option, run_argument, trust_option


@click.command("attribute", short_help="Which mechanism explains the zero-point offset, with credible intervals.")
@run_argument
@json_option
@figures_option
@trust_option
def command(run: str, as_json: bool) -> None:
    """Ask of RUN which of its effects explains the zero-point offset of each periodic record: mean over periods, second
    harmonic, dwell asymmetry, displacement where the drive is zero. Effects are switched on and off at draws of the
    posterior (those of `ident sample` where it has finished), and each measure is shared among them (Shapley). RUN gets
    an attribution.json and a new report.

    \b
    Example:
      ident attribute runs/first
    """
    from pathlib import Path

    from ..report.run_folder import load_run, read_run, renew_report, write_json
    from .output import progress, say, say_json, say_sheet

    folder = Path(run)
    read_run(folder)
    progress("reading the run")
    fit = load_run(folder)

    from ..diagnosis.judged import attribute
    from ..report.attribution_view import attribution_dict, attribution_section, attribution_sheet

    progress("switching mechanisms on and off at draws of the posterior, and asking the library what is missing")
    document = attribution_dict(attribute(fit, chain_file=folder / "chain.h5"), fit.model.device)
    write_json(folder / "attribution.json", document)
    progress("writing the report")
    renew_report(fit, folder, attribution=[attribution_section(document)])
    if as_json:
        say_json(document)
        return
    say_sheet(attribution_sheet(document))
    say(f"verdict: {document['verdict']}")
    say(document["words"])
    say(f"report: {folder / 'report.html'}")
