"""`ident fit`: least squares, and a run folder with the result."""

from __future__ import annotations

import math
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
from .output import progress, say, say_fit, say_folder, say_json


@click.command("fit", short_help="Fit a model to a campaign and write a run folder.")
@campaign_argument
@effects_option
@click.option("-o", "--output", metavar="RUN", help="Run folder to write; runs/NAME if not given.")
@click.option(
    "--sigma",
    type=click.Choice(["known", "scaled", "fitted"]),
    show_default="known, or as the run that goes on",
    help="What the error bars stand on: the noise floors, these times the error over noise, or the residuals.",
)
@click.option("--robust", is_flag=True, help="Let outliers count less.")
@click.option("--starts", type=click.IntRange(0, 1000), default=0, metavar="N", help="Add N random starts.")
@click.option("--seed", type=click.IntRange(0), default=0, metavar="N", help="Of the random starts.")
@click.option("--profile", "profiles", multiple=True, metavar="NAME", help="Profile one parameter; may be repeated.")
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
    sigma: str | None,
    robust: bool,
    starts: int,
    seed: int,
    profiles: tuple[str, ...],
    minutes: float | None,
    resume: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Fit a physical model to the records of CAMPAIGN that are not held out.

    CAMPAIGN is a TOML file, a folder that holds campaign.toml, or data files. Parameters with their uncertainties, the
    error of every record beside its noise floor, and what the data leave undetermined are printed and kept in the
    run folder, with a report to open in a browser. A search that --minutes ends leaves the best so far, marked as not
    converged; --resume goes on from there.

    \b
    Example:
      ident fit data/platform_317hz --effects residual-stress,pzt-hysteresis -o runs/first
    """
    from ..campaign import read_campaign
    from ..errors import UserError
    from ..report.run_folder import check_target, load_state, read_lineage, read_run, write_run
    from .resume import check_resumed

    data = read_campaign(campaign)
    folder = Path(output) if output else default_folder(campaign)
    lineage = ()
    if resume:
        check_resumed(folder, data, effects)
        before, lineage = read_run(folder), read_lineage(folder)
        if before["converged"]:  # its posterior or diagnosis would be lost for nothing
            what = "this fit has converged, so there is nothing to go on with"
            raise UserError(what, where=str(folder), do="name another folder with -o, without --resume")
        sigma, robust = sigma or before["sigma"], robust or before["options"].get("robust", False)
    else:
        check_target(folder, force)
    sigma = sigma or "known"
    seconds = math.inf if minutes is None else 60 * minutes

    from ..fit.fit_data import fit_data, model_for
    from ..fit.profile import check_profiled, profile

    if resume:
        model, data, initial = load_state(folder)
    else:
        model, initial = model_for(data, effects, progress), None
    check_profiled(model, profiles)
    found = fit_data(
        data, model, sigma=sigma, robust=robust, starts=starts, seed=seed,  # type: ignore[arg-type]
        initial=initial, seconds=seconds, report=progress,
    )  # fmt: skip
    if minutes is not None and not found.converged:
        progress("stopped before the search had converged; --resume goes on")
        profiles = ()
    for name in (name for name in profiles if not found[name].fitted):  # the model had it free: the fit is kept
        progress(f"no profile of {name}: the records do not determine it, so that the fit holds it")
    profiles = tuple(name for name in profiles if found[name].fitted)
    curves = [profile(found, name, robust=robust, report=progress) for name in profiles]
    options = {"sigma": sigma, "robust": robust, "starts": starts, "seed": seed}
    documents = {"profiles.json": {"format": 1, "profiles": [c.as_dict() for c in curves]}} if curves else {}
    write_run(
        found, folder, force=force or resume, command=command_line(), options=options, lineage=lineage,
        documents=documents, report=progress,
    )  # fmt: skip
    if as_json:
        say_json(read_run(folder))
        return
    say_fit(found)
    for curve in curves:
        say(curve.sentence)
    say_folder(folder)


def default_folder(campaign: tuple[str, ...]) -> Path:
    """`runs/` and the name of the campaign: of its folder, or of the first file."""
    path = Path(campaign[0]).resolve()
    if path.is_dir():  # whatever is behind a point in its name
        return Path("runs") / path.name
    return Path("runs") / (path.parent.name if path.name == "campaign.toml" else path.stem)


def command_line() -> str:
    """The command as it was typed, for the record of the run."""
    import shlex
    import sys

    return shlex.join(["ident", *sys.argv[1:]])
