"""Effects hidden in amplitude-frequency curves: an independent simulator, and what the tool makes of its curves."""
