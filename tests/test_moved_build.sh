#!/bin/sh
# Is a build that was copied or moved configured anew before anything is written into the old place? With GNUmakefile,
# and a configure of a few lines.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
makefile=$(cd "${srcdir:-.}" && pwd)/GNUmakefile
folder=$(mktemp -d) || exit 1
folder=$(cd "$folder" && pwd -P)
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
unset MAKEFLAGS MFLAGS MAKELEVEL
count=0

verdict() { # name: the status of the last command, and what make said
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || { sed 's/^/# /' "$folder/said"; find "$folder" -name drawn | sed 's/^/# /'; printf 'not '; }
    echo "ok $count - $1"
}

# A source folder, and builds in it and beside it, whose only target writes into the folder that Makefile holds.
source="$folder/the source"
mkdir -p "$source" "$folder/build"
cp "$makefile" "$source"
cat >"$source/configure" <<'END'
#!/bin/sh
[ "${*#*--fails}" = "$*" ] || { echo "a reason" >&2; exit 1; }
here=$(dirname "$0")
mkdir busy || exit 1
[ ! -e slow ] || sleep 1
[ -f GNUmakefile ] || ln -s "$here/GNUmakefile" .
for argument; do [ "$argument" = --quiet ] || arguments="${arguments-} '$argument'"; done
printf '#!/bin/sh\ncat <<"_END"\n%s\n_END\n' "${arguments-}" >config.status
chmod +x config.status
printf 'abs_builddir = %s\nsrcdir = %s\nreport book: ; @echo "$(WHO)%s" >>"$(abs_builddir)/drawn"\n' "$(pwd)" "$here" "${arguments-}" >part
mv part Makefile
rmdir busy
END
chmod +x "$source/configure"
(cd "$source" && ./configure 'CFLAGS=-O2 -g') && (cd "$folder/build" && "../the source/configure" CC=gcc)

drawn() { cat "$1/drawn" 2>"$folder/nothing"; }
run() { "${MAKE:-make}" --no-print-directory -C "$@" >"$folder/said" 2>&1; }

run "$source" report && [ ! -s "$folder/said" ] && [ "$(drawn "$source")" = " 'CFLAGS=-O2 -g'" ]
verdict where_it_was_made_a_build_goes_on_without_a_word

rm "$source/drawn"
ln -s "$source" "$folder/link"
run "$folder/link" report && [ ! -s "$folder/said" ]
verdict nor_is_a_link_to_the_folder_another_place

rm "$source/drawn"
cp -a "$source" "$folder/a copy"
run "$folder/a copy" WHO=me report && [ "$(drawn "$folder/a copy")" = "me 'CFLAGS=-O2 -g'" ] && [ ! -e "$source/drawn" ]
verdict a_copy_is_configured_anew_with_the_same_arguments_and_leaves_the_original_alone

[ "$(cat "$folder/said")" = "make: this build was made in $source; configuring it anew for $folder/a copy" ]
verdict that_is_said_in_one_line

run "$folder/a copy" report && [ ! -s "$folder/said" ]
verdict and_once

cp -a "$folder/build" "$folder/moved"
run "$folder/moved" -j2 report book && [ "$(drawn "$folder/moved")" = " 'CC=gcc'
 'CC=gcc'" ] && [ ! -e "$folder/build/drawn" ]
verdict so_is_a_copy_of_a_build_out_of_the_source_folder

cp -a "$folder/build" "$folder/failing"
sed -i 's/CC=gcc/--fails/' "$folder/failing/config.status"
! run "$folder/failing" report && grep -q '^a reason' "$folder/said" && grep -q 'run ./bootstrap' "$folder/said" &&
    [ ! -e "$folder/build/drawn" ]
verdict if_that_fails_make_stops_and_names_the_command

if command -v flock >/dev/null; then
    cp -a "$folder/build" "$folder/twice"
    touch "$folder/twice/slow"
    run "$folder/twice" report &
    "${MAKE:-make}" --no-print-directory -C "$folder/twice" book >"$folder/said_too" 2>&1
    wait $! && [ "$(cat "$folder/said" "$folder/said_too" | wc -l)" = 1 ] && [ "$(drawn "$folder/twice" | wc -l)" = 2 ]
    verdict of_two_that_begin_at_once_one_configures
fi

mkdir "$folder/old"
cp "$makefile" "$folder/old"
cat >"$folder/old/Makefile" <<END
abs_builddir = $folder/old
Makefile: newer ; @echo configured >>drawn; touch \$@
clean distclean report: ; @echo \$@ >>drawn
END
touch "$folder/old/newer"
touch -t 200001010000 "$folder/old/Makefile"
run "$folder/old" -j2 distclean && run "$folder/old" clean && [ "$(drawn "$folder/old")" = "distclean
clean" ]
verdict what_only_removes_files_configures_nothing

rm "$folder/old/drawn"
run "$folder/old" report && [ "$(drawn "$folder/old")" = "configured
report" ]
verdict anything_else_configures_first_where_that_is_due

mv "$source" "$folder/renamed"
run "$folder/renamed" report && [ "$(drawn "$folder/renamed")" = " 'CFLAGS=-O2 -g'" ]
verdict a_renamed_folder_does_not_need_the_old_one

echo "1..$count"
