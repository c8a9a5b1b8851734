#!/bin/sh
# Includes and calls go up only: a folder of src uses those named after it below, headers do not include each
# other in a circle, and a reader finds each function in the file that is named like its header. Each file says what
# it is for, and the build's own files stay readable, too.
set -u
[ "${1-}" != --list ] || exit 0 # the test driver asks for test names; there is nothing to choose from
objects=$PWD/src
cd "${srcdir:-.}/src" || exit 1

# folder: the folders that it may include
allowed="base:
scene: base
io: base scene
scenes: base scene
features: base scene
accel: base scene features
render: base scene features accel
post: base scene features accel render
driver: base scene io scenes features accel render post"

includes() {
    find . -name '*.[ch]' | LC_ALL=C sort | xargs awk '
        match($0, /^#include "[^"]+"/) {
            print substr(FILENAME, 3), FNR, substr($0, RSTART + 10, RLENGTH - 11)
        }'
}

only_upwards() {
    includes | awk -v allowed="$allowed" '
        BEGIN {
            count = split(allowed, rows, "\n")
            for (i = 1; i <= count; i++) {
                folder = rows[i]; sub(/:.*/, "", folder)
                known[folder] = 1
                names = split(rows[i], name, " ")
                for (k = 2; k <= names; k++) may[folder, name[k]] = 1
            }
        }
        {
            from = $1; to = $3
            if (!sub(/\/.*/, "", from)) next # raykit.h includes everything
            sub(/\/.*/, "", to)
            if (!(from in known)) {
                print "src/" $1 ":" $2 ": the folder " from " is not in the table of tests/test_includes.sh; add it"
            } else if (from != to && !((from, to) in may)) {
                print "src/" $1 ":" $2 ": " from " may not include " $3 "; move what is used there into a folder that both may include"
            }
        }'
}

# Depth-first from each header: one that is still open closes a circle.
no_circles() {
    includes | awk '
        function visit(file, way, i) {
            if (state[file] == "done") return
            if (state[file] == "open") {
                print "src/" way file ": headers in a circle; declare a struct in one instead of including its header"
                return
            }
            state[file] = "open"
            for (i = 1; i <= count[file]; i++) visit(uses[file, i], way file " -> ")
            state[file] = "done"
        }
        $1 ~ /\.h$/ { uses[$1, ++count[$1]] = $3; files[$1] }
        END { for (file in files) visit(file, "") }'
}

