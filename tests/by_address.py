"""Calls of the C library that units may not name, as a determined attacker makes them: by the distance
from one that they may. So tests can try the defences behind the rules for units."""

import ctypes


def by_address(*names):
    """Returns definitions, to stand after the #include lines, that make these names such calls."""
    library = ctypes.CDLL(None)
    origin = ctypes.c_void_p.in_dll(library, "stdout").value
    lines = []
    for name in names:
        distance = ctypes.cast(getattr(library, name), ctypes.c_void_p).value - origin
        lines.append(f"#define {name} ((__typeof__(&{name}))((char *)stdout + ({distance}L)))")
    return "\n".join(lines) + "\n"
