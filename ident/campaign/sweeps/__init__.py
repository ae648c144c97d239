"""Amplitude-frequency curves: read, brought into one form, judged."""
