"""`ident discover`: the whole loop by itself."""

from __future__ import annotations

from pathlib import Path

import click

from .options import (
    campaign_argument,
    effects_option,
    figures_option,
    force_option,
    json_option,
    minutes_option,
    resume_option,
    trust_option,
)


@click.command("discover", short_help="Find the missing effects one by one, until the noise floor.")
@campaign_argument
@effects_option
@click.option("-o", "--output", metavar="RUN", help="Run folder to write; runs/NAME if not given.")
@minutes_option
@resume_option
@force_option
@json_option
@figures_option
@trust_option
def command(
    campaign: tuple[str, ...],
    effects: tuple[str, ...] | None,
    output: str | None,
    minutes: float | None,
    resume: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Fit CAMPAIGN, see where the model fails, add the effect that explains it, and go on until the noise floor.

    The run folder holds the last model with the report of every step, and diagnosis.json. If no effect of the library
    explains the records, what is missing is estimated and written as an effect file of your own to refine.

    The run folder is written after every step. Ctrl-C, or the end of the --minutes, leaves what was found;
    diagnosis.json then says "finished": false, and --resume goes on from there.

    \b
    Example:
      ident discover data/mystery_platform -o runs/mystery
    """
    from ..campaign import read_campaign
    from ..report.run_folder import check_target
    from .fit import default_folder
    from .output import progress
    from .resume import check_resumed

    data = read_campaign(campaign)
    folder = Path(output) if output else default_folder(campaign)
    if resume:
        check_resumed(folder, data, effects)
    else:
        check_target(folder, force)

    from ..diagnosis.search.steps import Walked
    from ..fit.fit_data import fit_data, model_for
    from ..report.walk_json import read_walk
    from .limit import Limit
    from .walk import walk

    limit = Limit(minutes)
    if resume:
        walk(read_walk(folder, progress), folder, force=True, as_json=as_json, limit=limit)
        return
    model = model_for(data, effects, progress)
    progress(f"fitting {', '.join(model.names) or 'the linear model'}")
    walk(Walked(fit_data(data, model, report=progress)), folder, force=force, as_json=as_json, limit=limit)
