"""The rules for a unit's text and object, checked before it runs. A unit is plain C: functions to be
called, which compute from their arguments, and constants.

Each check returns what is wrong as the rest of a sentence that begins with the unit's name, or "".
These checks stop code that would reach around the suite by a name, an attribute, a section or
assembly. They cannot stop a pointer that is made from a number: C has no walls within a process.
"""

import functools
import os
import re
import subprocess

from grading.assignments import ToolError

# --- The text, after the preprocessor -----------------------------------------------------------

_MARKER = re.compile(r"^# \d+ .*$", re.MULTILINE)  # of the preprocessor: a place in a file
_DIRECTIVE = re.compile(r"^[ \t]*(?:#|%:|\?\?=)[ \t]*(.*)$", re.MULTILINE)
_PRAGMAS = re.compile(r"pragma (?:STDC|omp|once|pack|region|endregion|mark|push_macro|pop_macro|message"
                      r"|warning|comment|ivdep"
                      r"|GCC (?:diagnostic|optimize|target|unroll|ivdep|poison|system_header|push_options"
                      r"|pop_options|visibility|warning|error)"
                      r"|clang (?:diagnostic|loop|fp|optimize|system_header|assume_nonnull))\b|$")
_STRINGS = r'(?:\w*"(?:\\.|[^"\\])*"\s*)+'
_SANITIZERS = re.compile(r"__(?:asan|lsan|ubsan|msan|tsan|sanitizer|odr_asan)[_.]\w+|__unnamed_\d+")
_LABEL = re.compile(rf"\b(?:asm|__asm|__asm__)\s*\(\s*({_STRINGS})\)")
_INLINE_ASSEMBLY = "uses inline assembly: a unit is plain C"

# Attributes that say something of a function or of data, and neither place them nor switch off checks.
_ATTRIBUTES = frozenset("""
    access aligned alloc_align alloc_size always_inline artificial assume assume_aligned availability
    align_value bounded cleanup cold common const convergent copy counted_by deprecated diagnose_if
    disable_tail_calls enable_if enum_extensibility error ext_vector_type fallthrough fd_arg fd_arg_read
    fd_arg_write flag_enum flatten format format_arg gnu_inline hot internal_linkage leaf likely malloc
    maybe_unused may_alias min_vector_width minsize mode ms_struct gcc_struct nocommon nodebug nodiscard
    noescape noinline noipa noclone nonnull nonstring noplt noreturn _Noreturn not_tail_called nothrow
    null_terminated_string_arg objc_bridge optimize optnone overloadable packed pass_object_size pure
    reproducible returns_nonnull returns_twice scalar_storage_order sentinel simd swift_name target
    transparent_union unavailable uninitialized unlikely unsequenced unused used vector_size visibility
    weak warning warn_if_not_aligned warn_unused_result""".split())
_QUOTED = r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\''
_WORD = re.compile(_QUOTED + r"|[A-Za-z_$][\w$]*|::|<:|:>|\w+|[^\s\w]")
_KEYWORDS = ("__attribute__", "__attribute")
_BEGINNING = re.compile(_QUOTED + r"|\b__attribute(?:__)?\b|(?:\[|<:)\s*(?:\[|<:)")


class _Attribute:
    """Reads words from the beginning of an attribute to its end, and others within it, in one pass."""

    def __init__(self):
        self._brackets = []  # the open ones: whether they list attributes
        self._to_open, self._last = 0, ""

    def names(self, word):
        """Takes the next word, and returns whether it names an attribute."""
        lists, last = self._brackets and self._brackets[-1], self._last
        self._last = word
        if word in _KEYWORDS:
            self._to_open = 2
            return False
        if word in ("(", "[", "<:", "{"):
            self._to_open -= self._to_open > 0
            is_list = self._to_open == 0 and (word == "(" and self._was_to_open or
                                              word in ("[", "<:") and last in ("[", "<:"))
            self._was_to_open = self._to_open > 0
            self._brackets.append(is_list)
        elif word in (")", "]", ":>", "}") and self._brackets:
            self._brackets.pop()
        return bool(lists) and last in ("(", "[", "<:", ",", "::") and (word[0].isalpha() or word[0] in "_$")

    _was_to_open = False

    def has_ended(self):
        return not self._brackets and not self._to_open


