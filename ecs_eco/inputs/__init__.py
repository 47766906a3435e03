"""What comes from outside: the sections of world files, and code of users that a world names.

`section` has the strict models of sections. The text of code is read and hashed by `sources` and runs only where
somebody allowed it: `trust` remembers what may run, `code` imports it, `parameters` says what functions take.
"""
