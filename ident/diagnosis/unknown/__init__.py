"""What is missing as a function of its coordinates, where the library has no name for it.

`coordinates` and `splines` are what a function is looked for in, `subsets` says of which coordinates it is one,
`terms` and `formula` write it; `find` is the whole of it; `picture`, `words` and `effect_file` hand it on.
"""
