"""Where a model fails, which effect is missing, what it could be mistaken for, and what to measure next.

To be read from the bottom: `linearised` makes a fit a regression; `evidence` says how much better is enough; `ranking`
scores every effect on the regression and refits the best; `where` says where the error is, and `unknown` what no
library has; `records` says in which numbers records differ; `search` walks from a model to a better one (`discover` is
the whole of it); `faulty` finds records that no device explains, and `next_record` what would tell rivals apart.
`diagnose` asks all of them in turn, and `document` writes the answer down.

The words of the walk:

- *misfit*, *excess*: χ² above that of noise. The *first* excess is that of the fit with which a walk began.
- *score*: what an effect promises, along the measured motion, without a simulation; *refit*: what it keeps in one.
- *law*: how a force, drive or reading depends on its coordinates. No library's is exactly a device's: a small share of
  the first excess is a *finer shape* of what was found, and no further effect.
- *tie*: effects between which the records do not choose; *family*: a law with named laws among its members.
- *long* records are compared on *excerpts* (`working`), and fitted whole at the end.
"""
