"""Whether fits reach the same minimum wherever they start."""
