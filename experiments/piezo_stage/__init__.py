"""The Silverbox benchmark, with the command line alone."""
