#!/bin/sh
# What is said of features beside the table is what the table says; of tools, what they say of themselves.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
source=${srcdir:-.}
[ -e "$source/docs/tools.md" ] && echo 1..6 || echo 1..4 # packs have no such page, and no solutions
if AWK="${AM_TAP_AWK:-awk}" "$source/tools/features.sh" --readme | cmp -s - "$source/README.md"; then
    echo "ok 1 - README's table is that of assignments/features.tsv"
else
    echo "# README.md tells of other features, or in other words, than assignments/features.tsv; make readme-table writes it"
    echo "not ok 1 - README's table is that of assignments/features.tsv"
fi

# Of two features that stand on bvh_median, one needs it from the student, the other uses the kit's; a pack that hands it
# out has only the student's.
folder=$(mktemp -d) && trap 'rm -rf "$folder"' EXIT
kit=$(cd "$source" && pwd)
mkdir -p "$folder/src/features"
ln -s "$kit/assignments" "$kit/tests" "$kit/tools" "$folder"
ln -s "$kit"/src/features/* "$folder/src/features"
rm "$folder/src/features/bvh_median.c"
printf '%s\t%s\t%s\t%s\ta\tb\n' stem folder needs uses bvh_median 01_bvh_median "" "" \
    sah_binning 02_sah_binning bvh_median "" shading 03_shading "" bvh_median |
    sed '1s/a\tb/about\tpicture/' >"$folder/table.tsv"
check_links() { # number, beginning of bvh_median.c, folder of what shading uses, claim
    echo "$2" >"$folder/src/features/bvh_median.c"
    links=$(cd "$folder" && LC_ALL=C "${AM_TAP_AWK:-awk}" -F '\t' -v part=build -f tools/features.awk table.tsv |
        grep -E '^(uses_shading|tests_test_(sah_binning|shading)_(SOURCES|LDADD)) ')
    if [ "$links" = 'tests_test_sah_binning_SOURCES = tests/test_sah_binning.c $(unit_sah_binning) $(unit_bvh_median)
tests_test_shading_SOURCES = tests/test_shading.c $(unit_shading)
uses_shading = '"$3"'/bvh_median.$(OBJEXT)
tests_test_shading_LDADD = $(uses_shading) $(LDADD)' ]; then
        echo "ok $1 - $4"
    else
        echo "$links" | sed 's/^/# /'
        echo "not ok $1 - $4"
    fi
}
check_links 2 "/* A tree. */" src/features "a suite links the units that it needs, and the kit's objects of those that it uses"
check_links 3 "/* Handed out: the starter. */" workbook "in a pack, what is used and handed out is the student's"

# Or a pack that leaves the triangle test open would run them. Features' suites pass with its starter.
hidden=
for file in $(cd "$source" && grep -lE 'rk_triangle_closest|rk_watertight_|closed_mesh\.h|test_soup\.h' tests/test_*.c); do
    suite=$(basename "$file" .c)
    grep -qE "^tests_${suite}_(SOURCES = .*\\\$\\(unit_|LDADD = \\\$\\(render_libs)" "$source/tests/tests.am" "$source/features.am" ||
        hidden="$hidden $suite"
done
if [ -z "$hidden" ]; then
    echo "ok 4 - a suite that calls the triangle test names its unit"
else
    echo "# these take it from librkbase.a:$hidden"
    echo "not ok 4 - a suite that calls the triangle test names its unit"
fi

claim="docs/tools.md says of each file what the file says of itself"
if [ ! -e "$source/docs/tools.md" ]; then
    :
elif ! command -v python3 >/dev/null; then
    echo "ok 5 - $claim # SKIP there is no python3"
elif complaint=$(python3 -B "$source/tools/tools_page.py" --source "$source" --check 2>&1); then
    echo "ok 5 - $claim"
else
    echo "$complaint" | sed 's/^/# /'
    echo "not ok 5 - $claim"
fi

claim="the places where the kit does a step in other words, which packs report, are there"
if [ ! -e "$source/docs/tools.md" ]; then
    :
elif ! command -v python3 >/dev/null; then
    echo "ok 6 - $claim # SKIP there is no python3"
elif complaint=$(python3 -B - "$source" <<'EOF' 2>&1
import sys
from types import SimpleNamespace
sys.path.insert(0, sys.argv[1] + "/tools")
from grading import leak_check
leak_check.steps_elsewhere(sys.argv[1], [SimpleNamespace(stem=stem) for stem, *_ in leak_check.SAME_STEPS])
EOF
); then
    echo "ok 6 - $claim"
else
    echo "$complaint" | sed 's/^/# /'
    echo "not ok 6 - $claim"
fi
