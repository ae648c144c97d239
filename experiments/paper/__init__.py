"""The paper's figures, each as a script that draws it and asserts its statement: `python -m experiments.paper`."""
