"""What is missing as a function of its coordinates, where the library has no name for it."""
