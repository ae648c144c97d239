"""A mass with a disc on a spring, decaying in air: `python -m experiments.real.airdrag_spring`. IDENT_BENCHMARKS names
the folder above `real/airdrag_spring`.

The baseline by SciPy is of less than the files hold: fitted to 0.5-60 s of one run, judged on 20-60 s of the other
(`experiments.ring_downs.airdrag_reach` finds its numbers again there). Both are asked, the whole and that.
"""

from dataclasses import replace

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
skip = "20 s"
""",
    baseline=7.8,
    start=9.0,
    final=2.6,
)
EQUAL = replace(
    DEVICE,
    campaign=DEVICE.campaign.replace('skip = "20 s"\n', ""),
    baseline=3.1,
    final=3.1,
    rows={"ringdown_1.csv": (50, 6000), "ringdown_3.csv": (2000, 6000)},
)

if __name__ == "__main__":
    DEVICE.main()
    EQUAL.main()
