"""gdb: vectors, rays, boxes and nodes of trees as a person would write them.

    (gdb) source tools/gdb_raykit.py
    (gdb) print ray          ->  from (0, 0, -1) along (0, 0, 1), t_max inf
    (gdb) print bvh.nodes[0] ->  inner, children 2 and 3, box (-1, -1, 0) .. (1, 1, 9)
"""

import gdb
import gdb.printing


def _number(value):
    return f"{float(value):.6g}"


def _vector(value):
    return f"({_number(value['x'])}, {_number(value['y'])}, {_number(value['z'])})"


def _box(value):
    low, high = value["corner"][0], value["corner"][1]
    if float(low["x"]) > float(high["x"]):
        return "empty"
    return f"{_vector(low)} .. {_vector(high)}"


def _ray(value):
    return (
        f"from {_vector(value['origin'])} along {_vector(value['direction'])}, "
        f"t_max {_number(value['t_max'])}"
    )


def _hit(value):
    if int(value["triangle"]) == 0xFFFFFFFF:
        return f"miss up to t {_number(value['t'])}"
    return (
        f"triangle {int(value['triangle'])} at t {_number(value['t'])}, "
        f"u {_number(value['u'])}, v {_number(value['v'])}"
    )


def _node(value):
    first, count = int(value["first"]), int(value["count"])
    if count == 0:
        return f"inner, children {first} and {first + 1}, box {_box(value['box'])}"
    return f"leaf, triangles {first} to {first + count - 1}, box {_box(value['box'])}"


class _Printer:
    """Says a value in one line."""

    def __init__(self, say, value):
        self._say, self._value = say, value

    def to_string(self):
        try:
            return self._say(self._value)
        except gdb.MemoryError:
            return "(no such memory)"


def _collection():
    printers = gdb.printing.RegexpCollectionPrettyPrinter("raykit")
    for name, say in {
        "rk_vec3": _vector, "rk_box": _box, "rk_ray": _ray, "rk_hit": _hit, "rk_bvh_node": _node,
    }.items():
        printers.add_printer(name, f"^{name}$", lambda value, say=say: _Printer(say, value))
    return printers


gdb.printing.register_pretty_printer(gdb.current_objfile(), _collection(), replace=True)
