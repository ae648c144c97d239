"""Which effect is missing: every effect scored, the best of them refitted.

`score` and `confirm` are the two halves, `look` both of them for one fit; `refits` rank where scores cannot be
believed, `pairs` finds two effects that hide each other, `splits` and `usual_form` are parts of a refit, and `missing`
asks for a posterior whether anything is.
"""
