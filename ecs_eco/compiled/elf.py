"""Undefined symbols in Linux machine code (64-bit ELF)."""

from __future__ import annotations

import struct


def undefined(code: bytes) -> set[str]:
    """Return the undefined names of object code (64-bit ELF)."""
    (sections,) = struct.unpack_from("<Q", code, 0x28)
    size, count = struct.unpack_from("<HH", code, 0x3A)
    table = [struct.unpack_from("<IIQQQQIIQQ", code, sections + i * size) for i in range(count)]
    names = set()
    for section in table:
        if section[1] == 2:  # symbols
            texts = table[section[6]][4]
            for i in range(section[5] // 24):
                name, _, _, home = struct.unpack_from("<IBBH", code, section[4] + 24 * i)
                if name and home == 0:
                    names.add(code[texts + name : code.index(b"\0", texts + name)].decode())
    return names
