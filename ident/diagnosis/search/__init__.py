"""From a model to a better one: effects added, taken out and swapped, and what each may be mistaken for.

`discover` is the walk and `steps` what it leaves. Beside every addition: `together` (two at once), `constant`,
`further_mode` and `drive` (the linear side), `once_more` (where it begins again). At its end: `prune` (`parts`,
`change`), `ties`, `lacking`; and `written` (`beyond`), where the library does not reach.
"""
