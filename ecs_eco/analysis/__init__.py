"""Statistics and figures of what runs left behind, one file a phenomenon.

Takes run folders or series tables and runs no world; nothing here knows numba, torch or esper.
matplotlib is imported only when a figure is drawn.
"""
