"""Where a model fails: by record, time, phase, motion, level, harmonic and frequency."""
