"""The noise floor of a record, from the data alone."""
