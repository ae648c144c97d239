"""Records that differ from one another: each has a number of its own (`between`) that `differing` tells
(`between_levels`, of sweeps)."""
