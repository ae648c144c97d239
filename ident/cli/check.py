"""`ident check`: the data alone, before any model."""

from __future__ import annotations

import click

from .options import campaign_argument, columns_option, json_option
from .output import say, say_json, say_sheet


@click.command("check", short_help="Read and judge the data of a campaign alone.")
@campaign_argument
@columns_option
@json_option
def command(campaign: tuple[str, ...], columns: dict[str, str | int], as_json: bool) -> None:
    """Read CAMPAIGN and judge its data: units, sampling, clipping, drift, noise floor, purity of the drive, and what
    these records can and cannot tell apart. Nothing is fitted and nothing is written.

    CAMPAIGN is a TOML file, a folder that holds campaign.toml, or data files.

    \b
    Example:
      ident check data/platform_317hz
    """
    from ident.campaign import read_campaign
    from ident.campaign.suspect import suspects_by_data
    from ident.campaign.trust import is_trusted
    from ident.report.data_judgement import about, judgement_dict, judgement_sheet, remarks, what_the_records_tell
    from ident.report.sweep_words import run_sheet

    data = read_campaign(campaign, columns)
    strange = [path for path in data.effect_files if not is_trusted(path)]
    if not strange and (data.effects or data.settings or data.priors or data.effect_files):
        from ident.model import build_model

        build_model(data)  # what a fit would refuse about the model is refused here
    if as_json:
        say_json(judgement_dict(data))
        return
    say(data.title)
    say()
    say_sheet(judgement_sheet(data))
    for record in data.records:
        say(about(record, data))
        for remark in remarks(record, data):
            say(f"  ! {remark}")
    if data.sweeps:
        say()
        say_sheet(run_sheet(data))
    if data.notes:
        say("\nAssumed and found")
        for note in data.notes:
            say(f"  {note}")
    for path in strange:
        say(f"  ! {path} has not run here: a fit needs --trust, and whether it is right was not checked")
    for suspect in suspects_by_data(data):
        say(f"  ! {suspect.sentence}")
    if not data.fitted:
        say("  ! a fit needs at least one trace that is not held out")
    say("\nWhat these records tell apart")
    for sentence in what_the_records_tell(data):
        say(f"  {sentence}")