def _attributes_of(text):
    """Yields the name of each attribute, __attribute__((name)) or [[prefix::name]]."""
    at = 0
    while found := _BEGINNING.search(text, at):
        at = found.end()
        if found.group()[0] in "\"'":
            continue
        attribute = _Attribute()
        for word in _WORD.finditer(text, found.start()):
            at = word.end()
            if attribute.names(word.group()):
                yield word.group()
            if attribute.has_ended():
                break


@functools.lru_cache(maxsize=1024)  # system headers have thousands, of a few names
def _bare(name):
    return re.sub(r"^__(\w+?)__$", r"\1", name)


def _fault_in_attribute(name, with_line):
    bare, shown = _bare(name), with_line(name)
    if bare in ("constructor", "destructor"):
        return (f"has code that runs before or after the tests (the attribute {shown}); a unit contains only "
                "functions to be called")
    if bare in ("ifunc", "target_clones"):
        return (f"uses the attribute {shown}: the function is then chosen while the program is loaded; "
                "choose it in the code, or use target alone")
    return (f"uses the attribute {shown}: a unit is plain C, and the compiler places and checks it; leave "
            "the attribute out")


def without_version(text):
    """Returns a text without what #ident says, which would go into the assembly as it is."""
    return re.sub(r"^[ \t]*(?:#|%:)[ \t]*(?:ident|sccs)\b.*$", "", text, flags=re.MULTILINE)


def fault_in_source(text, with_line=str):
    """Attributes that place code or switch off its checks, directives that are left, and the sanitizers'
    own functions. `with_line` adds to a name where the unit has it."""
    text = _MARKER.sub("", text)
    for name in _attributes_of(text):
        # gnu::x and clang::x name the prefix first.
        if _bare(name) not in _ATTRIBUTES and name not in ("gnu", "clang", "__gnu__", "_Clang"):
            return _fault_in_attribute(name, with_line)
    for directive in _DIRECTIVE.finditer(text):
        if not _PRAGMAS.match(" ".join(directive[1].split())):
            return f"uses #{' '.join(directive[1].split())[:60]}: a unit is plain C; leave that line out"
    # Another name for a function, as the system's headers give it. Its text would go into the
    # assembly as it is.
    labels = ["".join(re.findall(r'"((?:\\.|[^"\\])*)"', label)) for label in _LABEL.findall(text)]
    if not all(re.fullmatch(r"[\w.$]*", label) for label in labels):
        return _INLINE_ASSEMBLY
    called = _SANITIZERS.search(text + "\n" + "\n".join(labels))
    return f"uses {called.group()}: a unit may not call the sanitizers" if called else ""


def fault_in_assembly(text):
    """Compilers mark assembly that comes from the source; that of headers is left out unless used."""
    mark = r"^[ \t]*[#@/;!|]+[ \t]*(APP|InlineAsm Start|Start of file scope inline assembly)\b"
    return _INLINE_ASSEMBLY if re.search(mark, text, re.MULTILINE) else ""


# --- The object ---------------------------------------------------------------------------------


# A line of objdump -t: value, flags, section, size, name.
_SYMBOL = re.compile(r"([0-9a-f]{8,}) (.{7}) (.+?)\t([0-9a-f]+) (?:\.\w+ )?(.*)")


def _symbols_of(objdump, path):
    """Returns the lines of objdump -t, which is asked once for a file that does not change."""
    try:
        state = os.stat(path)
    except OSError as error:
        raise ToolError(f"{path} cannot be read: {error.strerror}") from error
    return _read_symbols(objdump, path, (state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns))


