"""Records that disagree with the others in a way that no device explains.

`suspects`: one record is faulty, or all in one way (`faults`, by one number of `nuisance`).
"""
