"""External input: the sections of world files, and user code named in them.

`section` defines the strict models of sections. `sources` reads and hashes source code, which runs only if
the user allows it; `trust` stores which code is allowed, `code` imports it, and `parameters` checks the
parameters of functions.
"""
