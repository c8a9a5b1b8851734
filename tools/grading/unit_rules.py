"""The rules for a unit's text and object, checked before it runs. A unit is plain C: functions to be
called, which compute from their arguments, and constants.

Each check returns what is wrong as the rest of a sentence that begins with the unit's name, or "".
These checks stop code that would reach around the suite by a name, an attribute, a section or
assembly. They cannot stop a pointer that is made from a number: C has no walls within a process.
"""

import functools
import re
import subprocess

from grading.assignments import ToolError

# --- The text, after the preprocessor -----------------------------------------------------------

_STRINGS = r'(?:\w*"(?:\\.|[^"\\])*"\s*)+'
_PLACING = re.compile(r'\b_*(section|alias|weakref|symver|ifunc)_*\s*\(\s*\w*"')
_UNCHECKED = re.compile(r"no_sanitize\w*|no_address_safety_analysis|disable_sanitizer_instrumentation")
_SANITIZERS = re.compile(r"__(?:asan|lsan|ubsan|msan|tsan|sanitizer)_\w+")
_LABEL = re.compile(rf"\b(?:asm|__asm|__asm__)\s*\(\s*({_STRINGS})\)")
_INLINE_ASSEMBLY = "uses inline assembly: a unit is plain C"


def fault_in_source(text):
    """Attributes that place code or switch off its checks, and the sanitizers' own functions."""
    for pattern in (_PLACING, _UNCHECKED):
        found = pattern.search(text)
        if found:
            name = found.group(1) if pattern is _PLACING else found.group()
            return f"uses the attribute {name}: a unit is plain C, and the compiler places and checks it"
    # Another name for a function, as the system's headers give it. Its text would go into the
    # assembly as it is.
    labels = ["".join(re.findall(r'"((?:\\.|[^"\\])*)"', label)) for label in _LABEL.findall(text)]
    if not all(re.fullmatch(r"[\w.$]*", label) for label in labels):
        return _INLINE_ASSEMBLY
    called = _SANITIZERS.search(text + "\n" + "\n".join(labels))
    return f"uses {called.group()}: a unit may not call the sanitizers" if called else ""


def fault_in_assembly(text):
    """Compilers mark assembly that comes from the source; that of headers is left out unless used."""
    mark = r"^\s*[#@/;!|]+\s*(APP|InlineAsm Start|Start of file scope inline assembly)\b"
    return _INLINE_ASSEMBLY if re.search(mark, text, re.MULTILINE) else ""


# --- The object ---------------------------------------------------------------------------------


# A line of objdump -t: value, flags, section, size, name.
_SYMBOL = re.compile(r"([0-9a-f]{8,}) (.{7}) (.+?)\t([0-9a-f]+) (?:\.\w+ )?(.*)")


def _symbols_of(objdump, path):
    # nm starts all plugins for link-time optimization that the machine has, which takes ten times as long.
    answer = subprocess.run([objdump, "-t", path], capture_output=True, text=True, errors="replace",
                            check=False)
    if answer.returncode:
        raise ToolError(f"{objdump} could not read {path}: {answer.stderr.strip()}")
    return answer.stdout


def global_names(objdump, path):
    """Returns the global names that an object defines."""
    symbols = (_SYMBOL.match(line) for line in _symbols_of(objdump, path).splitlines())
    return [symbol[5] for symbol in symbols if symbol and symbol[2][0] != "l" and symbol[3] != "*UND*"]


