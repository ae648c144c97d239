"""What the lab measured: frozen records, and the reading of tables."""
