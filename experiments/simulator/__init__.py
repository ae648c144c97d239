"""An independent simulator of the platform: NumPy, SciPy and numba only, its own formulas, nothing from `ident`."""
