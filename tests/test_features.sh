#!/bin/sh
# What is said of features beside the table is what the table says.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
source=${srcdir:-.}
echo 1..2
if AWK="${AM_TAP_AWK:-awk}" "$source/tools/features.sh" --readme | cmp -s - "$source/README.md"; then
    echo "ok 1 - README's table is that of assignments/features.tsv"
else
    echo "# README.md tells of other features, or in other words, than assignments/features.tsv; make readme-table writes it"
    echo "not ok 1 - README's table is that of assignments/features.tsv"
fi

# Of two features that stand on bvh_median, one needs it from the student, the other uses the kit's.
table=$(mktemp) && trap 'rm -f "$table"' EXIT
printf '%s\t%s\t%s\t%s\ta\tb\n' stem folder needs uses bvh_median 01_bvh_median "" "" \
    sah_binning 02_sah_binning bvh_median "" shading 03_shading "" bvh_median |
    sed '1s/a\tb/about\tpicture/' >"$table"
wanted='tests_test_sah_binning_SOURCES = tests/test_sah_binning.c $(unit_sah_binning) $(unit_bvh_median)
tests_test_shading_SOURCES = tests/test_shading.c $(unit_shading)
uses_shading = src/features/bvh_median.$(OBJEXT)
tests_test_shading_LDADD = $(uses_shading) $(LDADD)'
links=$(cd "$source" && LC_ALL=C "${AM_TAP_AWK:-awk}" -F '\t' -v part=build -f tools/features.awk "$table" |
    grep -E '^(uses_shading|tests_test_(sah_binning|shading)_(SOURCES|LDADD)) ')
if [ "$links" = "$wanted" ]; then
    echo "ok 2 - a suite links the units that it needs, and the kit's objects of those that it uses"
else
    echo "$links" | sed 's/^/# /'
    echo "not ok 2 - a suite links the units that it needs, and the kit's objects of those that it uses"
fi