class Object:
    """What objdump tells of an object: `sections` from name to flags, `symbols` as (flags, section,
    size, name) by (section, value), `undefined` names, and `entries`, which are (section, target) of
    each pointer in a table of code that runs before or after main."""

    def __init__(self, objdump, path):
        command = [objdump, "-h", "-w", "-t", "-r", path]
        answer = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
        if answer.returncode:
            raise ToolError(f"{command[0]} could not read {path}: {answer.stderr.strip()}")
        self.sections, self.symbols, self.undefined, relocations, section = {}, [], [], [], ""
        for line in answer.stdout.splitlines():
            found = re.match(r" *\d+ (.+?) +[0-9a-f]{8,} +[0-9a-f]+ +[0-9a-f]+ +[0-9a-f]+ +2\*\*\d+ *(.*)",
                             line)
            if found:
                self.sections[found[1]] = found[2].split(", ")
            found = _SYMBOL.match(line)
            if found and found[3] == "*UND*":
                self.undefined.append(found[5])
            elif found:
                self.symbols.append((found[2], found[3], int(found[1], 16), int(found[4], 16), found[5]))
            found = re.match(r"RELOCATION RECORDS FOR \[(.*)\]:", line)
            section = found[1] if found else section
            found = re.match(r"[0-9a-f]+ R_\S+ +(\S+?)(?:\+0x([0-9a-f]+))?$", line)
            if found and re.match(r"\.(init|fini)_array", section):
                relocations.append((section, found[1], int(found[2] or "0", 16)))
        self.entries = [(kind, self._function_at(where, offset)) for kind, where, offset in relocations]

    def _function_at(self, where, offset):
        names = [name for flags, section, value, _, name in self.symbols
                 if "F" in flags and section == where and value == offset]
        return names[0] if names else where


# Sections that compilers make of functions and data, with sanitizers or without.
_CODE = re.compile(r"\.text(\..*)?$")
_CONSTANTS = re.compile(r"\.(l?rodata|srodata|eh_frame|gcc_except_table|note|ARM\.ex\w+)(\..*)?$")
_DATA = re.compile(r"\.(l?data|l?bss|sdata|sbss|tdata|tbss|toc)(\..*)?$|asan_globals$")
_RELOCATED_CONSTANTS = re.compile(r"\.data\.rel\.ro\b")
_TABLES = re.compile(r"\.(init|fini)_array(\..*)?$")
_SANITIZERS_OWN = re.compile(r"_sub_[ID]_\d+_\d+$|asan\.module_[cd]tor(\.\d+)?$")
_SANITIZERS_DATA = re.compile(r"__unnamed_\d+$|_*(odr_)?asan[._]")


def fault_in_object(obj, sanitized):
    """Code that runs before or after main could fake a verdict; only the sanitizer's own may."""
    early = any("i" in flags for flags, *_ in obj.symbols)  # chosen when the program is loaded
    for name, flags in obj.sections.items():
        if "ALLOC" not in flags or _TABLES.match(name):
            continue
        code, constant = "CODE" in flags, "READONLY" in flags
        if re.match(r"\.(preinit_array|ctors|dtors|init|fini)\b", name):
            early = True
        elif not (_CODE.match(name) and constant or _CONSTANTS.match(name) and constant and not code
                  or _DATA.match(name) and not code):
            return f"has a section {name}: a unit contains only functions to be called, and constants"
    kinds = [section.split(".")[1] for section, _ in obj.entries]
    foreign = [name for _, name in obj.entries if not _SANITIZERS_OWN.match(name)]
    if early or foreign or any(kinds.count(kind) > (1 if sanitized else 0) for kind in kinds):
        return ("has code that runs before or after the tests (a constructor or destructor); "
                "a unit contains only functions to be called")
    return ""


def kept_data(obj):
    """Returns the names of the unit's variables that last from call to call."""
    names = []
    for flags, section, _, size, name in obj.symbols:
        place = obj.sections.get(section, [])
        writable = section == "*COM*" or ("ALLOC" in place and "READONLY" not in place
                                          and _DATA.match(section)
                                          and not _RELOCATED_CONSTANTS.match(section))
        if writable and size and "d" not in flags and not _SANITIZERS_DATA.match(name):
            # Of a variable within a function gcc makes list.0, clang rk_bvh_closest.list.
            names.append(re.sub(r"\.\d+$", "", name).rpartition(".")[2])
    return list(dict.fromkeys(names))


# --- What a unit may use ------------------------------------------------------------------------

