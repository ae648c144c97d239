"""Whether fits return the truth, with error bars that mean what they say."""
