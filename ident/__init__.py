"""ident: find out what physics a measured device obeys."""
