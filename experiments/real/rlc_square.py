"""A series RLC circuit under a square wave: `python -m experiments.real.rlc_square`. IDENT_BENCHMARKS names the folder
above `real/rlc_square`."""

from .device import Device

DEVICE = Device(
    "real/rlc_square",
    ("square_large.csv", "square_small.csv"),
    """device = { kind = "oscillator", output = "V" }

[[record]]
file = "square_large.csv"

[[record]]
file = "square_small.csv"
holdout = true
""",
    baseline=6.9,
    start=7.0,
    final=4.4,
)

if __name__ == "__main__":
    DEVICE.main()
