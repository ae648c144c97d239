"""Speed ratios against other ways of doing the same thing, timed in the same process."""
