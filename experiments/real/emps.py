"""A prismatic axis without a spring: `python -m experiments.real.emps`. IDENT_BENCHMARKS names the folder above
`real/emps`. The loop is closed around it; the drive that was sent is what counts.

Its makers publish 95.1 kg, 203 N·s/m, 20.4 N of dry friction, 35.15 N/V (A. Janot, M. Gautier, M. Brunot, Data set and
reference models of EMPS, 2019)."""

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
    final=6.5,
    values={
        "oscillator.gain": (35.15 / 95.1, 0.03),
        "oscillator.decay-time": (95.1 / 203.0, 0.08),
        "coulomb-friction.friction": (20.4 / 95.1, 0.08),
    },
    first="coulomb-friction",
    never=frozenset({"sensor-drift", "second-mode", "viscoelastic-support"}),
    form="no-spring",
)

if __name__ == "__main__":
    DEVICE.main()
