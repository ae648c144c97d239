"""What the records say of a model's parameters and of models: posterior, evidence, attribution."""
