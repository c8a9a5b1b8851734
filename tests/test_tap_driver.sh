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

# Longer than the limit for the whole suite, but not for any of its tests.
drive 3 'for i in 1 2 3; do sleep 1.2; echo ok $i - name; done'
says '3 passed' && ! says failed
verdict a_slow_suite_may_go_on

drive 1 'echo ok 1 - first; exec sleep 100'
says 'stopped after 1 seconds without a verdict, in test 2 of 3, second'
verdict a_silent_suite_is_stopped

drive 1 "trap '' TERM; echo ok 1 - first; while :; do echo noise; sleep 0.1; done"
says 'stopped after 1 seconds without a verdict, in test 2 of 3, second'
verdict output_is_no_verdict_and_signals_are_no_way_out

echo "1..$count"
