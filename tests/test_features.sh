#!/bin/sh
# What is said of features beside the table is what the table says.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
source=${srcdir:-.}
echo 1..1
if AWK="${AM_TAP_AWK:-awk}" "$source/tools/features.sh" --readme | cmp -s - "$source/README.md"; then
    echo "ok 1 - README's table is that of assignments/features.tsv"
else
    echo "# README.md tells of other features, or in other words, than assignments/features.tsv; make readme-table writes it"
    echo "not ok 1 - README's table is that of assignments/features.tsv"
fi
