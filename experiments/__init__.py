"""Runnable studies. Nothing below `simulator`, `benchmarks` and `hidden_effects` imports `ident`."""
