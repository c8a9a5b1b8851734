# Prints one of the parts that tools/features.sh writes. A row of the table: stem, folder, needs, uses, and
# README's words: about, picture. A suite links its own unit, the units that its feature needs, which may be
# the student's, and the kit's objects of those that it uses; in a pack the student's of what is handed out. Plain awk, so that a build needs no Python.

function fail(message) {
    print "features: " FILENAME message | "cat >&2"
    failed = 1
    exit 1
}

function exists(path, line) {
    if ((getline line < path) < 0) return 0
    close(path)
    return 1
}

function files(globs, command, name, found) {
    command = "ls -d " globs " 2>/dev/null"
    while ((command | getline name) > 0) found = found " " name
    close(command)
    return found
}

function only(names, regex, count, i, list, found) {
    count = split(names, list, " ")
    for (i = 1; i <= count; i++)
        if (list[i] ~ regex) found = found " " list[i]
    return found
}

# A pack for students has starters, whose first lines say whether another file is to be solved ("Handed
# out"), or nothing yet ("Left open").
function note_of(stem, path, line) {
    path = "src/features/" stem ".c"
    getline line < path
    close(path)
    return line ~ /^\/\* Handed out: / ? "handed out" : line ~ /^\/\* Left open: / ? "left open" : ""
}

function need_rooms(stem, folder, rooms, i) {
    split("src/features/.h src/features/.c tests/test_.c", rooms, " ")
    for (i = 1; i in rooms; i++) sub(/\./, stem ".", rooms[i])
    rooms[i] = "assignments/" folder "/driver.c"
    for (i = 1; i in rooms; i++)
        if (!exists(rooms[i])) fail(":" FNR ": there is no " rooms[i] "; make new-feature writes all files of a new feature")
}

function units_of(needs, list, i, found) {
    split(needs, list, " ")
    for (i = 1; i in list; i++) found = found " $(unit_" list[i] ")"
    return found
}

function objects_of(uses, list, i, found) {
    split(uses, list, " ")
    for (i = 1; i in list; i++)
        found = found (note_of(list[i]) == "handed out" ? " workbook/" : " src/features/") list[i] ".$(OBJEXT)"
    return found
}

# A feature's own lines; what it adds to the lists of all.
function build_one(stem, folder, needs, uses, note, unit, driver, name) {
    note = note_of(stem)
    unit = (note == "handed out" ? "workbook/" : "src/features/") stem ".c"
    driver = name = "assignments/" folder "/" stem
    gsub("/", "_", name)
    print "\nunit_" stem " = " unit
    print name "_SOURCES =" only(seen, "^assignments/" folder "/")
    print name "_LDADD = $(driver_libs)"
    print "driver-" stem " drawn-" stem " live-ready-" stem ": $(" name "_OBJECTS)"
    print "drawn-" stem ": $(if $(impl),," driver "$(EXEEXT))"
    print "live-ready-" stem ": $(if $(handed_out),," driver "$(EXEEXT))"
    print "tests_test_" stem "_SOURCES = tests/test_" stem ".c $(unit_" stem ")" units_of(needs)
    print "uses_" stem " =" objects_of(uses)
    if (uses) print "tests_test_" stem "_LDADD = $(uses_" stem ") $(LDADD)"
    drivers = drivers " " driver
    headers = headers " src/features/" stem ".h"
    units = units " $(unit_" stem ")"
    suites = suites " tests/test_" stem
    if (only(seen, "^tests/test_" stem "_stage\\.c$")) {
        print "tests_test_" stem "_stage_LDADD = $(render_libs)"
        suites = suites " tests/test_" stem "_stage"
    }
    if (note == "handed out") {
        handed_out = handed_out " " stem
        starters = starters " src/features/" stem ".c"
    }
    if (note == "left open") later = later " " stem
}

# A header that nobody outside should include says "not installed" in its first comment.
function is_internal(path, line, comment) {
    while ((getline line < path) > 0) {
        sub(/^ \*/, "", line)
        comment = comment line
        if (line ~ /\*\/$/) break
    }
    close(path)
    return comment ~ /not installed/
}