@functools.lru_cache(maxsize=64)
def _read_symbols(objdump, path, _):
    # nm starts all plugins for link-time optimization that the machine has, which takes ten times as long.
    answer = subprocess.run([objdump, "-t", path], capture_output=True, text=True, errors="replace",
                            check=False)
    if answer.returncode:
        raise ToolError(f"{objdump} could not read {path}: {answer.stderr.strip()}")
    return answer.stdout.splitlines()


def global_names(objdump, path):
    """Returns the global names that an object defines."""
    symbols = (_SYMBOL.match(line) for line in _symbols_of(objdump, path))
    return [symbol[5] for symbol in symbols if symbol and symbol[2][0] != "l" and symbol[3] != "*UND*"]


class Object:
    """What objdump tells of an object: `sections` from name to flags, `sizes` of sections in bytes, `symbols`
    as (flags, section, value, size, name), `undefined` names, and `entries`, which are (section, target) of
    each pointer in a table of code that runs before or after main."""

    def __init__(self, objdump, path, around=None):
        """`around` puts a command into a sandbox."""
        command = [objdump, "-h", "-w", "-t", "-r", path]
        answer = subprocess.run(around(command) if around else command, capture_output=True, text=True,
                                errors="replace", check=False)
        if answer.returncode:
            raise ToolError(f"{command[0]} could not read {path}: {answer.stderr.strip()}")
        self.sections, self.sizes, self.symbols, self.undefined = {}, {}, [], []
        relocations, section = [], ""
        for line in answer.stdout.splitlines():
            found = re.match(r" *\d+ (.+?) +([0-9a-f]{8,}) +[0-9a-f]+ +[0-9a-f]+ +[0-9a-f]+ +2\*\*\d+ *(.*)",
                             line)
            if found:
                self.sections[found[1]], self.sizes[found[1]] = found[3].split(", "), int(found[2], 16)
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
        functions = {(section, value): name for flags, section, value, _, name in reversed(self.symbols)
                     if "F" in flags}
        self.entries = [(kind, functions.get((where, offset), where)) for kind, where, offset in relocations]


# Sections that compilers make of functions and data, with sanitizers or without.
_CODE = re.compile(r"\.text(\..*)?$")
_CONSTANTS = re.compile(r"\.(l?rodata|srodata|eh_frame|gcc_except_table|note|ARM\.ex\w+)(\..*)?$")
_DATA = re.compile(r"\.(l?data|l?bss|sdata|sbss|tdata|tbss|toc)(\..*)?$|asan_globals$")
_RELOCATED_CONSTANTS = re.compile(r"\.data\.rel\.ro\b")
_TABLES = re.compile(r"\.(init|fini)_array(\..*)?$")
_SANITIZERS_OWN = re.compile(r"_sub_[ID]_\d+_\d+$|asan\.module_[cd]tor(\.\d+)?$")
_SANITIZERS_DATA = re.compile(r"(__unnamed_\d+|__odr_asan[._].+|_*__asan_(gen_[\w.]*|globals_registered))$")


