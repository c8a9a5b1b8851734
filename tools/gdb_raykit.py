"""gdb: prints vectors, rays, boxes and tree nodes readably. If the program fails within a library,
the frame of the unit that called it is selected.

    (gdb) source tools/gdb_raykit.py
    (gdb) print ray          ->  from (0, 0, -1) along (0, 0, 1), t_max inf
    (gdb) print bvh.nodes[0] ->  inner, children 2 and 3, box (-1, -1, 0) .. (1, 1, 9)
    (gdb) print stack        ->  1 waiting, the last comes next
                                 [0] from t 2.5: leaf, triangles 0 to 3, box ...
"""

import struct

import gdb
import gdb.printing


def _as_float(number):
    try:
        return struct.unpack("f", struct.pack("f", number))[0]
    except OverflowError:  # rounded up from the largest one
        return float("inf")


def _number(value):
    """The fewest digits that no other number of its type has: what differs looks different."""
    number, is_float = float(value), value.type.strip_typedefs().sizeof == 4
    for digits in range(1, 17):
        text = f"{number:.{digits}g}"
        read = float(text)
        if number == (_as_float(read) if is_float else read):
            return f"{read:.0f}" if 1 <= abs(read) < 1e9 and read == int(read) else text
    return f"{number:.17g}"


def _vector(value):
    return f"({', '.join(_number(value[field.name]) for field in value.type.fields())})"


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


def _traversal_stack(value):
    size, entries = int(value["size"]), value["entries"]
    room = entries.type.range()[1] + 1
    if not 0 <= size <= room:
        return f"size {size}, but there is room for {room} entries only; was it set before its first use?"
    lines = [f"[{i}] from t {_number(entries[i]['enter'])}: {_node(entries[i]['node'].dereference())}"
             for i in range(size)]
    return "\n  ".join([f"{size} waiting" + (", the last comes next" if size else ""), *lines])


class _Printer:
    """Says a value in one line."""

    def __init__(self, say, value):
        self._say, self._value = say, value

    def to_string(self):
        try:
            return self._say(self._value)
        except gdb.MemoryError:
            return "(no such memory)"
        except gdb.error as error:  # a type of the student's own that only has the same name
            return f"({error}; print /r shows it raw)"


def _collection():
    printers = gdb.printing.RegexpCollectionPrettyPrinter("raykit")
    for name, say in {
        "rk_vec2": _vector, "rk_vec3": _vector, "rk_dvec3": _vector, "rk_box": _box, "rk_ray": _ray,
        "rk_hit": _hit, "rk_bvh_node": _node,
        "rk_traversal_stack": _traversal_stack,
    }.items():
        printers.add_printer(name, f"^{name}$", lambda value, say=say: _Printer(say, value))
    return printers


gdb.printing.register_pretty_printer(gdb.current_objfile(), _collection(), replace=True)


def stop_in(name):
    """From now on, whenever a signal stops the program, selects the innermost frame in the file of
    this name: a sanitizer stops deep in its own code."""

    def select():
        frame = gdb.newest_frame()
        while frame and not (frame.find_sal().symtab and frame.find_sal().symtab.filename.endswith(name)):
            frame = frame.older()
        if frame and frame != gdb.selected_frame():
            print("This is the line reached in your code (bt shows its callers):")
            gdb.execute(f"frame {frame.level()}")

    def stopped(event):
        if isinstance(event, gdb.SignalEvent):
            gdb.post_event(select)

    gdb.events.stop.connect(stopped)
