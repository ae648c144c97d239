"""Free decays of a sloshing tank: `python -m experiments.real.sloshing_decay`. IDENT_BENCHMARKS names the folder above
`real/sloshing_decay`."""

from .device import Device

DEVICE = Device(
    "real/sloshing_decay",
    ("decay_1.csv", "decay_2.csv", "decay_3.csv"),
    """device = { kind = "oscillator", output = "m" }

[[record]]
file = "decay_1.csv"

[[record]]
file = "decay_2.csv"

[[record]]
file = "decay_3.csv"
holdout = true
""",
    baseline=35.0,
    start=35.2,
    final=7.0,
    first="cubic-stiffness",
)

if __name__ == "__main__":
    DEVICE.main()
