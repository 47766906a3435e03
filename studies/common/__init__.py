"""Code shared by several studies: the harness (`study`), grids of seeds, functions that run worlds, and
statistics."""
