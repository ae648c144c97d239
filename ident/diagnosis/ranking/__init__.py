"""Which effect is missing: every effect scored, the best of them refitted."""
