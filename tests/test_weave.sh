#!/bin/sh
# Two who make the same page at the same time do not spoil each other's. A small script takes the place
# of pandoc: it waits until the file "go" is there.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
source=$(cd "${srcdir:-.}" && pwd)
folder=$(mktemp -d) || exit 1
trap 'touch "$folder/go"; rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
count=0

# verdict NAME: the status of the last command, and what was said
verdict() {
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || sed 's/^/# /' "$folder"/said*
    [ $result = 0 ] || printf 'not '
    echo "ok $count - $1"
}

cat >"$folder/pandoc" <<'END'
#!/bin/sh
for word; do
    case $word in --output=*) page=${word#--output=} ;; esac
done
echo waits >"${0%/*}/waits"
for tenth in $(seq 300); do [ -e "${0%/*}/go" ] || sleep 0.1; done
echo "a page by $PPID" >"$page"
END
chmod +x "$folder/pandoc"

# report SAID: makes the report, and writes what is said to the file
report() {
    RAYKIT_SOURCE=$source RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 \
        RAYKIT_COMPILER=c RAYKIT_FLAGS=none PANDOC=$folder/pandoc GNUPLOT= CHROMIUM= QUICK= FEATURES= \
        MESHES= sh "$source/reports/make_report" >"$folder/$1" 2>&1
}

mkdir "$folder/build"
report said1 &
first=$!
while [ ! -e "$folder/waits" ] && kill -0 $first 2>/dev/null; do sleep 0.1; done
touch "$folder/build/reports/out.part/figures/kept.png"

! report said2 && grep -q 'is making it in .*out.part: wait for it' "$folder/said2"
verdict a_second_one_is_told_who_makes_the_page

[ -e "$folder/build/reports/out.part/figures/kept.png" ]
verdict the_work_of_the_first_is_untouched

touch "$folder/go"
wait $first && grep -q 'a page by' "$folder/build/reports/out/report.html"
verdict the_first_one_finishes

report said1
verdict afterwards_another_may_start

# Left by a process that was killed.
(exit 0) &
dead=$!
wait $dead
mkdir "$folder/build/reports/out.part" && echo $dead >"$folder/build/reports/out.part/process"
report said1
verdict the_remains_of_a_killed_one_are_no_obstacle

[ "$(ls "$folder/build/reports")" = out ] && [ ! -e "$folder/build/reports/out/process" ]
verdict nothing_else_is_left

# What is measured apart from the page, by make bench and by make bench-peers.
measured="frames frames_goals growth growth_curves timings_machine"
mkdir -p "$folder/build/bench/tables"
for table in $measured; do echo "$table" >"$folder/build/bench/tables/$table.csv"; done
echo peers >"$folder/build/reports/out/tables/peers.csv"
are_there() {
    for table; do grep -q "$table" "$folder/build/reports/out/tables/$table.csv" || return 1; done
}
report said1 && are_there $measured peers
verdict tables_that_are_measured_apart_are_there

echo "1..$count"
