"""A fit as a linear regression: what small changes of a model add to the readings along the measured motion."""
