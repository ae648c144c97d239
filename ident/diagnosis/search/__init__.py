"""From a model to a better one: effects added, taken out and swapped, and what each may be mistaken for."""