_MATH = """
    acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp10 exp2 expm1
    fabs fdim floor fma fmax fmin fmod frexp hypot ilogb ldexp lgamma llrint llround
    log log10 log1p log2 logb lrint lround modf nan nearbyint nextafter nexttoward pow remainder remquo
    rint round scalbln scalbn sin sincos sinh sqrt tan tanh tgamma trunc"""
_STANDARD = """
    memccpy memchr memcmp memcpy memmem memmove memset stpcpy stpncpy strcat strchr strcmp strcpy strcspn
    strdup strerror strlen strncat strncmp strncpy strndup strnlen strpbrk strrchr strspn strstr
    abort abs labs llabs div ldiv lldiv qsort qsort_r bsearch
    atof atoi atol strtod strtof strtol strtoll strtoul strtoull
    aligned_alloc calloc free madvise malloc posix_memalign realloc
    fflush fprintf fputc fputs fwrite printf putc putchar puts snprintf sprintf stderr stdout vfprintf vprintf
    vsnprintf vsprintf __assert_fail __assert __errno_location ___errno_location"""
_C = {name + suffix for name in _MATH.split() for suffix in ("", "f", "l")} | set(_STANDARD.split())
# Calls that compilers make of their own accord: for sanitizers, hardening and wide arithmetic.
_COMPILERS = re.compile(
    r"__asan_(init|version_mismatch_check_\w+|handle_no_return|option_detect_stack_use_after_return"
    r"|report_\w+|(exp_)?(load|store)\w+|(un)?register_\w*globals|stack_(malloc|free)\w+|set_shadow_\w+"
    r"|mem(cpy|move|set)|(un)?poison_stack_memory|alloca_poison|allocas_unpoison"
    r"|shadow_memory_dynamic_address)"
    r"|___asan_globals_registered|__(start|stop)_asan_globals|__ubsan_handle_\w+|__stack_chk_(fail|guard)"
    r"|_GLOBAL_OFFSET_TABLE_|__cpu_model|__cpu_indicator_init|_Unwind_Resume|__gcc_personality_v0"
    r"|__(fpclassify|signbit|isnan|isinf|finite)[fl]?|__[a-z]+(si|di|ti|hf|sf|df|xf|tf|sc|dc|xc|tc)\d?"
)


def _plain(name):
    """Returns a function's name as a unit calls it, of one that is hardened, or of a certain standard."""
    is_changed = name.endswith("_chk") or name.startswith("__isoc")
    return re.sub(r"^__(isoc\d+_)?(\w+?)(_chk)?$", r"\2", name) if is_changed else name


def _is_c(name):
    return name in _C or _plain(name) in _C or _COMPILERS.fullmatch(name) is not None


@functools.lru_cache
def pure_names(objdump, archive):
    """Returns the archive's functions that use nothing but C's and each other: no files, no threads."""
    defined, used, module = {}, {}, ""
    for line in _symbols_of(objdump, archive).splitlines():
        begins, symbol = re.match(r"(\S+): +file format ", line), _SYMBOL.match(line)
        if begins:
            module = begins[1]
        elif symbol and symbol[3] == "*UND*":
            used.setdefault(module, set()).add(symbol[5])
        elif symbol and symbol[2][0] != "l":
            defined.setdefault(module, set()).add(symbol[5])
    pure = set(defined)
    while True:
        names = {name for module in pure for name in defined[module]}
        kept = {module for module in pure
                if all(_is_c(name) or name in names for name in used.get(module, ()))}
        if kept == pure:
            return frozenset(names)
        pure = kept


def fault_in_names(obj, kit, with_line=str):
    """Functions and variables that are neither C's, as far as units need it, nor the kit's. `with_line` adds
    to a name where the unit has it."""
    strange = [with_line(_plain(name)) for name in obj.undefined if not _is_c(name) and name not in kit]
    if not strange:
        return ""
    return (f"uses {' and '.join(strange[:3])}, which a unit may not: it may call the kit's functions that "
            "need no files and no threads, those of math.h and string.h, and those for memory, sorting and "
            "printing of stdlib.h and stdio.h")
