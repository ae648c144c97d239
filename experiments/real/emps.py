"""A prismatic axis without a spring: `python -m experiments.real.emps`. IDENT_BENCHMARKS names the folder above
`real/emps`. The loop is closed around it; the drive that was sent is what counts."""

from .device import Device

DEVICE = Device(
    "real/emps",
    ("train.csv", "pulses.csv"),
    """device = { kind = "oscillator", output = "m" }

[[record]]
file = "train.csv"

[[record]]
file = "pulses.csv"
holdout = true
""",
    baseline=6.5,
    start=6.5,
    final=6.0,
    first="coulomb-friction",
    form="no-spring",
)

if __name__ == "__main__":
    DEVICE.main()
