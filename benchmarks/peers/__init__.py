"""Other renderers on the Cornell reference; each runs as its own process and prints JSON lines."""
