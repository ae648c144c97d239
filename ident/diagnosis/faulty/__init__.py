"""Records that disagree with the others in a way that no device explains."""
