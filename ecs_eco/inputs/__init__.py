"""Input from outside: the sections of world files, and the user's code that a world names.

`section` has the strict models of sections. `sources` reads and hashes the text of code, which runs only if
the user allows it: `trust` remembers what may run, `code` imports it, `parameters` checks the parameters of
functions.
"""
