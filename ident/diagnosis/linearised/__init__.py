"""A fit as a linear regression: what small changes of a model add to the readings along the measured motion.

`trajectory` is that motion, `columns` what terms do along it (`curve_columns` to the points of sweeps, `balance` far
from where they are), `whiten` the unit of white noise, `regression` all of it in one value; `anchor` is where it is
best taken, `shorten` on how much of long records, and `histories` what came before those that begin in motion.
"""
