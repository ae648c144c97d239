"""The built-in effects, one file each; the registry finds every file in this folder."""
