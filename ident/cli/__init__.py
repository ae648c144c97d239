"""The command line: each file is one command that parses, calls the package, and prints."""
