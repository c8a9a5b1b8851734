#!/bin/sh
# Two who make the same page at the same time do not spoil each other's. A small script takes the place
# of pandoc: it waits until the file "go" is there. And names that two texts have, and equal pictures
# in a row, are mistakes.
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

# report SAID [SOURCE PANDOC]: makes the report, and writes what is said to the file
report() {
    RAYKIT_SOURCE=${2-$source} RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 \
        RAYKIT_COMPILER=c RAYKIT_FLAGS=none PANDOC=${3-$folder/pandoc} GNUPLOT= CHROMIUM= QUICK= FEATURES= \
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

# With pandoc itself, and two texts.
if pandoc=$(command -v pandoc); then
    texts=$folder/texts/reports
    mkdir -p "$texts"
    ln -s "$source/tools" "$folder/texts/tools"
    ln -s "$source/reports/weave.lua" "$source/reports/report.css" "$texts"
    printf '# %s\n\n## Measured {#%s}\n' One one-measured >"$texts/01_one.md"
    printf '# %s\n\n## Measured {#%s}\n' Two two-measured >"$texts/02_two.md"
    report said1 "$folder/texts" "$pandoc"
    verdict two_texts_with_names_of_their_own_are_a_page

    printf '# %s\n\n## Measured {#%s}\n' Two one-measured >"$texts/02_two.md"
    ! report said1 "$folder/texts" "$pandoc" &&
        grep -q 'reports/02_two.md:3: #one-measured is in reports/01_one.md:3 already' "$folder/said1"
    verdict a_name_in_two_texts_is_a_mistake

    # A driver whose pictures are copies.
    mkdir -p "$folder/assignments/01_copies"
    cat >"$folder/assignments/01_copies/copies" <<'END'
#!/bin/sh
cp "$1" "$4/figures/$2.png" && echo "$4/figures/$2.png: 128 x 128"
END
    chmod +x "$folder/assignments/01_copies/copies"
    row() { # row PICTURE PICTURE
        printf '# One\n\n:::: {.row}\n'
        for name in left right; do
            printf '::: {.figure driver=copies args="%s %s"}\nOn the %s.\n:::\n' "$1" $name $name
            shift
        done
        printf '::::\n'
    }
    rm "$texts/02_two.md"
    look=$source/assignments/03_shading/look
    row "$look/1.png" "$look/2.png" >"$texts/01_one.md"
    report said1 "$folder/texts" "$pandoc"
    verdict a_row_of_two_pictures_is_woven

    row "$look/1.png" "$look/1.png" >"$texts/01_one.md"
    ! report said1 "$folder/texts" "$pandoc" &&
        grep -q '01_one.md:3: figures/left.png and figures/right.png are equal, pixel for pixel' "$folder/said1"
    verdict equal_pictures_in_a_row_are_a_mistake
else
    count=$((count + 1))
    echo "ok $count # SKIP a_name_in_two_texts_is_a_mistake: there is no pandoc"
fi

echo "1..$count"
