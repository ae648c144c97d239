"""What the data alone say of a record, and whether something is wrong with it."""
