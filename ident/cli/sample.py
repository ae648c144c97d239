"""`ident sample`: the posterior of a run, drawn with emcee."""

from __future__ import annotations

import click

from .options import (
    figures_option,
    force_option,
    json_option,
    minutes_option,
    resume_option,
    run_argument,
    trust_option,
)


@click.command("sample", short_help="Draw the posterior of a run, and say when it can be trusted.")
@run_argument
@resume_option
@minutes_option
@click.option("--seed", type=click.IntRange(0), default=0, metavar="N", help="Of the walkers and their moves.")
@force_option
@json_option
@figures_option
@trust_option
def command(run: str, resume: bool, minutes: float | None, seed: int, force: bool, as_json: bool) -> None:
    """Draw the posterior of RUN with emcee, until it can be trusted: parameters with 90 % intervals, the prior each
    began with, the evidence of the model. Intervals of a model that does not describe the records are called not final.

    RUN gets posterior.json, posterior.nc (ArviZ), chain.h5 (emcee) and a new report. Ctrl-C and even kill -9 leave a
    chain; --resume goes on with it, bit by bit as if nothing had happened.

    \b
    Example:
      ident sample runs/first
      ident sample runs/first --resume --minutes 10
    """
    from pathlib import Path

    from ..errors import UserError
    from ..posterior.chain_file import need_h5py, read_chain
    from ..posterior.container import need_arviz_base, write_container
    from ..report.run_folder import load_run, read_run, renew_report, write_json
    from .output import progress, say, say_json, say_sheet

    folder = Path(run)
    read_run(folder)
    need_h5py()
    need_arviz_base()
    chain_file = folder / "chain.h5"
    if chain_file.exists() and not resume and not force:
        what = "this run has a chain already"
        raise UserError(what, where=str(chain_file), do="--resume goes on with it, --force begins again")
    if resume:
        read_chain(chain_file)  # a damaged one is answered before anything is compiled
    progress("reading the run")
    fit = load_run(folder)

    from ..diagnosis.judged import sample
    from ..report.posterior_json import posterior_dict
    from ..report.posterior_view import (
        evidence_words,
        posterior_section,
        posterior_sheet,
        prior_sheet,
        verdict_words,
    )

    progress("finding the peak and compiling the posterior")
    seconds = None if minutes is None else 60 * minutes
    posterior = sample(fit, chain_file, resume=resume, seed=seed, seconds=seconds, report=_tell)
    document = posterior_dict(posterior)
    progress("writing posterior.nc and the report")
    write_json(folder / "posterior.json", document)
    write_container(posterior, folder / "posterior.nc")
    renew_report(fit, folder, posterior=[posterior_section(posterior, document)])
    if as_json:
        say_json(document)
    else:
        say_sheet(posterior_sheet(document, fit.model.device))
        say_sheet(prior_sheet(document, fit.model.device))
        for sentence in (verdict_words(document), evidence_words(document["log_evidence"]), *document["notes"]):
            say(sentence)
        say(f"report: {folder / 'report.html'}")
    if posterior.sampled.stopped:
        progress(f"stopped, because {posterior.sampled.stopped}; `ident sample {run} --resume` goes on")
    if posterior.sampled.stopped == "it was interrupted":
        raise click.exceptions.Exit(1)


def _tell(now: object) -> None:
    from ..posterior.sampler import Progress
    from .output import progress

    assert isinstance(now, Progress)
    left = "" if now.seconds_left is None else f", about {now.seconds_left:.0f} s left"
    progress(f"{now.steps} steps, effective draws {now.ess:.0f}, R-hat {now.rhat:.3f}{left}")
