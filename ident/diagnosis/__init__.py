"""Where a model fails, which effect is missing, what it could be mistaken for, and what to measure next."""
