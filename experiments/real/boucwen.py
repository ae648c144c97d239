"""The hysteretic benchmark of Noël and Schoukens: `python -m experiments.real.boucwen`. IDENT_BENCHMARKS names the
folder above `real/boucwen`."""

from .device import Device

DEVICE = Device(
    "real/boucwen",
    ("train_multisine.csv", "test_multisine.csv"),
    """device = { kind = "oscillator", output = "m", input = "N" }

[[record]]
file = "train_multisine.csv"
skip = 200

[[record]]
file = "test_multisine.csv"
holdout = true
skip = 200
""",
    baseline=0.03,
    start=27.0,
    final=0.1,
    verdicts=frozenset({"identified", "ambiguous"}),
    first="bouc-wen",
    never=frozenset({"cubic-stiffness", "viscoelastic-support", "coulomb-friction", "creep"}),
)

if __name__ == "__main__":
    DEVICE.main()
