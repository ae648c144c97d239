"""Studies of posterior, evidence and attribution; each asserts what it shows."""
