#!/bin/sh
# Two who make the same page at the same time do not spoil each other's. A small script takes the place
# of pandoc: it waits until the file "go" is there. Names that two texts have, equal pictures in a row, and
# sentences that the numbers do not bear out are mistakes. Figures and formulas have numbers, the book is also
# pages of about a section, which can be searched, with answers for instructors, and wrong pictures are shown with the mistakes.
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
        RAYKIT_COMPILER=c RAYKIT_FLAGS=none PANDOC=${3-$folder/pandoc} GNUPLOT=${gnuplot-} CHROMIUM= QUICK=${quick-} FEATURES= \
        MESHES= RAYKIT_PAIR=$PWD/tools/pair/pair RAYKIT_WRONG="sh '$folder/wrong'" sh "$source/reports/make_report" >"$folder/$1" 2>&1
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
measured="frames frames_goals frames_profile growth growth_curves startup timings_machine"
mkdir -p "$folder/build/bench/tables"
for table in $measured; do echo "$table" >"$folder/build/bench/tables/$table.csv"; done
echo peers >"$folder/build/reports/out/tables/peers.csv"
are_there() {
    for table; do grep -q "$table" "$folder/build/reports/out/tables/$table.csv" || return 1; done
}
# shellcheck disable=SC2086 # a list of names
report said1 && are_there $measured peers
verdict tables_that_are_measured_apart_are_there

