"""What several studies share: the harness (`study`), grids of seeds, how worlds are run,
and statistics of their own."""
