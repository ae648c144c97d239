"""`python -m ident` does what `ident` does: for machines where scripts are not on the path."""

from .cli.main import main

if __name__ == "__main__":
    main()
