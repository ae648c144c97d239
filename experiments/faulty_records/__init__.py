"""Records that something is wrong with: are they named before any physics is?"""
