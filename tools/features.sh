#!/bin/sh
# Writes what follows from assignments/features.tsv, the one list of features:
#
#   features.am          the build's lists, which Makefile.am includes
#   src/features/list.h  RK_FEATURE(stem) for each feature, in the table's order
#   src/features/all.h   includes their headers
#
# A file that would stay the same is not touched. Run by ./bootstrap, and by make after a change.
# usage: tools/features.sh            writes these files
#        tools/features.sh --readme   prints README.md with the table as it should be
set -eu
cd "$(dirname "$0")/.."

part() {
    LC_ALL=C "${AWK:-awk}" -F '\t' -v part="$1" -f tools/features.awk assignments/features.tsv
}

write() {
    part "$2" >"$1.part" || { rm -f "$1.part"; exit 1; }
    if cmp -s "$1.part" "$1"; then rm "$1.part"; else mv "$1.part" "$1"; fi
}

if [ "${1-}" = --readme ]; then
    part readme
else
    write features.am build
    write src/features/list.h list
    write src/features/all.h headers
fi
