#!/bin/sh
# Whoever is refused a file learns what to do: each refusal in src/io has a remedy after a colon or a semicolon,
# which begins with a verb of tests/remedy.h. Messages that pass on another's, and notes, have none of their own.
set -u
[ "${1-}" != --list ] || exit 0 # the test driver asks for test names; there is nothing to choose from
cd "${srcdir:-.}" || exit 1
verbs=$(sed -n '/remedy_verbs\[\]/,/;/p' tests/remedy.h | grep -o '"[a-z]*"' | tr -d '"' | paste -s -d '|' -)

# Prints file:line: text of each refusal without a remedy; the number of refusals goes to standard error.
refusals_without_remedy() {
    find "$@" -name '*.[ch]' -o -name '*.cpp' | LC_ALL=C sort | xargs awk -v verbs="$verbs" '
        function finish() {
            text = ""
            for (rest = call; match(rest, /"([^"\\]|\\.)*"/); rest = substr(rest, RSTART + RLENGTH))
                text = text substr(rest, RSTART + 1, RLENGTH - 2)
            gsub(/%[-.*0-9]*(ll|l|z)?[a-z]/, "", text)
            is_own = text ~ /[A-Za-z]/ && call !~ /note,|^.?fail\((source|unfinished|"|const)/
            refusals += is_own
            if (is_own && text !~ "[:;] (" verbs ")([ ,]|$)" && call !~ /(remedy|needed)[,)]/) print place ": " text
            call = ""
        }
        FNR == 1 { call = "" }
        call == "" && match($0, /(rk_fail|[^_a-z]fail)\(.*/) {
            place = FILENAME ":" FNR
            call = substr($0, RSTART)
            if (call ~ /\);/) finish()
            next
        }
        call != "" { call = call " " $0; if ($0 ~ /\);|^}/) finish() }
        END { print refusals + 0 > "/dev/stderr" }'
}

verdict() { # condition's status, number, name
    [ "$1" = 0 ] && echo "ok $2 - $3" || { echo "not ok $2 - $3"; failed=1; }
}

failed=0
echo 1..2
found=$(refusals_without_remedy src/io 2>"${TMPDIR:-/tmp}/refusals.$$")
count=$(cat "${TMPDIR:-/tmp}/refusals.$$")
rm -f "${TMPDIR:-/tmp}/refusals.$$"
[ -z "$found" ] || echo "$found" | sed 's/^/# no remedy: /'
[ -z "$found" ]
verdict $? 1 each_refusal_of_a_file_has_a_remedy
[ "$count" -ge 150 ] || echo "# only $count refusals were found"
[ "$count" -ge 150 ]
verdict $? 2 the_refusals_are_found
exit $failed