# All files of a room: headers to install, and everything else.
function room(name, globs, left_out, names, count, i, list, headers, sources) {
    patterns = patterns " " globs
    names = files(globs)
    count = split(names, list, " ")
    for (i = 1; i <= count; i++) {
        seen = seen " " list[i]
        if (left_out && list[i] ~ left_out) continue
        if (list[i] ~ /\.h$/ && !is_internal(list[i])) headers = headers " " list[i]
        else sources = sources " " list[i]
    }
    print name "_headers =" headers
    print name "_sources =" sources
}

function build_rooms() {
    print "\n# The rooms of src: all files of each."
    room("base", "src/base/*.[ch]")
    room("scene", "src/scene/*.[ch]")
    room("scenes", "src/scenes/*.[ch]")
    room("io", "src/io/*.[ch]", "helper_folder_")
    room("accel", "src/accel/*.[ch]")
    room("build", "src/accel/build/*.[ch]")
    room("kernel", "src/accel/kernel/*.[ch]")
    room("query", "src/accel/query/*.[ch]")
    room("render", "src/render/*.[ch]")
    room("stage", "src/render/stages/*.[ch]")
    room("post", "src/post/*.[ch]")
    room("driver", "src/driver/*.[ch]")
    room("mpi_module", "src/driver/mpi_module/*.[ch]")
    room("mesh_helper", "src/io/mesh_helper/*.[ch]")
    room("image_helper", "src/io/image_helper/*.h src/io/image_helper/*.cpp")
}

function build_all() {
    build_rooms()
    print "\n# What tests/stress/stress_accuracy.c searches."
    room("stress", "tests/stress/measure*.[ch] tests/stress/search.c")
    print "\n# What make bench-peers runs."
    room("peers", "tests/peers/*.[ch]")
    print "\nfeatures =" stems
    print "feature_drivers =" drivers
    print "feature_suites =" suites
    print "feature_headers = src/features/all.h src/features/list.h" headers
    print "feature_sources =" units
    print "\n# What make looks for again: a file that comes or goes changes the lists above."
    print "feature_patterns = " patterns
    print "feature_files =" seen
    print "\n# In a pack for students, the features that they solve, and those that later assignments ask for."
    print "handed_out =" handed_out
    print "later =" later
    print "starters =" starters
}

# HTML, because Markdown has no say in the breadth of columns.
function readme_cell(stem, folder, about, picture) {
    if (picture) picture = "<img src=\"docs/pictures/" stem ".png\" alt=\"" picture "\" width=\"160\"><br>"
    return "<td width=\"25%\" valign=\"top\">" picture "<a href=\"docs/" folder ".md\"><code>" stem "</code></a>: " about "</td>\n"
}

function readme(line, skips, found) {
    while ((getline line < "README.md") > 0) {
        if (line ~ /^<!-- features end/) skips = 0
        if (!skips) print line
        if (line ~ /^<!-- features:/) {
            found = skips = 1
            printf "<table>\n%s</tr>\n</table>\n", cells
        }
    }
    if (!found || skips) fail(": README.md has no line <!-- features: ... -->, or none <!-- features end --> below it")
}

BEGIN {
    written = "Written by tools/features.sh from assignments/features.tsv."
    if (part == "build") print "# " written
    else if (part != "readme") print "/* " written " */\n/* clang-format off */"
    patterns = "assignments/[0-9]*/*.[ch] tests/test_*_stage.c"
    seen = files(patterns)
}

FNR == 1 && $0 != "stem\tfolder\tneeds\tuses\tabout\tpicture" {
    fail(":1: the header should be stem, folder, needs, uses, about, picture, separated by tabs")
}

FNR > 1 {
    if (NF != 6) fail(":" FNR ": six columns are wanted, separated by tabs; here are " NF)
    need_rooms($1, $2)
    stems = stems " " $1
    cells = cells (FNR % 4 == 2 ? (FNR > 2 ? "</tr>\n" : "") "<tr>\n" : "") readme_cell($1, $2, $5, $6)
    if (part == "build") build_one($1, $2, $3, $4)
    if (part == "list") list = list "RK_FEATURE(" $1 ")\n"
    if (part == "headers") print "#include \"features/" $1 ".h\""
}

END {
    if (failed) exit 1
    if (part == "build") build_all()
    if (part == "list") printf "/* For programs that define RK_FEATURE. */\n#ifdef RK_FEATURE\n%s#endif\n", list
    if (part == "readme") readme()
}
