"""How much better is enough: one criterion between models, and when a difference is worth a name.

`criterion` weighs models by one number, `coloured_noise` asks whether noise did it, `enough` holds the shares of the
first excess that decide, `held_out` what records say that no fit has seen; `family` and `equivalences` are what is
known of laws before any record.
"""
