"""Code that several studies share: the harness (`study`), grids of seeds, functions that run worlds, and
statistics."""
