#!/bin/sh
# Does the driver of the suites stop one that hangs, and no other? Small shell scripts take the place
# of suites.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
driver=${srcdir:-.}/tests/tap_driver
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
count=0

# verdict NAME: the status of the last command, and what the driver said
verdict() {
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || sed 's/^/# /' "$folder/said"
    [ $result = 0 ] || printf 'not '
    echo "ok $count - $1"
}

# drive SECONDS COMMANDS: with a suite of three tests that runs the commands
drive() {
    cat >"$folder/suite" <<END
#!/bin/sh
[ "\${1-}" != --list ] || { echo first; echo second; echo third; exit; }
echo 1..3
$2
END
    chmod +x "$folder/suite"
    RAYKIT_TEST_SECONDS=$1 "${SHELL:-/bin/sh}" "$driver" --test-name tests/test_suite --color-tests no \
        --log-file "$folder/log" --trs-file "$folder/trs" -- "$folder/suite" >"$folder/said" 2>&1
}

says() { grep -qF -e "$1" "$folder/said"; }

drive 60 'echo ok 1 - first; echo ok 2 - second; echo ok 3 - third'
says '3 passed' && ! says failed
verdict passed_tests_are_counted

drive 60 'echo ok 1 - first; echo "# a reason"; echo not ok 2 - second; echo ok 3 - third'
says '2 passed, 1 failed' && says '      second' && says '          a reason'
verdict a_failed_test_is_named_with_its_reason

drive 60 'echo ok 1 - first; kill -SEGV $$'
says 'ended by signal 11, in test 2 of 3, second'
verdict a_crash_names_its_test

drive 60 'echo ok 1 - first; kill -TERM $$'
says 'ended by signal 15'
verdict a_suite_that_is_ended_by_others_was_not_stopped

# is_gone FILE: has the process ended whose number a suite wrote into the file? It may wait to be reaped.
is_gone() {
    [ -s "$1" ] || return 1
    case $(cat "/proc/$(cat "$1")/stat" 2>/dev/null) in
    '' | *') Z '*) ;;
    *) return 1 ;;
    esac
}

# More than the limit for the whole suite, but not for any of its tests.
work='end=$(($(cut -d" " -f14 /proc/$$/stat) + 55)); while [ "$(cut -d" " -f14 /proc/$$/stat)" -lt $end ]; do i=0; while [ $i -lt 100000 ]; do i=$((i + 1)); done; done'
drive 1 "for i in 1 2 3; do $work; echo ok \$i - name; sleep 1.2; done"
says '3 passed' && ! says failed
verdict a_slow_suite_may_go_on

# As on a busy machine: time passes, but not the suite's own.
drive 1 'echo ok 1 - first; sleep 3; echo ok 2 - second; sleep 3; echo ok 3 - third'
says '3 passed' && ! says failed
verdict a_suite_that_got_no_processor_may_go_on

RAYKIT_TEST_PATIENCE=2 drive 1 'echo ok 1 - first; exec sleep 100'
says 'stopped after 2 seconds without a verdict, in test 2 of 3, second'
verdict a_silent_suite_is_stopped

drive 1 "trap '' TERM; echo ok 1 - first; while :; do echo noise; done"
says 'stopped after 1 seconds of processor time without a verdict, in test 2 of 3, second'
verdict output_is_no_verdict_and_signals_are_no_way_out

drive 1 "echo ok 1 - first; sh -c 'while :; do :; done'"
says 'stopped after 1 seconds of processor time without a verdict, in test 2 of 3, second'
verdict the_work_of_children_counts

drive 1 "echo ok 1 - first; sleep 300 & echo \$! >$folder/child
setsid sh -c 'echo \$\$ >$folder/apart; trap \"\" TERM; while :; do :; done'"
says 'stopped after 1 seconds of processor time' && is_gone "$folder/child" && is_gone "$folder/apart"
verdict the_whole_family_of_a_stopped_suite_ends

drive 60 "echo ok 1 - first; sleep 300 & echo \$! >$folder/child; echo ok 2 - second; echo ok 3 - third"
says '3 passed' && is_gone "$folder/child"
verdict nothing_that_a_suite_started_outlives_it

RAYKIT_TEST_PATIENCE=600 drive 60 "echo \$\$ >$folder/hanging; exec sleep 300" &
driver_shell=$!
for _ in $(seq 600); do [ ! -s "$folder/hanging" ] || break; sleep 0.1; done
# shellcheck disable=SC2046 # the shell, and the driver that it runs
kill $(cat "/proc/$driver_shell/task/$driver_shell/children")
wait $driver_shell
is_gone "$folder/hanging"
verdict a_driver_that_is_ended_ends_its_suite

drive 60 'kill -INT $$; echo ok 1 - first'
says 'ended by signal 2'
verdict suites_do_not_ignore_ctrl_c

echo "1..$count"
