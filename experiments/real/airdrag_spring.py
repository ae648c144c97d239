"""A mass with a disc on a spring, decaying in air: `python -m experiments.real.airdrag_spring`. IDENT_BENCHMARKS names
the folder above `real/airdrag_spring`."""

from .device import Device

DEVICE = Device(
    "real/airdrag_spring",
    ("ringdown_1.csv", "ringdown_3.csv"),
    """device = { kind = "oscillator", output = "m" }

[[record]]
file = "ringdown_1.csv"

[[record]]
file = "ringdown_3.csv"
holdout = true
skip = "30 s"
""",
    baseline=7.8,
    start=10.0,
)

if __name__ == "__main__":
    DEVICE.main()
