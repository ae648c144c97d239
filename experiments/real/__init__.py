"""Measured devices that nobody here simulated."""
