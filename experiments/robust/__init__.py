"""Inputs that nobody would write on purpose, and processes that are killed."""