# X.c belongs to X.h. A unit of several files says so: their first comments name its header.
own_headers() {
    find . -name '*.c' | LC_ALL=C sort | while read -r file; do
        file=${file#./}
        [ ! -e "${file%.c}.h" ] && ! grep -q '^int main(' "$file" || continue
        header=$(awk '{ print } /\*\// { exit }' "$file" | grep -o '[a-z_]*/[a-z_/]*\.h' | head -n 1)
        [ -n "$header" ] && [ -e "$header" ] ||
            echo "src/$file:1: there is no src/${file%.c}.h; add it, or name in the first comment the header that it implements"
    done
}

# The same of what is called, by the symbols of the objects. Only a feature's descriptor may be named from anywhere: the
# lists of features are made of these.
symbols() {
    (find . -name '*.c' | sed 's/c$/o/' && cd "$objects" && find . -name '*.o') | LC_ALL=C sort | uniq -d |
        (cd "$objects" && xargs "${NM:-nm}" -A -P -g)
}
calls_upwards() {
    symbols | awk -v allowed="$allowed" '
        BEGIN {
            count = split(allowed, rows, "\n")
            for (i = 1; i <= count; i++) {
                folder = rows[i]; sub(/:.*/, "", folder)
                names = split(rows[i], name, " ")
                for (k = 2; k <= names; k++) may[folder, name[k]] = 1
            }
        }
        { sub(/:$/, "", $1); sub(/^\.\//, "", $1) }
        $3 == "U" { from[++uses] = $1; what[uses] = $2; next }
        { home[$2] = $1 }
        END {
            if (!uses) print "there is nothing to look at: run make"
            for (i = 1; i <= uses; i++) {
                to = home[what[i]]
                split(from[i], a, "/"); split(to, b, "/")
                if (to != "" && a[1] != b[1] && !((a[1], b[1]) in may) && what[i] !~ /^rk_[a-z_]*_feature$/)
                    print "src/" from[i] ": " a[1] " may not use " what[i] " of src/" to
            }
        }'
}

opening_comments() {
    find . -name '*.[ch]' -o -name '*.cpp' | LC_ALL=C sort | xargs awk '
        FNR == 1 && !/^\/[*\/]/ { print "src/" substr(FILENAME, 3) ":1: begin with a comment: what the file does, and how" }'
}

# A public name begins with the stem of its header, or as the table of prefixes in the glossary says; and each row of
# the table serves a name.
names_by_module() {
    find . -name '*.h' | LC_ALL=C sort | xargs awk '
        function words(text, pattern, list,   count) {
            for (count = 0; match(text, "`" pattern "`"); text = substr(text, RSTART + RLENGTH))
                list[++count] = substr(text, RSTART + 1, RLENGTH - 2)
            return count
        }
        function stem_of(file) { sub(/.*\//, "", file); sub(/(_stage)?s?(\.h)?$/, "", file); return file }
        FNR == 1 { stem = stem_of(FILENAME) }
        FILENAME ~ /\.md$/ {
            if (/^## /) in_table = /glossary-prefixes/
            split($0, cell, "|")
            for (i = in_table ? words(cell[2], "rk_[a-z0-9_]*", prefix) : 0; i > 0; i--)
                for (k = words(cell[3], "[a-z0-9_/.]*", module); k > 0; k--) row[stem_of(module[k]), prefix[i]] = FNR
            next
        }
        /^[a-zA-Z}].*rk_/ && !/^struct [a-z0-9_]*;/ {
            name = $0; sub(/\(\*/, "", name); sub(/ *[][(){=;].*/, "", name); sub(/.*[ *]/, "", name)
            known = name !~ /^rk_/ || index(name, "rk_" stem) == 1
            for (pair in row) {
                split(pair, part, SUBSEP)
                if (part[1] == stem && index(name, part[2]) == 1) known = used[pair] = 1
            }
            if (!known) print "src/" substr(FILENAME, 3) ":" FNR ": name " name " after the file, or add its prefix to docs/glossary.md"
        }
        END {
            for (pair in row)
                if (!(pair in used)) {
                    split(pair, part, SUBSEP)
                    print "docs/glossary.md:" row[pair] ": no name of " part[1] " begins with " part[2] "; remove it"
                }
        }' ../docs/glossary.md
}

# Makefile.am and its parts, but for features.am, which a program writes; a tab counts as eight columns.
short_rules() {
    (cd .. && for file in Makefile.am $(sed -n 's/^include //p' Makefile.am); do
        [ "$file" = features.am ] || expand "$file" | awk -v file="$file" 'length > 120 {
            print file ":" NR ": " length " columns; break the line, or give a part of it a name, within 120 columns" }'
    done)
}

number=0
check() {
    number=$((number + 1))
    complaints=$("$1")
    if [ -z "$complaints" ]; then
        echo "ok $number - $2"
    else
        echo "$complaints" | sed 's/^/# /'
        echo "not ok $number - $2"
    fi
}

echo 1..7
check only_upwards "includes go up only"
check no_circles "headers form no circle"
check own_headers "each file has its header"
check opening_comments "each file opens with its purpose"
check names_by_module "public names tell their module"
check short_rules "build files have no line over 120 columns"
if [ -f "$objects/base/error.o" ]; then
    check calls_upwards "calls go up only"
else
    echo "ok 7 - calls go up only # SKIP nothing is built"
fi
