#!/bin/sh
# Do two makes in one folder build one after the other, and use what they have built at the same time? With GNUmakefile,
# and a Makefile of a few lines.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
makefile=$(cd "${srcdir:-.}" && pwd)/GNUmakefile
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
unset MAKEFLAGS MFLAGS MAKELEVEL RAYKIT_FOLDER_HELD
count=0

verdict() { # name: the status of the last command, and what make said
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || { sed 's/^/# /' "$folder"/said*; printf 'not '; }
    echo "ok $count - $1"
}

# What is built is spoilt by a second one that builds it; a tool ends when there is a file, after half a minute at
# most.
cp "$makefile" "$folder"
printf 'abs_builddir = %s\n' "$folder" >"$folder/Makefile"
cat >>"$folder/Makefile" <<'END'
goal = @mkdir busy && sleep $(or $(LONG),.5) && rmdir busy && echo $@ >>done
until_enough = for i in $$(seq 300); do [ ! -e enough ] || exit 0; sleep .1; done; exit 1
first second: ; $(goal)
check-TESTS: ; @$(until_enough)
tool: first ; @$(built)$(until_enough)
nested: ; +$(goal); $(MAKE) first
own: first ; @$(built)env -u MAKELEVEL -u MAKEFLAGS $(MAKE) second
restarted: part ; $(goal)
-include part
part: ; @sleep .2; echo "# nothing" >$@
END
run() { # number, goals
    number=$1
    shift
    "${MAKE:-make}" --no-print-directory -C "$folder" "$@" >"$folder/said$number" 2>&1
}

others_build_during() { # a goal that lasts until there is enough
    rm -f "$folder/enough"
    run 1 "$1" &
    lasting=$!
    run 2 second && kill -0 $lasting
    status=$?
    touch "$folder/enough"
    wait $lasting && [ $status = 0 ]
}

if ! command -v flock >/dev/null; then
    echo "ok 1 # SKIP no flock here"
    echo "1..1"
    exit
fi

rm -f "$folder"/part
run 1 first LONG=3 &
run 2 second LONG=3 && wait $! && [ "$(sort "$folder/done" | tr '\n' ' ')" = "first second " ]
verdict two_makes_build_one_after_the_other

[ "$(cat "$folder/said1" "$folder/said2" | grep -c '^make: waiting until another make has built here$')" = 1 ]
verdict the_second_says_what_it_waits_for

others_build_during tool
verdict while_a_tool_runs_others_may_build

run 1 nested
verdict makes_within_a_make_do_not_wait_for_it

run 1 own
verdict a_tool_may_build

rm "$folder/part"
run 1 restarted
verdict a_make_that_begins_again_does_not_wait_for_itself

others_build_during check-TESTS
verdict tests_that_run_let_others_build

"${MAKE:-make}" -C "$folder" second >"$folder/said1" 2>&1 &
until [ -e "$folder/busy" ]; do sleep .05; done
kill -KILL $!
wait $! 2>/dev/null
while [ -e "$folder/busy" ]; do sleep .1; done
run 2 first && ! grep -q . "$folder/said2"
verdict one_that_was_killed_keeps_nobody_waiting

mkdir "$folder/temporary"
TMPDIR=$folder/temporary run 1 tool && TMPDIR=$folder/temporary run 2 second && sleep 1 && [ -z "$(ls "$folder/temporary")" ]
verdict nothing_is_left_behind

run 1 -n second && run 2 -n second && ! grep -q waiting "$folder"/said*
verdict one_after_the_other_they_say_nothing

echo "1..$count"
