"""How well the three closures of `residual-stress` describe one L beam."""