def fault_in_object(obj, sanitized):
    """Code that runs before or after main could fake a verdict; only the sanitizer's own may."""
    if any("i" in flags for flags, *_ in obj.symbols):
        return ("has a function that is chosen while the program is loaded (ifunc, target_clones), before "
                "the tests run; choose it in the code")
    early = False
    for name, flags in obj.sections.items():
        if "ALLOC" not in flags:
            continue
        if _TABLES.match(name):
            # An entry that is a number has no relocation: no byte may be more than the entries' own.
            own = sum(kind == name for kind, _ in obj.entries)
            early = early or obj.sizes[name] > 8 * own
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
    acos acosh asin asinh atan atan2 atanh canonicalize cbrt ceil copysign cos cosh drem erf erfc exp
    exp10 exp2 expm1 fabs fdim finite floor fma fmax fmaxmag fmin fminmag fmod frexp fromfp fromfpx gamma
    getpayload hypot ilogb isinf isnan j0 j1 jn ldexp lgamma lgamma_r llogb llrint llround log log10 log1p
    log2 logb lrint lround modf nan nearbyint nextafter nextdown nexttoward nextup pow pow10 remainder
    remquo rint round roundeven scalb scalbln scalbn setpayload setpayloadsig significand sin sincos sinh
    sqrt tan tanh tgamma totalorder totalordermag trunc ufromfp ufromfpx y0 y1 yn cabs cacos cacosh carg
    casin casinh catan catanh ccos ccosh cexp cimag clog clog10 conj cpow cproj creal csin csinh csqrt
    ctan ctanh"""
_STANDARD = """
    memccpy memchr memcmp memcpy memfrob memmem memmove mempcpy memrchr memset rawmemchr stpcpy stpncpy
    strcasestr strcat strchr strchrnul strcmp strcoll strcpy strcspn strdup strerror strerror_r strlen
    strncat strncmp strncpy strndup strnlen strpbrk strrchr strsep strspn strstr strtok strtok_r
    strverscmp strxfrm swab bcmp bcopy bzero explicit_bzero ffs ffsl ffsll index rindex strcasecmp
    strncasecmp isalnum isalpha isascii isblank iscntrl isdigit isgraph islower isprint ispunct isspace
    isupper isxdigit toascii tolower toupper __ctype_b_loc __ctype_tolower_loc __ctype_toupper_loc
    __ctype_get_mb_cur_max abort abs imaxabs imaxdiv labs llabs div ldiv lldiv qsort qsort_r bsearch atof
    atoi atol atoll strtod strtof strtoimax strtol strtold strtoll strtoul strtoull strtoumax sscanf
    vsscanf aligned_alloc calloc free madvise malloc posix_memalign realloc reallocarray fflush fprintf
    fputc fputs fwrite perror printf putc putchar puts snprintf sprintf stderr stdout vfprintf vprintf
    vsnprintf vsprintf __assert_fail __assert __errno_location ___errno_location __fpclassify __signbit"""
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
    name = re.sub(r"^__(sysv|xpg|posix)_|^__?(?=(sig)?setjmp$)", "", name)
    is_changed = name.endswith("_chk") or name.startswith("__isoc")
    return re.sub(r"^__(isoc\d+_)?(\w+?)(_chk)?$", r"\2", name) if is_changed else name


def _is_c(name):
    return name in _C or _plain(name) in _C or _COMPILERS.fullmatch(name) is not None


@functools.lru_cache
def pure_names(objdump, archive):
    """Returns the archive's functions that use nothing but C's and each other: no files, no threads."""
    defined, used, module = {}, {}, ""
    for line in _symbols_of(objdump, archive):
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


_RANDOM, _TIME = ("for random numbers take rk_hash of base/random.h, which gives the same ones each time",
                  "a result may not depend on the time")
_ROUNDING = "the rounding mode is the caller's: choose floor, ceil or rint instead"
_INSTEAD = {
    "exit": "to end with an error, return false; to stop at a mistake of your own, use assert",
    **dict.fromkeys(("rand", "srand", "random", "srandom", "drand48", "rand_r"), _RANDOM),
    **dict.fromkeys(("clock", "time", "clock_gettime", "gettimeofday", "timespec_get"), _TIME),
    **dict.fromkeys(("fesetround", "fegetround", "fesetenv", "feenableexcept"), _ROUNDING),
    "getenv": "a result may not depend on the environment",
    "fopen": "a unit has no files: what it needs comes as arguments",
    "pthread_create": "a unit has one thread: the renderer calls it from several",
}


def fault_in_names(obj, kit, with_line=str):
    """Functions and variables that are neither C's, as far as units need it, nor the kit's. `with_line` adds
    to a name where the unit has it."""
    strange = [with_line(_plain(name)) for name in obj.undefined if not _is_c(name) and name not in kit]
    if not strange:
        return ""
    advice = {_INSTEAD[name]: None for name in obj.undefined if name in _INSTEAD}  # each once
    return "; ".join([
        f"uses {' and '.join(strange[:3])}, which is not allowed: a unit may call the kit's functions that "
        "need no files and no threads, those of math.h, complex.h, string.h and ctype.h, and those for "
        "memory, sorting, printing and numbers in text of stdlib.h and stdio.h", *advice])
