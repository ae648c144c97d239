"""Simulated free decays with one hidden effect."""
