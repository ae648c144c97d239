"""Where a model fails, by record, time, phase, motion, level, harmonic and frequency: `locate` looks, `words` says
what stands out."""
