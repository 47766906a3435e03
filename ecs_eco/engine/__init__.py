"""Entities as columns: components, tables, systems, the clock, random numbers, errors and files.

Nothing here knows space or biology; everything else may import it.
"""