# With pandoc itself, and two texts.
if pandoc=$(command -v pandoc); then
    texts=$folder/texts/reports
    mkdir -p "$texts" "$folder/texts/docs"
    ln -s "$source/tools" "$folder/texts/tools"
    ln -s "$source/docs/pictures" "$folder/texts/docs"
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
folder=${*##*--out }
mkdir -p "$folder/figures" "$folder/tables" && echo a >"$folder/tables/copies.csv" && echo 1 >>"$folder/tables/copies.csv" &&
    cp "$1" "$folder/figures/$2.png" && echo "$folder/figures/$2.png: 128 x 128, built in 1.5 ms, rendered in 2 s on 2 threads, raykit 1"
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

    row "$look/1.png" "$look/2.png" | sed 's/left"}/left" command=open}/' >"$texts/01_one.md"
    report said1 "$folder/texts" "$pandoc" &&
        [ "$(grep -o '<details class="command" open' "$folder/build/reports/out/report.html" | wc -l)" = 1 ] &&
        [ "$(grep -o '<details class="command"' "$folder/build/reports/out/report.html" | wc -l)" = 2 ]
    verdict a_command_is_unfolded_where_the_text_says_so

    # A text in a picture, after its header; its sum is not read.
    {
        head -c 33 "$look/1.png"
        printf '\000\000\000\066tEXtraykit:scale\000-4@0 0@0.25 12+@1 #000000 #ffffff samplesSUM!'
        tail -c +34 "$look/1.png"
    } >"$folder/scaled.png"
    row "$folder/scaled.png" "$look/2.png" >"$texts/01_one.md"
    report said1 "$folder/texts" "$pandoc" && [ "$(grep -c 'class="scale"' "$folder/build/reports/out/report.html")" = 1 ] &&
        tr '\n' ' ' <"$folder/build/reports/out/report.html" |
        sed 's/  */ /g' | grep -q 'place: 0">−4</span> *<span class="tick" style="--place: 0.25">0</span> *<span class="tick" style="--place: 1">12 and more</span>'
    verdict a_picture_with_a_scale_has_a_bar_and_others_have_none

    row "$look/1.png" "$look/1.png" >"$texts/01_one.md"
    ! report said1 "$folder/texts" "$pandoc" &&
        grep -q '01_one.md:3: figures/left.png and figures/right.png are equal, pixel for pixel' "$folder/said1"
    verdict equal_pictures_in_a_row_are_a_mistake

    # Two grey squares of 100 x 100 pixels; the second has a field of 4 x 3 pixels, at 40, 50, that is brighter by 5.
    look_alike() { ! report said1 "$folder/texts" "$pandoc" && grep -q "01_one.md:3: figures/left.png and figures/right.png look alike: $1 %" "$folder/said1"; }
    grey() { # grey FILE PIXELS LEVEL: rows of text become a picture
        python3 -c 'import sys, zlib, struct
width, count, level = 100, int(sys.argv[2]), int(sys.argv[3])
rows = [bytearray([0] + [128] * 300) for _ in range(100)]
for i in range(count):
    rows[50 + i // 4][1 + 3 * (40 + i % 4)] = level
part = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
open(sys.argv[1], "wb").write(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", 100, 100, 8, 2, 0, 0, 0))
    + part(b"IDAT", zlib.compress(b"".join(rows))) + part(b"IEND", b""))' "$@"
    }
    compared() { # compared ATTRIBUTES
        row "$folder/grey.png" "$folder/greyer.png" | sed "s/driver=copies/& ${1-}/" >"$texts/01_one.md"
    }
    grey "$folder/grey.png" 0 128 && grey "$folder/greyer.png" 9 133 && compared && look_alike 0.090
    verdict a_row_of_two_pictures_that_look_alike_is_a_mistake

    compared 'crop="0.3 0.4 0.3 0.3"' && report said1 "$folder/texts" "$pandoc" && ! grep -q data-crop "$folder/build/reports/out/report.html"
    verdict pictures_are_compared_as_they_are_shown

    grey "$folder/greyer.png" 10 133 && compared && report said1 "$folder/texts" "$pandoc"
    verdict a_thousandth_of_the_pixels_is_enough

    grey "$folder/greyer.png" 12 132 && compared && look_alike 0.000
    verdict a_difference_of_4_of_255_is_not_visible

    # In the place of Python: make bench, which has measured in full or in its quick form.
    printf '#!/bin/sh\nfolder=${*##*--out }\nprintf "gain\\n3\\n" >"$folder/tables/accuracy.csv"\ncat "%s/form"\n' "$folder" >"$folder/python"
    chmod +x "$folder/python"
    printf '# One\n\n::: {.table driver=bench args="" table=accuracy columns=gain}\nGains.\n:::\n' >"$texts/01_one.md"
    measured_by() { # measured_by FORM
        echo "$1" >"$folder/form"
        RAYKIT_PYTHON=$folder/python report said1 "$folder/texts" "$pandoc"
    }
    measured_by quick && tr '\n' ' ' <"$folder/build/reports/out/report.html" | grep -q 'by the quick form of make bench' &&
        measured_by full && ! tr '\n' ' ' <"$folder/build/reports/out/report.html" | grep -q 'quick form'
    verdict numbers_of_a_quick_measurement_say_so

    mkdir "$folder/assignments/02_times"
    cat >"$folder/assignments/02_times/times" <<'END'
#!/bin/sh
{
    echo feature,scene,triangles,method,isa,threads,metric,unit,median,min,max,runs
    for row in median,scalar,1,render,ms,7,4,8 sah50_3,scalar,1,render,ms,5,5,5; do echo "times,cube,12,$row,1"; done
} >"${*##*--out }/tables/times.csv"
END
    chmod +x "$folder/assignments/02_times/times"
    timed() { # timed ATTRIBUTES: a quick report with a table of times, its words in a line
        printf '# One\n\n::: {.timings driver=times scenes=cube metrics=render %s}\nTimes.\n:::\n' "$1" >"$texts/01_one.md"
        quick=1 report said1 "$folder/texts" "$pandoc" &&
            tr '\n' ' ' <"$folder/build/reports/out/report.html" | sed 's/<[^>]*>/ /g; s/\xc2\xa0/ /g' | tr -s ' ' >"$folder/words"
    }
    timed 'rows="scene method" labels="sah50_3: all axes; render: time"' &&
        grep -q 'scene method triangles time, ms cube median 12 ≈ 7 cube all axes 12 5 Table' "$folder/words"
    verdict labels_name_metrics_and_methods

    timed 'rows=method' && grep -q ' method render, ms median ≈ 7 sah50 3 5 Table' "$folder/words"
    verdict where_the_scene_plays_no_part_triangles_are_not_counted

    timed 'rows=none where="method=median"' && grep -q ' measured result render, ms ≈ 7 Table' "$folder/words"
    verdict without_rows_of_their_own_each_metric_has_one

    ! timed 'labels="sah60: other"' && grep -q 'labels: sah60 is neither a metric nor a method of the table' "$folder/said1"
    verdict a_label_of_what_the_table_has_not_is_a_mistake

    overdrawn() { # overdrawn ATTRIBUTES: a table whose run draws another picture of the same name
        row "$look/1.png" "$look/2.png" >"$texts/01_one.md"
        printf '\n::: {.table driver=copies args="%s left" columns=a table=copies %s}\nA table.\n:::\n' "$look/3.png" "$1" >>"$texts/01_one.md"
        report said1 "$folder/texts" "$pandoc"
    }
    ! overdrawn "" && grep -q '01_one.md:4: a later run, for a table or a plot, has drawn over figures/left.png' "$folder/said1"
    verdict a_picture_that_a_later_run_draws_over_is_a_mistake

    echo "units: somebody's" >"$folder/units"
    overdrawn ""
    verdict but_not_with_units_of_a_student
    rm "$folder/units"

    overdrawn keep=copies_3
    verdict unless_that_run_is_kept_apart

    # A driver whose table is the same each time.
    mkdir -p "$folder/assignments/02_counts"
    cat >"$folder/assignments/02_counts/counts" <<'END'
#!/bin/sh
mkdir -p "${*##*--out }/tables"
printf 'scene,metric,median,min,max,runs\nbox,render,%d,1,1,1\n' $# >"${*##*--out }/tables/speed.csv"
printf 'kind,samples,error\nold one,1,8\nold one,4,4\nnew,1,3\nnew,4,1\nnew,16,0.25\n' >"${*##*--out }/tables/counts.csv"
END
    chmod +x "$folder/assignments/02_counts/counts"
    sentence() { # sentence EXPRESSION [VALUES...]: a text with a sentence and its values
        printf '# One\n\n[New is better]{.check that="%s"} by [9]{.value is="old / new"}.\n\n' "$1"
        printf '``` {.values driver=counts args=""}\nold = error where kind=old_one samples=4\n'
        printf 'new = error where kind=new samples=4\nfall = slope of error over samples where kind=new\n'
        shift
        printf '%s\n' "$@" '```'
    } >"$texts/01_one.md"
    is_woven() { report said1 "$folder/texts" "$pandoc"; }
    is_refused() { ! is_woven && grep -qF "$1" "$folder/said1"; }
    page=$folder/build/reports/out/report.html

    sentence 'new < old and fall < -0.99'
    is_woven && tr '\n' ' ' <"$page" | grep -q 'new = 1.*New is better</span> by 4\.'
    verdict a_sentence_that_the_numbers_bear_out_is_woven

    sentence 'new > old'
    is_refused '01_one.md:3: the numbers say otherwise: "New is better" needs new > old, but new = 1, old = 4'
    verdict a_sentence_that_they_do_not_bear_out_is_a_mistake

    grep -q 'do not bear out 1 of its sentences' "$folder/said1" && grep -q 'not here: new = 1, old = 4' "$page"
    verdict and_marked_in_the_page

    RAYKIT_JUDGES=no is_woven && grep -q 'not here: new = 1' "$page"
    verdict a_pack_is_made_all_the_same

    quick=1 is_woven
    verdict a_quick_trial_is_not_judged

    sentence 'new < older'
    is_refused '01_one.md:3: no value is called older'
    verdict a_name_without_a_value_is_a_mistake

    sentence 'new < old' 'old = error where kind=new samples=1'
    is_refused 'the value old is named in reports/01_one.md:5 already'
    verdict a_name_with_two_values_is_a_mistake

    sentence 'new < old' 'both = error where kind=new'
    is_refused 'error: 3 rows are selected in place of one'
    verdict a_value_is_one_cell

    sentence 'new < old' 'none = error where kind=other'
    is_refused 'tables/counts.csv has no row where kind=other'
    verdict and_not_none

    # Two numbers from the same row of a table, which the second run replaces.
    {
        for words in a 'a b'; do
            printf '[3]{.measured name=%s driver=counts table=speed scene=box metric=render args="%s"}\n' "${words#a }" "$words"
        done
        printf '\n[One more.]{.check that="b == a + 1"}\n'
    } >"$texts/01_one.md"
    is_woven && tr '\n' ' ' <"$page" | grep -q 'a = 9, b = 10'
    verdict a_measured_number_has_a_name_and_is_kept

    sentence 'old'
    is_refused '01_one.md:3: old is neither true nor false'
    verdict a_sentence_is_true_or_false

    printf '# One\n\n[2 and 2 are 4]{.worked that="2 + 2 == 4"}, [1 is lost]{.worked that="2^53 + 1 == 2^53"}.\n' >"$texts/01_one.md"
    is_woven && grep -q '2 and 2 are 4, 1 is lost' "$page"
    verdict an_example_worked_by_hand_is_woven

    printf '# One\n\n[2 and 2 are 5]{.worked that="2 + 2 == 5"}.\n' >"$texts/01_one.md"
    quick=1 is_refused '01_one.md:3: "2 and 2 are 5" needs 2 + 2 == 5'
    verdict a_wrong_one_is_a_mistake

    printf '# One\n\n[2 and 2 are a]{.worked that="2 + 2 == a"}.\n' >"$texts/01_one.md"
    is_refused '01_one.md:3: a: a worked example has no names'
    verdict it_has_numbers_alone

    # A driver that says something else without shadows.
    mkdir -p "$folder/assignments/05_says"
    printf '#!/bin/sh\ncase "$*" in *--shadows*) echo "  shadow ray    occluded" ;; *) echo lit ;; esac\n' >"$folder/assignments/05_says/says"
    chmod +x "$folder/assignments/05_says/says"
    says() { printf '# One\n\n[In a shadow, it is *occluded*]{.printed driver=says %s}.\n' "$1" >"$texts/01_one.md"; }

    says 'args=--shadows runs="--pixel 1,2; --pixel 3,4" prints="shadow ray occluded; occl" lacks=lit'
    is_woven && tr '\n' ' ' <"$page" | grep -q 'class="checked"[^>]*>In a shadow' && grep -q '^reports/01_one.md: 1 sentence holds' "$folder/said1"
    verdict a_sentence_that_a_driver_bears_out_is_woven

    says 'runs="--shadows; --pixel 3,4" prints=occluded'
    is_refused '01_one.md:3: "In a shadow, it is occluded" needs "occluded" in the output of: says  --pixel 3,4'
    verdict it_must_hold_of_each_run

    says 'args=--shadows lacks="lamp; ray occluded"'
    quick=1 is_refused '01_one.md:3: "In a shadow, it is occluded" needs no "ray occluded" in the output of: says --shadows'
    verdict what_must_not_be_printed_is_a_mistake_in_a_trial_too

    says args=--shadows
    is_refused '01_one.md:3: .printed needs prints="..." or lacks="..."'
    verdict a_sentence_of_which_nothing_is_asked_is_a_mistake

    # A driver whose runs take 3 ms, and a sentence that says otherwise.
    mkdir -p "$folder/assignments/04_clock"
    cat >"$folder/assignments/04_clock/clock" <<'END'
#!/bin/sh
mkdir -p "${*##*--out }/tables"
printf 'scene,metric,unit,median,min,max,runs\nbox,render,ms,3,3,3,1\nbox,levels,1,4,4,4,1\n' >"${*##*--out }/tables/clock.csv"
END
    chmod +x "$folder/assignments/04_clock/clock"
    {
        printf '# One\n\n[It takes long]{.check that="time > 5"}, [has levels]{.check that="levels == 4"}, [3]{.value is=time}.\n\n'
        printf '``` {.values driver=clock timings=yes scenes=box args=""}\n'
        printf '%s = median where metric=%s\n' time render levels levels
        printf '```\n'
    } >"$texts/01_one.md"
    is_woven && tr '\n' ' ' <"$page" | grep -q 'measured once here, and not so: time = 3' && tr '\n' ' ' <"$page" | grep -q '≈.*3</span>' &&
        grep -q '^reports/01_one.md: 1 sentence holds, 1 not judged' "$folder/said1"
    verdict a_sentence_about_times_that_were_measured_once_is_not_judged

    ! MEASURED=1 is_woven && grep -q '^reports/01_one.md: 1 sentence holds, 1 FAILS:' "$folder/said1" &&
        grep -q '^reports/01_one.md:3: the numbers say otherwise: "It takes long" needs time > 5, but time = 3' "$folder/said1"
    verdict where_they_were_measured_carefully_it_is

    ! is_woven && grep -q '1 FAILS' "$folder/said1"
    verdict and_later_pages_have_the_careful_times

    # A driver with errors of several seeds, and a program in the place of gnuplot that keeps its script.
    mkdir -p "$folder/assignments/03_errors"
    cat >"$folder/assignments/03_errors/errors" <<'END'
#!/bin/sh
folder=${*##*--out }/tables
mkdir -p "$folder" && {
    echo method,samples,seconds,rmse,rmse_low,rmse_high,seeds
    printf 'uniform,%s,8\n' 1,1,8,7,9 4,2,1,0.75,1.5 16,4,0.5,0.25,0.75 64,8,0.25,0.125,0.5
    printf 'sobol,%s,8\n' 1,1,4,4,4 4,2,2,2,2
    printf 'zsobol,%s,8\n' 4,2,4,4,4 16,4,4,1,5 64,8,4,2,4
} >"$folder/errors.csv"
{
    echo method,samples,step
    printf '%s\n' nearest,1,8 nearest,64,1.1 bilinear,1,9.9 bilinear,64,9.5 best,1,2 best,64,1
} >"$folder/steps.csv"
END
    cat >"$folder/gnuplot" <<'END'
#!/bin/sh
script=${0%/*}/script
cat >"$script"
echo '<svg xmlns="http://www.w3.org/2000/svg" width="8" height="8"/>' >"$(sed -n "s/^set output '\(.*\)'/\1/p" "$script")"
END
    chmod +x "$folder/assignments/03_errors/errors" "$folder/gnuplot"
    curve() { # curve ATTRIBUTES
        printf '# One\n\n::: {.plot driver=errors args="" y=rmse by=method %s}\nOne.\n:::\n' "$1" >"$texts/01_one.md"
        gnuplot=$folder/gnuplot report said1 "$folder/texts" "$pandoc"
    }
    curve 'x=samples guides="-1/2 -1"' && grep -q '^4 0.75 1.5$' "$folder/script" && grep -q 'with filledcurves' "$folder/script" &&
        tr '\n' ' ' <"$page" | grep -q 'RMS over 8 seeds, band: from the least to the largest of one; in brackets: slope over samples, from 4 on'
    verdict errors_of_several_seeds_have_a_band

    grep -qF "title 'uniform (−0.50)'" "$folder/script" && grep -qF "title 'sobol' " "$folder/script"
    verdict the_legend_has_slopes_of_three_points_or_more_from_four_samples_on

    grep -qF "title 'zsobol' " "$folder/script"
    verdict where_seeds_differ_much_there_is_no_slope

    grep -qF '* (x / 1) ** (-0.5) with lines' "$folder/script" && grep -qF "set label '−1/2'" "$folder/script" && grep -qF "set label '−1'" "$folder/script"
    verdict guides_have_their_slopes_at_their_ends

    tr '\n' ' ' <"$page" | grep -q 'numbers: <a href="tables/errors.csv">tables/errors.csv</a>' &&
        tr '\n' ' ' <"$folder/build/reports/out/report/index.html" | grep -q 'href="../tables/errors.csv"'
    verdict a_plot_leads_to_its_numbers

    curve x=seconds && grep -qF "title 'uniform (−0.50)'" "$folder/script"
    verdict against_time_slopes_are_still_those_over_samples

    ! curve 'x=samples guides=steep' && grep -q '01_one.md:3: guides: steep is not a slope' "$folder/said1"
    verdict a_guide_is_a_number

    stepped() { # stepped METHOD [ATTRIBUTES]
        printf '# One\n\n::: {.plot driver=errors args="" table=steps x=samples y=step by=method where="method=%s" %s}\nOne.\n:::\n' "$@" >"$texts/01_one.md"
        gnuplot=$folder/gnuplot report said1 "$folder/texts" "$pandoc"
    }
    stepped nearest '' && grep -q '^set key top right' "$folder/script" && stepped bilinear '' && grep -q '^set key bmargin' "$folder/script"
    verdict a_legend_covers_no_curve

    grep -q '^set terminal svg size 600,' "$folder/script" && stepped bilinear 'labels="bilinear: a flat line with a name of 40 letters ..."' &&
        grep -q '^set terminal svg size 756,' "$folder/script"
    verdict a_plot_is_as_wide_as_its_legend

    # look_of METHOD: colour and marker of its line, whose number is that of its title
    look_of() {
        number=$(sed -n "s/.*linestyle \([0-9]*\) title '$1[ ']*.*/\1/p" "$folder/script")
        sed -n "s/^set style line $number \(lc rgb '[^']*' pt [0-9]*\).*/\1/p" "$folder/script"
    }
    curve 'x=samples only=sobol' && alone=$(look_of sobol) && curve 'x=samples only="uniform; sobol"' &&
        [ -n "$alone" ] && grep -qF "set style line 2 $alone " "$folder/script" && ! grep -qF "set style line 1 $alone " "$folder/script"
    verdict a_method_has_its_colour_and_marker_in_any_place

    tr '\n' ' ' <"$page" | grep -q '2 of 3 methods; RMS over'
    verdict a_plot_of_some_methods_says_so

    ! curve 'x=samples only="uniform; sobl"' && grep -q '01_one.md:3: only: the table has no method sobl' "$folder/said1"
    verdict a_method_that_is_not_measured_cannot_be_plotted

    ! stepped best '' && grep -q '01_one.md:3: best has no colour and marker: give it some in tools/weave/methods.lua' "$folder/said1"
    verdict a_method_without_colour_and_marker_is_a_mistake

    figure() { # figure ATTRIBUTES
        printf '# One\n\n::: {.figure driver=copies args="%s left" %s}\nOne.\n:::\n' "$look/1.png" "$1" >"$texts/01_one.md"
        report said1 "$folder/texts" "$pandoc"
    }
    page=$folder/build/reports/out/report.html
    figure 'crop="0.5 0.25 0.25 0.5"' && grep -q 'class="crop" style="aspect-ratio: 0.5"' "$page" &&
        tr '\n' ' ' <"$page" | grep -q 'width: 400%; margin: -100% 0 0 -200%'
    verdict a_part_of_a_picture_is_magnified

    tr '\n' ' ' <"$page" | grep -q '128 x 128, raykit 1<' && grep -q '<summary>command</summary><code>[^<]*copies .*1.png left</code>' "$page"
    verdict below_a_picture_are_its_parameters_without_times_and_its_command

    ! figure 'crop="0.8 0 0.25 0.5"' && grep -q '01_one.md:3: crop="0.8 0 0.25 0.5" is not a part of the picture' "$folder/said1"
    verdict a_part_beyond_the_picture_is_a_mistake

    figure 'needs="/nowhere/lake.exr photographs"' &&
        tr '\n' ' ' <"$page" | grep -q "it needs lake.exr of Debian.*s package photographs"
    verdict a_picture_that_needs_an_optional_package_is_left_out_without_it

    figure 'label="0.5 0.5 0.8 0.2 red <pane>; 0.1 0.1 n"' && grep -q '>red &lt;pane\(>\|&gt;\)</text>.*>n</text>' "$page" &&
        tr '\n' ' ' <"$page" | grep -q 'Labels: red &lt;pane&gt;, n[.]'
    verdict labels_are_over_the_picture_and_in_its_text

    ! figure 'label="0.5 red pane"' && grep -q '01_one.md:3: label: "0.5 red pane" is not a place and a text' "$folder/said1"
    verdict a_label_without_a_place_is_a_mistake
    # Figures, and what is said of them.
    {
        row "$look/1.png" "$look/6.png" | sed 's/{.row}/{.row .compare}/; s/{.figure \(.* left"\)/{.figure #first alt="A ball" \1/'
        printf '\nSee [](#first), [](#sums) and [](#two).\n\n[$$x^2$$]{#sums}\n\n## Two {#two}\n'
    } >"$texts/01_one.md"
    page=$folder/build/reports/out/report.html
    report said1 "$folder/texts" "$pandoc" && grep -q '<figure class="picture" id="first">' "$page" &&
        grep -q '<a href="#first">Figure.0.1</a>, <a href="#sums">Equation.(0.1)</a>' "$page" && # chapters count from 0
        grep -q '<a href="#two">Section.0.1</a>' "$page" && grep -q 'id="figure-0-2"' "$page"
    verdict figures_formulas_and_sections_have_numbers_that_texts_can_use

    tr '\n' ' ' <"$page" | grep -o '<img [^>]*>' >"$folder/pictures"
    grep -q 'width="128" height="128" alt="A ball"' "$folder/pictures" && grep -q 'alt="On the right\."' "$folder/pictures"
    verdict pictures_have_sizes_and_short_texts

    tr '\n' ' ' <"$folder/build/reports/out/report/index.html" | grep -q 'src="../figures/left.png"'
    verdict beside_the_report_its_pictures_are_files

    printf '\n[](#nothing)\n' >>"$texts/01_one.md"
    ! report said1 "$folder/texts" "$pandoc" && grep -q '01_one.md:[0-9]*: .*#nothing' "$folder/said1"
    verdict an_empty_link_to_nothing_is_a_mistake

    row "$look/1.png" "$look/2.png" | sed 's/{.row}/{.row .compare}/' >"$texts/01_one.md"
    ! report said1 "$folder/texts" "$pandoc" &&
        grep -q '01_one.md:3: .compare needs two pictures of equal size' "$folder/said1"
    verdict pictures_of_different_sizes_cannot_be_compared

    # A book: its chapters link to each other, code to its definition.
    docs=$folder/texts/docs
    mkdir -p "$docs" "$folder/texts/src"
    ln -s "$source/docs/weave.lua" "$source/docs/book.css" "$docs"
    printf '#include "x.h"\n\nstatic int half(int x)\n{\n    return x / 2;\n}\n\nint rk_quarter(int x)\n{\n    return half(half(x));\n}\n' \
        >"$folder/texts/src/x.c"
    printf '# Start {.unnumbered #start}\n\n[One](#one)\n' >"$docs/book.md"
    printf '# Pixel {.unnumbered #pixel}\n\nOne.\n' >"$docs/one_pixel.md"
    printf '# Camera {.unnumbered #camera}\n' >"$docs/camera.md"
    printf '# Notation {.unnumbered #notation}\n' >"$docs/notation.md"
    printf '# One {#one}\n\n``` {.code file=src/x.c name=half}\n```\n\n[code](file:src/x.c)\n' >"$docs/01_one.md"
    printf '# Two {#two}\n\n## Disks {#disks}\n\nAll *unit disks*. One unit disk.\n\nNo symbol.\n\n``` {.code file=src/x.c name=rk_quarter}\n```\n' >"$docs/02_two.md"
    printf '# Glossary {.unnumbered #glossary}\n\n| symbol | means |\n|---|---|\n| $x$ | a number |\n\n| term | means |\n|---|---|\n| unit disk | a disk |\n' >"$docs/glossary.md"
    printf '# Index {.unnumbered #book-index}\n\n::: {.index of=terms}\n:::\n\n::: {.index of=functions}\n:::\n' >"$docs/index_page.md"
    printf '# Bibliography {.unnumbered #bibliography}\n\n::: {#refs}\n:::\n' >"$docs/bibliography.md"
    : >"$docs/bibliography.bib"
    printf '# House {.unnumbered #house}\n\n[terms](glossary.md#glossary), [one](01_one.md)\n\n![Its rooms](sketches/house.svg)\n' \
        >"$docs/architecture.md"
    mkdir "$docs/sketches"
    printf '<svg xmlns="http://www.w3.org/2000/svg" aria-label="A house"><path d="M1 2"/></svg>\n' >"$docs/sketches/house.svg"
    RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc \
        GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1
    pages=$folder/build/docs/out/book
    [ "$(cd "$pages" && echo *.html)" = "book-index.html camera.html glossary.html house.html index.html notation.html one.html pixel.html two.html" ]
    verdict a_short_chapter_is_a_page_of_the_book

    grep -q 'href="one.html#one">One<' "$pages/index.html" && grep -q 'rel="next" href="two.html"' "$pages/one.html" &&
        grep -q 'rel="prev" href="camera.html"' "$pages/one.html" &&
        [ "$(grep -o '<h1' "$pages/two.html" | wc -l)" = 1 ]
    verdict pages_lead_to_the_next_and_into_each_other

    x=$folder/build/docs/out/source/src-x.c.html
    grep -q 'href="../source/src-x.c.html"' "$pages/one.html" && grep -q 'href="../source/src-x.c.html#line-3"' "$pages/one.html" &&
        grep -q 'href="source/src-x.c.html#line-8"' "$folder/build/docs/out/book.html" &&
        grep -q '<span id="line-3" class="line" data-line="3">' "$x" && grep -q 'href="../book/one.html#code-half"' "$x" &&
        grep -q 'href="../book/style.css"' "$x"
    verdict files_are_pages_to_whose_lines_links_lead

    grep -q 'href="glossary.html#glossary">terms<' "$pages/house.html" && grep -q 'href="../source/docs-01_one.md.html">one<' "$pages/house.html" &&
        grep -q 'aria-label="A house"' "$pages/house.html" && grep -q 'Its rooms' "$pages/house.html" && ! grep -q '<img' "$pages/house.html"
    verdict a_text_that_is_also_read_as_it_is_links_to_other_texts

    grep -q '<span id="code-half" class="line" data-line="3">' "$pages/one.html" &&
        grep -q '<span id="code-rk_quarter" class="line" data-line="8">' "$pages/two.html" &&
        grep -q 'href="one.html#code-half" title="static int half(int x)">half</a>' "$pages/two.html" &&
        ! grep -q 'href="#code-half"' "$pages/one.html"
    verdict code_has_its_lines_numbers_and_links_to_the_lines_of_definitions

    grep -q '<div id="listing-half" class="listing">' "$pages/one.html" && grep -q '<div id="listing-rk_quarter"' "$pages/two.html"
    verdict a_listing_has_the_name_of_its_code

    grep -q '^"code-half":"one.html",' "$pages/places.js" && grep -q '^"disks":"two.html",' "$pages/places.js"
    verdict a_list_tells_the_page_of_each_name

    grep -q 'as MiniSearch is missing' "$folder/said1" && [ ! -e "$pages/search.js" ] && ! grep -q search.js "$pages/one.html"
    verdict without_minisearch_a_book_is_woven_and_has_no_search

    # A chapter of more than a screen.
    long=$docs/03_long.md
    lines() { for line in $(seq "$1"); do printf 'Sentence %s of a paragraph, which is as long as a line of a page, and a little longer than that.\n\n' "$line"; done; }
    {
        printf '# Long {#long}\n\nSee [](#sums) and [disks](#disks).\n\n## First {#first}\n\n'
        lines 50
        printf '## Second {#second}\n\n`rk_quarter`{.code} is short.\n\n## Third {#third}\n\n### Within {#within}\n\n[$$x^2$$]{#sums}\n\n'
        lines 50
        for _ in 1 2; do
            printf '## Sizes\n\n'
            lines 50
        done
        printf '## Last quarter {#last}\n\nA short one about refraction.\n\n| what | how |\n|---|---|\n| a pyramid | of pixels |\n| teapot, ms | 123.4 567.8 |\n'
    } >"$long"
    weaves() { # weaves [NAME=VALUE...]: the book
        env RAYKIT_SOURCE="$folder/texts" RAYKIT_BUILD="$folder/build" RAYKIT_DRIVERS="$folder" RAYKIT_VERSION=0 PANDOC="$pandoc" \
            GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= "$@" sh "$source/docs/make_book" >"$folder/said1" 2>&1
    }
    weaves && [ -e "$pages/long.html" ] && [ -e "$pages/second.html" ] && [ ! -e "$pages/first.html" ] && [ ! -e "$pages/third.html" ] &&
        [ ! -e "$pages/last.html" ]
    verdict a_page_ends_where_it_fills_a_screen_and_a_short_rest_joins_it

    grep -q '<h1 class="of-chapter"><a href="long.html#long">.*Long</a></h1>' "$pages/second.html" && grep -q '<title>2.2 Second – 2 Long – ' "$pages/second.html" &&
        grep -q 'rel="prev" href="long.html"' "$pages/second.html" && grep -q 'rel="next" href="sizes.html"' "$pages/second.html" &&
        grep -q 'rel="next" href="house.html"' "$pages/long-sizes.html" && grep -q '<li><a href="long.html#first">' "$pages/second.html" && grep -q '<li><a href="#third">' "$pages/second.html"
    verdict a_section_s_page_has_a_name_of_its_own_its_chapter_s_title_and_contents_and_leads_on

    grep -q 'href="second.html#sums"' "$pages/long.html" && grep -q 'href="two.html#code-rk_quarter"' "$pages/second.html" &&
        grep -q '^"within":"second.html"' "$pages/places.js"
    verdict links_lead_to_the_pages_of_sections

    dead_links() { python3 -B -c 'import sys; sys.path.insert(0, sys.argv[1]); import page_links; dead = page_links.dead_links(sys.argv[2]); print(*dead, sep="\n"); sys.exit(bool(dead))' "$source/tests" "$1"; }
    dead_links "$folder/build/docs/out" >"$folder/said1"
    verdict no_link_of_the_pages_is_dead

    sed 's/#third/#without/' "$pages/second.html" >"$pages/planted.html"
    ! dead_links "$folder/build/docs/out" >"$folder/said1" && grep -qx 'book/planted.html: planted.html#without' "$folder/said1" && ! grep -q '^book/[^p]' "$folder/said1"
    verdict a_dead_link_would_be_found

    minisearch=$source/build-aux/node_modules/minisearch
    if node=$(command -v node) && [ -e "$minisearch/package.json" ]; then
        weaves RAYKIT_NODE="$node" RAYKIT_MINISEARCH="$minisearch"
        looks_up() { # looks_up WORDS: the first place that is found
            "$node" -e 'const window = {};
                require("vm").runInNewContext(require("fs").readFileSync(process.argv[1], "utf8"), {window});
                const [hit] = window.raykitFind(process.argv[2]);
                if (hit) console.log(`${window.raykitSections[hit.at][0]}#${hit.name} ${hit.text}`);' \
                "$pages/search.js" "$1" 2>&1
        }
        [ "$(looks_up 'refracion short')" = 'long-sizes.html#last-p1 A short one about refraction.' ] && grep -q 'id="last-p1"' "$pages/long-sizes.html" &&
            grep -q 'id="last-p1"' "$folder/build/docs/out/book.html"
        verdict a_paragraph_is_found_by_a_wrong_letter_and_has_a_name

        [ "$(looks_up 'pyram pixels')" = 'long-sizes.html#last-p2 a pyramid; of pixels' ] && [ "$(looks_up rk_quarter)" = 'two.html#code-rk_quarter ' ] &&
            [ "$(looks_up 'unit disk')" = 'glossary.html#term-unit-disk ' ] && [ -z "$(looks_up teapot)" ]
        verdict rows_of_words_functions_and_terms_are_found

        [ "$(looks_up quarter)" = 'long-sizes.html#last ' ]
        verdict a_section_comes_before_a_function_with_its_word

        tr '\n' ' ' <"$pages/house.html" | grep -q '</p> *<figure class="picture sketch"[^>]*> *<svg .*</svg> *<figcaption class="caption">.*<span id="[^"]*" class="at"></span>.*Its rooms.*</figcaption> *</figure>'
        verdict figures_are_whole_where_their_captions_have_names

        dead_links "$folder/build/docs/out" >"$folder/said1" && grep -q 'Permission is hereby granted' "$pages/search.js" &&
            grep -q '<script type="text/plain" id="search-script">' "$folder/build/docs/out/book.html"
        verdict what_is_found_is_there
    else
        count=$((count + 1))
        echo "ok $count # SKIP a_paragraph_is_found: MiniSearch or node is missing: ./bootstrap --site"
    fi
    rm "$long"

    grep -q 'glossary.html#term-unit-disk">unit disk</a>, <a href="two.html#disks">1.1</a>' "$pages/book-index.html" &&
        grep -q 'href="one.html#code-half"><code>half</code></a>, <a href="one.html#one">0</a>' "$pages/book-index.html" &&
        grep -q 'href="#code-half"><code>half</code></a>' "$folder/build/docs/out/book.html"
    verdict the_index_leads_to_where_terms_and_functions_are_explained

    [ "$(grep -c 'class="term"' "$pages/two.html")" = 1 ] && tr '\n' ' ' <"$pages/two.html" |
        grep -q '<p>\(<span id="disks-p1" class="at"></span>\)\{0,1\}All <em><a href="glossary.html#term-unit-disk" class="term">unit disks</a></em>. One unit disk.</p>'
    verdict a_chapter_links_a_term_where_it_uses_it_first

    printf 'int rk_answer(void)\n{\n    /* solution */\n    return 42;\n    /* starter\n    return 0;\n    end */\n}\n' \
        >>"$folder/texts/src/x.c"
    sources() { # sources SOLUTIONS: the book's page of x.c, as text
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc SOLUTIONS=$1 \
            GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1 && sed 's/<[^>]*>//g' "$x"
    }
    sources yes | grep -q 'return 42;' && sources no >"$folder/words" && grep -q 'return 0;' "$folder/words" &&
        ! grep -q 'return 42;\|solution' "$folder/words"
    verdict without_solutions_pages_of_files_show_none

    mkdir -p "$folder/assignments/01_lens"
    printf '#!/bin/sh\necho "t = -2.468"\n' >"$folder/assignments/01_lens/lens"
    chmod +x "$folder/assignments/01_lens/lens"
    prints() { # prints NUMBERS: a book whose text repeats them
        printf '# Pixel {.unnumbered #pixel}\n\n::: {.output driver=lens args=--pixel prints="%s"}\n:::\n' "$1" >"$docs/one_pixel.md"
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc \
            GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1
    }
    prints -2.468 && grep -q 't = -2.468' "$pages/pixel.html"
    verdict a_text_may_repeat_what_a_driver_prints

    steps=$folder/texts/assignments/02_two
    mkdir -p "$steps"
    printf '# Two\n\n| 2 | a | disks | b |\n| 3 | c | other, disks | d |\n' >"$steps/handout.md"
    prints -2.468 && tr '\n' ' ' <"$pages/two.html" | grep -q 'id="disks".*</h2> *<div class="of-step">[^S]*Steps 2 and 3 of the assignment' &&
        ! grep -q 'of-step' "$pages/one.html"
    verdict a_section_names_the_steps_that_it_belongs_to
    rm -r "$steps"

    # Sources, which texts cite by their keys.
    entries() { # entries KEY...: a bibliography with articles of these keys, a year behind the author's name
        for key; do
            printf '@article{%s, author = {%s, A.}, title = {A {BVH} paper}, journal = {A journal}, year = {%s}, doi = {10.1/%s}}\n' \
                "$key" "${key%%[0-9]*}" "${key#"${key%%[0-9]*}"}" "$key"
        done >"$docs/bibliography.bib"
    }
    cites() { # cites TEXT [CHAPTERS]: a book with a chapter's section that says so
        printf '# Two {#two}\n\n## Disks {#disks}\n\n%s\n\n``` {.code file=src/x.c name=rk_quarter}\n```\n' "$1" >"$docs/02_two.md"
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc \
            GNUPLOT= CHROMIUM= QUICK= FEATURES=${2-} MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1
    }
    entries kay1986 wald2007
    printf '# Pixel {.unnumbered #pixel}\n\nBefore @wald2007.\n' >"$docs/one_pixel.md"
    cites 'By @kay1986: boxes, not of a@kay1986.' && tr '\n' ' ' <"$pages/two.html" | tr -s ' ' |
        grep -q 'By <a href="bibliography.html#ref-kay1986" title="kay, A. 1986.[^"]*"[^>]*>kay (1986)</a>: boxes, not of a@kay1986' &&
        grep -q 'href="#ref-kay1986"' "$folder/build/docs/out/book.html"
    verdict a_citation_leads_to_its_entry

    cites 'Boxes [@kay1986].' && tr '\n' ' ' <"$pages/two.html" | grep -q '>(kay 1986)</a>\.'
    verdict in_brackets_it_is_a_remark

    entries kay1986 kay2007 wald2007
    cites 'By @kay1986 and @kay2007.' && tr '\n' ' ' <"$pages/two.html" | grep -q '>kay (2007)<' && ! grep -q '———' "$pages/bibliography.html"
    verdict each_entry_names_its_authors
    entries kay1986 wald2007
    cites 'By @kay1986: boxes, not of a@kay1986.'

    tr '\n' ' ' <"$pages/bibliography.html" | tr -s ' ' >"$folder/words"
    grep -q 'id="ref-kay1986"> kay, A. 1986. “A BVH Paper.”.*href="https://doi.org/10.1/kay1986".*Cited in <a href="two.html#disks">1.1</a>\.' "$folder/words" &&
        grep -q 'id="ref-wald2007">.*Cited in <a href="pixel.html#pixel">Pixel</a>\.' "$folder/words"
    verdict an_entry_has_its_link_and_the_sections_that_cite_it

    ! cites 'By @kay1968 and @kay1986.' && grep -q 'docs/02_two.md:5: @kay1968: docs/bibliography.bib has no such entry' "$folder/said1"
    verdict an_unknown_key_is_a_mistake

    ! cites 'By nobody.' && grep -q 'docs/bibliography.bib: nothing cites kay1986; cite it as @kay1986' "$folder/said1"
    verdict an_entry_that_nothing_cites_is_a_mistake

    alone=$folder/build/docs/out.some/book.html
    cites 'By @kay1986.' two && grep -q 'id="ref-kay1986"' "$alone" && ! grep -q 'id="ref-wald2007"' "$alone" &&
        cites 'By nobody.' two && ! grep -q 'id="bibliography"' "$alone"
    verdict a_chapter_alone_has_the_entries_that_it_cites
    entries

    # What was drawn is kept: the driver notes its calls.
    lens=$folder/assignments/01_lens/lens
    has_parts() { find "$folder/build/drawn" -name '*.part*' | grep -q .; }
    notes() { # notes NUMBER [COMMAND]: the driver, which prints the number
        printf '#!/bin/sh\necho "$*" >>"%s/calls"\n%s\necho "t = %s"\n' "$folder" "${2-}" "$1" >"$lens" && chmod +x "$lens"
    }
    wants() { # wants ARGUMENTS...: a book with the driver's output for each
        printf '# Pixel {.unnumbered #pixel}\n' >"$docs/one_pixel.md"
        for args; do printf '\n::: {.output driver=lens args="%s"}\n:::\n' "$args"; done >>"$docs/one_pixel.md"
    }
    book() { # book [SOLUTIONS]
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc SOLUTIONS=${1-yes} \
            GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1
    }
    calls() { # calls [SOLUTIONS]: how often the driver is called for a book
        : >"$folder/calls"
        book "$@" && wc -l <"$folder/calls"
    }
    notes 1 && wants --one --two
    [ "$(calls)" = 2 ] && [ "$(calls)" = 0 ] && [ "$(calls no)" = 0 ] && grep -q 't = 1' "$pages/pixel.html"
    verdict what_was_drawn_is_not_drawn_again_by_any_edition

    grep -q '^book: nothing is to be drawn; making the pages' "$folder/said1" && grep -q '^book: writing the pages' "$folder/said1"
    verdict what_then_takes_long_is_said

    wants --one --three
    [ "$(calls)" = 1 ] && grep -q -- --three "$folder/calls"
    verdict other_arguments_are_drawn

    notes 2
    [ "$(calls)" = 2 ] && grep -q 't = 2' "$pages/pixel.html" && ! grep -q 't = 1' "$pages/pixel.html"
    verdict another_program_draws_anew

    # They are kept by the text; here others are put in their place.
    sed -i 's/t = 2/t = kept/' "$folder"/build/drawn/coloured/*
    book && grep -q 't = kept' "$pages/pixel.html" && notes 3 && book && grep -q 't = 3' "$pages/pixel.html"
    verdict colours_are_kept_by_the_text

    echo cube >"$folder/mesh.obj" && echo red >"$folder/mesh.mtl"
    wants "--mesh '$folder/mesh.obj'"
    [ "$(calls)" = 1 ] && [ "$(calls)" = 0 ] && echo ball >"$folder/mesh.obj" && [ "$(calls)" = 1 ] &&
        echo green >>"$folder/mesh.mtl" && [ "$(calls)" = 1 ]
    verdict so_does_another_mesh_or_another_material_of_it

    notes 3 'case "$*" in *--bad*) echo "it is bad" >&2; mkdir -p "${*##*--out }/figures"; echo a >"${*##*--out }/figures/a.png"; exit 1 ;; esac'
    wants --one --bad --two
    ! book && grep -q 'it is bad' "$folder/said1" && grep -q 'one_pixel.md:6: this command failed' "$folder/said1" &&
        ! grep -l -- --bad "$folder/build/drawn"/*/key && ! has_parts
    verdict a_driver_that_failed_leaves_nothing

    # Stopped while its second command runs.
    is_kept() { grep -l -- "$1" "$folder"/build/drawn/*/key 2>/dev/null | grep -qv part; }
    notes 4 'case "$*" in *--five*) [ -e "'"$folder"'/slow" ] && { echo $$ >"'"$folder"'/slow.pid"; exec sleep 60; } ;; esac'
    wants --four --five
    : >"$folder/calls" && touch "$folder/slow"
    export RAYKIT_SOURCE="$folder/texts" RAYKIT_BUILD="$folder/build" RAYKIT_DRIVERS="$folder" RAYKIT_VERSION=0 PANDOC="$pandoc"
    setsid sh "$source/docs/make_book" >"$folder/said1" 2>&1 &
    stopped=$!
    while kill -0 $stopped 2>/dev/null && { [ ! -e "$folder/slow.pid" ] || ! is_kept --four; }; do sleep 0.1; done
    kill -TERM "-$stopped"
    wait $stopped
    stopped=$?
    unset RAYKIT_SOURCE RAYKIT_BUILD RAYKIT_DRIVERS RAYKIT_VERSION PANDOC
    rm "$folder/slow"
    left=300
    while has_parts && [ $left -gt 0 ]; do sleep 0.1 && left=$((left - 1)); done # they clean up last
    [ $stopped != 0 ] && ! kill -0 "$(cat "$folder/slow.pid")" 2>/dev/null && ! has_parts
    verdict when_it_is_stopped_so_are_its_drivers

    [ "$(calls)" = 1 ] && grep -q -- --five "$folder/calls"
    verdict and_the_next_one_goes_on_there

    ! prints 2.468 && grep -q 'one_pixel.md:3: the text repeats 2.468, but the driver does not print it' "$folder/said1"
    verdict what_a_driver_does_not_print_cannot_be_repeated
    prints -2.468

    # A driver that tells of its options.
    default() { # default OPTION
        printf '# Pixel {.unnumbered #pixel}\n\nIt is [grid]{.default driver=lens option=%s}.\n' "$1" >"$docs/one_pixel.md"
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc \
            GNUPLOT= CHROMIUM= QUICK= FEATURES= MESHES= sh "$source/docs/make_book" >"$folder/said1" 2>&1
    }
    cat >"$folder/assignments/01_lens/lens" <<'END'
#!/bin/sh
[ "$1" = --help ] || exec echo "t = -2.468"
echo '  --lens-sampling uniform|sobol
                        kind of the samples (of the lens)
                        (default sobol)
  --lens-samples N      their number (1 to 64; default 16)
  --quiet               no progress'
END
    default lens-sampling && grep -q 'It is sobol\.' "$pages/pixel.html" && default lens-samples && grep -q 'It is 16\.' "$pages/pixel.html"
    verdict a_default_is_told_by_the_driver

    ! default quiet && grep -q 'one_pixel.md:3: lens --help names no default of --quiet' "$folder/said1"
    verdict an_option_without_a_default_is_a_mistake
    prints -2.468

    # The instructor's edition: answers below the exercises.
    mkdir "$docs/answers"
    cp "$source/docs/make_book" "$docs"
    rm "$docs/02_two.md"
    printf '# Course {.unnumbered #course}\n\n[One](#one)\n' >"$docs/answers/course.md"
    exercises() { # exercises LEVEL...
        printf '# One {#one}\n\n## Exercises {#one-exercises}\n\n' >"$docs/01_one.md"
        for level; do printf '1. *(%s)* Why?\n' "$level" >>"$docs/01_one.md"; done
        printf '\n## Sources {#one-sources}\n\nNone.\n' >>"$docs/01_one.md"
    }
    some=$folder/build/docs/out.some.answers/book.html
    answered() { # answered TEXT [ANSWERS [CHAPTERS]]: weaves the book with this text of answers
        printf '# Answers {.answers}\n\n%b' "$1" >"$docs/answers/01_one.md"
        RAYKIT_SOURCE=$folder/texts RAYKIT_BUILD=$folder/build RAYKIT_DRIVERS=$folder RAYKIT_VERSION=0 PANDOC=$pandoc \
            GNUPLOT= CHROMIUM= QUICK= FEATURES=${3-} MESHES= ANSWERS=${2-yes} sh "$docs/make_book" >"$folder/said1" 2>&1
    }
    book=$folder/build/docs/out.answers/book.html
    both='**Hint.** Look.\n\n**Answer.** Because\n\nof [one](#one).\n\n'
    exercises easy research
    answered "## 1\n\n$both" &&
        tr '\n' ' ' <"$book" | grep -q 'Why? *<details class="told"><summary>Hint</summary> *<p>Look.</p> *</details> *<details class="told"><summary>Answer</summary> *<p>Because</p> *<p>of <a href="#one">one</a>' &&
        grep -q 'id="course"' "$book" && ! grep -q '>Answers<' "$book"
    verdict answers_unfold_below_their_exercises

    # One chapter of it: the course comes with it, and another chapter's code is named without a link.
    printf '# Two {#two}\n\n``` {.code file=src/x.c name=rk_quarter}\n```\n' >"$docs/02_two.md"
    answered "## 1\n\n**Hint.** Call \`rk_quarter\`{.code}.\n\n**Answer.** [Two](#two).\n\n" yes one &&
        grep -q 'Call <code>rk_<wbr>quarter</code>\.' "$some" && grep -q 'id="course"' "$some" && grep -q 'href="[^"]*#two">Two' "$some"
    verdict a_chapter_of_it_can_be_woven_alone

    answered "## 1\n\n$both" yes "two one" && [ "$(grep -o '<h1[^>]*id="[a-z]*"' "$some" | sed 's/.*id=//' | tr -d '\n')" = '"course""one""two"' ]
    verdict chapters_have_the_order_of_the_course_and_not_that_of_their_names
    rm "$docs/02_two.md"

    # Hours: the chapter has 7 lines here, 0.0 hours to read.
    mkdir -p "$folder/texts/assignments/01_one"
    printf '**Time:** about 8 hours.\n' >"$folder/texts/assignments/01_one/handout.md"
    lasts() { # lasts BETWEEN: a course with the hours of reading, and of half of the assignment
        printf '# Course {.unnumbered #course}\n\nIt takes [5]{.hours read=one solve=one/2 between="%s"} h.\n\n::: {.hours}\n:::\n' "$1" >"$docs/answers/course.md"
        answered "## 1\n\n$both"
    }
    lasts "4 6" && grep -q 'It takes 4\.0 h' "$book" && sed 's/<[^>]*>//g' "$book" | tr '\n' ' ' | grep -q '1 one *[0-9]* *0\.0 *8\.0 *8\.0'
    verdict hours_are_those_of_the_texts

    ! lasts "5 6" && grep -q 'course.md:3: 4.0 hours are not between 5 and 6' "$folder/said1"
    verdict hours_are_within_their_limits
    lasts "4 6"

    answered "## 1\n\n$both" no && ! grep -q 'Because\|id="course"' "$folder/build/docs/out/book.html" && [ -e "$book" ]
    verdict without_being_asked_for_there_are_none

    ! answered "## 1\n\n**Hint.** Look.\n" && grep -q '01_one.md:3: exercise 1 is easy and has no answer' "$folder/said1"
    verdict an_easy_exercise_without_an_answer_is_a_mistake

    ! answered "## 1\n\n$both## 3\n\n$both" &&
        grep -q 'answers/01_one.md:[0-9]*: there is no exercise 3: docs/01_one.md:3 has 2' "$folder/said1"
    verdict an_answer_without_an_exercise_is_a_mistake

    ! answered "## 1\n\nLook.\n" && grep -q 'answers/01_one.md:3: .*begins with \*\*Hint' "$folder/said1"
    verdict an_answer_that_is_not_marked_as_one_is_a_mistake

    exercises middle
    ! answered "## 1\n\n$both" && grep -q '01_one.md:3: exercise 1 begins with (easy), (medium), (hard) or (research)' "$folder/said1"
    verdict an_exercise_has_a_level

    ! answered '' maybe && grep -q 'ANSWERS=maybe: it is yes or no' "$folder/said1"
    verdict answers_are_asked_for_by_yes

    rm -r "$docs/answers"
    ! RAYKIT_SOURCE=$folder/texts ANSWERS=yes sh "$docs/make_book" >"$folder/said1" 2>&1 && grep -q 'has no answers' "$folder/said1"
    verdict a_pack_has_none
    # A program that draws one mistake, in the place of tools/wrong.py.
    cat >"$folder/wrong" <<END
[ "\$1" = fog ] || { echo "wrong: there is no feature \"\$1\"" >&2; exit 1; }
cp "$look/1.png" "\$3/figures/right.png"
cp "$look/2.png" "\$3/figures/wrong.png"
printf 'thin\tholes\tIt has holes.\tThe fog is thin.\ta_claim\t%s\t%s\t--scene cube\n' "\$3/figures/wrong.png" "\$3/figures/right.png"
END
    wrong() { # wrong ATTRIBUTES
        printf '# One {#test-a_claim}\n\n::: {.wrong %s}\n:::\n' "$1" >"$texts/01_one.md"
        report said1 "$folder/texts" "$pandoc"
    }
    page=$folder/build/reports/out/report.html
    wrong stem=fog && grep -q 'alt="It has holes."' "$page" && grep -q 'The fog is thin.' "$page" &&
        grep -q 'href="#test-a_claim"' "$page" && grep -q 'scene cube' "$page"
    verdict a_wrong_picture_stands_beside_the_right_one_with_its_mistake_and_claim

    mkdir -p "$folder/texts/docs" "$folder/texts/assignments/01_fog"
    printf 'test\tpoints\tstep\tsection\n' >"$folder/texts/assignments/01_fog/points.tsv"
    printf '# Fog {#fog}\n\n## Common mistakes {#fog-mistakes}\n' >"$folder/texts/docs/01_fog.md"
    wrong 'stem=fog}
:::

::: {.wrong sees=holes' && tr '\n' ' ' <"$page" |
        grep -q '<div class="beside"> <div class="one"> *<img[^>]*><span class="said">wrong</span> </div> <div class="one"> *<img[^>]*alt="As it should be."[^>]*><span class="said">right</span>'
    verdict all_wrong_pictures_have_the_right_ones_beside_them
    rm -r "$folder/texts/assignments/01_fog" "$folder/texts/docs/01_fog.md"

    ! wrong stem=haze && grep -q 'there is no feature "haze"' "$folder/said1" && grep -q '01_one.md:3: ' "$folder/said1"
    verdict wrong_pictures_of_an_unknown_feature_are_a_mistake

    ! wrong 'stem=fog sees=holes' && grep -q '01_one.md:3: .wrong needs stem=... or sees=...' "$folder/said1"
    verdict wrong_pictures_are_those_of_a_feature_or_of_what_one_sees

    ! wrong sees=gaps && grep -q '01_one.md:3: no wrong.tsv has a picture in which one sees gaps' "$folder/said1"
    verdict wrong_pictures_that_nobody_sees_are_a_mistake
else
    count=$((count + 1))
    echo "ok $count # SKIP a_name_in_two_texts_is_a_mistake: there is no pandoc"
fi

echo "1..$count"
