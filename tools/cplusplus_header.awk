# Makes a header of C usable from C++, when it is installed: what follows its includes has C's
# linkage. There it counts as a system header, because C++ compilers warn of compound literals.
# usage: awk -f cplusplus_header.awk header header     (it is read twice)
NR == FNR {
    if (/^#if/) depth++
    if (/^#include/) includes = depth
    if (/^#endif/) depth--
    if (depth == 1 && /^[A-Za-z]/) begun = 1 # includes that follow are part of a declaration
    if (depth == 1 && !begun && (/^#include/ || /^#define/ || (/^#endif/ && includes > 1))) after = FNR
    if (depth == 1) includes = 0
    if (/^#endif/) last = FNR
    next
}
/^#error "the source folder/ { next }
FNR == last { print "#ifdef __cplusplus\n}\n#endif\n" }
{ print }
FNR == after { print "\n#ifdef __cplusplus\n#pragma GCC system_header\nextern \"C\" {\n#endif" }
