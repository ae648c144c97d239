"""A driven torsion pendulum with offsets: `python -m experiments.real.torsion_pendulum`. IDENT_BENCHMARKS names the
folder above `real/torsion_pendulum`."""

from .device import Device

DEVICE = Device(
    "real/torsion_pendulum",
    ("train.csv", "test.csv"),
    """device = { kind = "oscillator", output = "rad" }

[[record]]
file = "train.csv"

[[record]]
file = "test.csv"
holdout = true
""",
    baseline=15.6,
    start=15.7,
    final=2.2,
    first="cubic-stiffness",
)

if __name__ == "__main__":
    DEVICE.main()
