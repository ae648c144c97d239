"""How much better is enough: one criterion between models, and when a difference is worth a name."""
