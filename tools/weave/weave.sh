# shellcheck shell=sh
# Common to make_report and make_book, which source it. They set RAYKIT_WEAVES (report or book) and
# texts (the folder with its texts, filter and stylesheet) first; make sets the rest.
: "${RAYKIT_WEAVES:?}" "${texts:?}" "${RAYKIT_SOURCE:?}" "${RAYKIT_BUILD:?}" "${RAYKIT_DRIVERS:?}" \
    "${RAYKIT_VERSION:?}"

# The new page is made beside the old one and replaces it when it is complete. A page of some features
# alone, for who writes about them, leaves the whole one as it is.
RAYKIT_ALONE=${FEATURES-}
answers=${answers-} # the folder with answers to the exercises, or empty
bibliography=${bibliography-} # the file with the entries that texts cite, or empty
final=$RAYKIT_BUILD/$texts/out${FEATURES:+.some}${answers:+.answers}
RAYKIT_OUT=$final.part
RAYKIT_SCRAPS=$(mktemp -d) || exit 1 # it has said which folder, and why

say() { echo "$RAYKIT_WEAVES: $*" >&2; }

give_up() {
    say "$*; an older $RAYKIT_WEAVES, if there is one, is untouched"
    exit 1
}

interrupted() {
    say "interrupted; what is drawn is kept, and the same command goes on with it. An older $RAYKIT_WEAVES, if there is" \
        "one, is untouched"
    exit 130
}

# Another who makes the same page works in the same folder: what is there is not ours before mkdir.
started=
clean_up() {
    rm -rf "$RAYKIT_SCRAPS" ${started:+"$RAYKIT_OUT"} || :
}
trap clean_up EXIT
trap interrupted HUP INT TERM

[ -n "${PANDOC-}" ] || give_up "${NO_PANDOC:-pandoc is missing}"
[ -n "${RAYKIT_NODE-}" ] && [ -n "${RAYKIT_MINISEARCH-}" ] ||
    say "it has no search, as MiniSearch is missing (./bootstrap --site installs it)"

# What drivers make is kept here (tools/weave/store.lua). A pack brings RAYKIT_RECORD, what its book shows.
RAYKIT_STORE=${RAYKIT_STORE:-$RAYKIT_BUILD/drawn}
RAYKIT_RECORD=${RAYKIT_RECORD-}
[ -z "$RAYKIT_RECORD" ] || QUICK=$(sed -n 3p "$RAYKIT_RECORD/machine")

RAYKIT_RUNS=3 # rounds
RAYKIT_SIZE=
note=
if [ -n "${QUICK-}" ]; then # a trial of the text itself, not of speed
    # shellcheck disable=SC2034 # make_report and make_book use it
    RAYKIT_RUNS=1 RAYKIT_SIZE=160 note=', a quick trial: pictures are small and times are single runs, but the text describes full-size pictures'
fi
RAYKIT_GNUPLOT=${GNUPLOT-}

# All meshes are tried before anything is rendered. Their paths are relative to the folder where make
# was called; tables and captions have their bare names, pictures the letters, digits and dots of these.
. "$RAYKIT_SOURCE/tools/weave/mesh_names.sh"
MESHES=$(mesh_names "${MESHES-}") || give_up "MESHES names files, with a space between two (see above)"
case ${RAYKIT_UP:-y} in
x | y | z) ;;
*) give_up "UP=$RAYKIT_UP: it is x, y or z, the axis of the meshes that points up" ;;
esac
case ${RAYKIT_FRONT:-usual} in
"${RAYKIT_UP:-y}" | -"${RAYKIT_UP:-y}") give_up "FRONT=$RAYKIT_FRONT: that axis points up; choose another one, or UP" ;;
x | y | z | -x | -y | -z | usual) ;;
*) give_up "FRONT=$RAYKIT_FRONT: it is x, y, z, -x, -y or -z, the axis of the meshes that points to the viewer" ;;
esac
names=/
while IFS= read -r mesh; do
    [ -n "$mesh" ] || continue
    name=$(basename "$mesh" | cut -b -63)
    drawn=$(printf %s "$name" | LC_ALL=C tr -c 'A-Za-z0-9._' -)
    case $names in
    */"$drawn"/*) give_up "MESHES: the pictures of two files would be called $drawn; rename $mesh" ;;
    esac
    names=$names$drawn/
    "$RAYKIT_BUILD"/assignments/01_bvh_median/bvh_median --mesh "$mesh" --up "${RAYKIT_UP:-file}" \
        --front "${RAYKIT_FRONT:-usual}" --width 1 --height 1 --quiet --out "$RAYKIT_SCRAPS" </dev/null || give_up "MESHES: $mesh cannot be used (its reason is above)"
done <<END
$MESHES
END

processor=$(sed -n '/^model name[^:]*: /{ s///p; q; }' /proc/cpuinfo 2>/dev/null) || :
RAYKIT_PROCESSORS=$(nproc 2>/dev/null || getconf _NPROCESSORS_ONLN)
machine="${processor:-$(uname -m)}, $(getconf _NPROCESSORS_ONLN) processors"
RAYKIT_MACHINE=$machine
RAYKIT_TERMINAL=
[ ! -t 2 ] || RAYKIT_TERMINAL=yes
RAYKIT_MEASURED=${MEASURED-}
system=
# shellcheck disable=SC1091 # by its standard a file for the shell
[ ! -e /etc/os-release ] || system=$(. /etc/os-release && echo "${PRETTY_NAME-}")
system="${system:-$(uname -s)}, $(uname -sr)"

# A page with a student's units says so under its title.
RAYKIT_UNITS=
[ ! -f "$RAYKIT_DRIVERS/units" ] || RAYKIT_UNITS=$(cat "$RAYKIT_DRIVERS/units")

# Reported before anything is rendered.
unwritable="$final cannot be written (the reason is above): free some space, or build in a folder of your own"
[ -d "$RAYKIT_BUILD/$texts" ] || mkdir -p "$RAYKIT_BUILD/$texts" || give_up "$unwritable"
if ! mkdir "$RAYKIT_OUT" 2>/dev/null; then
    other=$(cat "$RAYKIT_OUT/process" 2>/dev/null || :)
    if [ -n "$other" ] && kill -0 "$other" 2>/dev/null; then
        give_up "process $other is making it in $RAYKIT_OUT: wait for it, build in a folder of your own, or" \
            "remove that folder if it is left over"
    fi
    rm -rf "$RAYKIT_OUT" && mkdir "$RAYKIT_OUT" || give_up "$unwritable"
fi
started=yes
echo $$ >"$RAYKIT_OUT/process" && mkdir "$RAYKIT_OUT/figures" "$RAYKIT_OUT/tables" "$RAYKIT_OUT/source" "$RAYKIT_OUT/$RAYKIT_WEAVES" ||
    give_up "$unwritable"

if [ -n "$RAYKIT_RECORD" ]; then
    machine=$(sed -n 1p "$RAYKIT_RECORD/machine") system=$(sed -n 2p "$RAYKIT_RECORD/machine")
fi
printf '%s\n' "$machine" "$system" "${QUICK-}" >"$RAYKIT_OUT/machine" || give_up "$unwritable"

# Pages link to sources by relative paths, so that the whole folder can be moved.
RAYKIT_SOURCE_LINK=$(realpath --relative-to="$RAYKIT_OUT" "$RAYKIT_SOURCE" 2>/dev/null) ||
    RAYKIT_SOURCE_LINK=$RAYKIT_SOURCE
export RAYKIT_WEAVES RAYKIT_SOURCE RAYKIT_SOURCE_LINK RAYKIT_DRIVERS RAYKIT_UNITS RAYKIT_OUT \
    RAYKIT_SCRAPS RAYKIT_STORE RAYKIT_RECORD RAYKIT_RUNS RAYKIT_SIZE RAYKIT_PAIR RAYKIT_GNUPLOT MESHES RAYKIT_ALONE \
    RAYKIT_MEASURED RAYKIT_MACHINE RAYKIT_PROCESSORS RAYKIT_TERMINAL

# has_answers TEXT: whether the text after it has answers to its exercises, in an edition with answers
has_answers() {
    [ -n "$answers" ] && grep -q '^## Exercises' "$1" || return 1
    [ -e "$answers/${1##*/}" ] || give_up "ANSWERS=yes: $answers/${1##*/} is missing, with the answers to this chapter's exercises"
}

# weave_features OPTION... [TEXT...]: the page, with the texts of FEATURES in the place of all, in the course's order
weave_features() {
    chosen= # a text per line
    for feature in $FEATURES; do
        for text in "$RAYKIT_SOURCE/$texts"/[0-9][0-9]_"$feature".md; do
            [ -e "$text" ] || text=$RAYKIT_SOURCE/$texts/$feature.md
            [ -e "$text" ] || text=$RAYKIT_SOURCE/docs/$feature.md # the summary, which both pages have
            [ -e "$text" ] || give_up "there is no feature $feature (named by FEATURES or ONLY)"
            chosen="$chosen$text
"
        done
    done
    while IFS= read -r text; do
        set -- "$@" "$text"
        if has_answers "$text"; then set -- "$@" "$answers/${text##*/}"; fi
    done <<END
$(printf %s "$chosen" | LC_ALL=C sort -u)
END
    weave "$@" ${bibliography:+"${bibliography%.bib}.md"}
}

# weave_whole OPTION... TEXT...: the page with its cover, which a part has not
weave_whole() {
    cover=$RAYKIT_SOURCE/docs/pictures/cover.png
    if [ -e "$cover" ]; then # a copy, so that the page's folder can be moved
        cp "$cover" "$RAYKIT_OUT/figures" || give_up "$unwritable"
        set -- --variable=cover:figures/cover.png "$@"
    fi
    weave "$@"
}

# weave OPTION... TEXT...: the page, and beside it the folder with the same in pages, which share a
# stylesheet and the scripts. formulas_css: KaTeX's, if there is one
weave() {
    cat "$RAYKIT_SOURCE/tools/weave/page.css" "$RAYKIT_SOURCE/$texts/$RAYKIT_WEAVES.css" \
        >"$RAYKIT_OUT/$RAYKIT_WEAVES/style.css" &&
        cp "$RAYKIT_SOURCE/tools/weave/page.js" "$RAYKIT_SOURCE/tools/weave/compare.js" "$RAYKIT_OUT/$RAYKIT_WEAVES" || give_up "$unwritable"
    status=0
    "$PANDOC" --standalone --self-contained --from=commonmark_x+sourcepos --to=html5 \
        ${bibliography:+--lua-filter="$RAYKIT_SOURCE/tools/weave/cite.lua" --citeproc --bibliography="$bibliography"} \
        --resource-path="$RAYKIT_OUT" --lua-filter="$RAYKIT_SOURCE/$texts/weave.lua" \
        --template="$RAYKIT_SOURCE/tools/weave/template.html" \
        --css="$RAYKIT_SOURCE/tools/weave/page.css" --css="$RAYKIT_SOURCE/$texts/$RAYKIT_WEAVES.css" \
        ${formulas_css:+--css="$formulas_css"} --variable=page:"$RAYKIT_WEAVES" --variable=version:"$RAYKIT_VERSION" \
        --variable=machine:"$machine" --variable=system:"$system" \
        ${RAYKIT_UNITS:+--variable=units:"${RAYKIT_UNITS#units: }"} \
        --output="$RAYKIT_OUT/$RAYKIT_WEAVES.html" "$@" || status=$?
    [ $status != 130 ] || interrupted
    [ $status = 0 ] || give_up "the $RAYKIT_WEAVES could not be made"
}

print_pdf() {
    sandbox=
    [ "$(id -u)" != 0 ] || sandbox=--no-sandbox # chromium refuses root otherwise
    # From its own folder: in a URL, some characters of a folder's name would not stand for themselves.
    (cd "$RAYKIT_OUT" && exec "$CHROMIUM" --headless $sandbox --disable-gpu --no-pdf-header-footer \
        --user-data-dir="$RAYKIT_SCRAPS/chromium" --print-to-pdf="$RAYKIT_OUT/$RAYKIT_WEAVES.pdf" \
        "$RAYKIT_WEAVES.html") >"$RAYKIT_SCRAPS/log" 2>&1 &&
        [ -s "$RAYKIT_OUT/$RAYKIT_WEAVES.pdf" ] && return
    tail -n 3 "$RAYKIT_SCRAPS/log" >&2
    give_up "chromium could not print the PDF (its last message is above)"
}

give_up_after_all() {
    say "the numbers of this machine do not bear out $(cat "$RAYKIT_SCRAPS/wrong") of its sentences (above), which are marked:" \
        "measure again on a quiet machine, or correct the text"
    exit 1
}

# The store stays bounded: it keeps the entries that were used last, and no remains of what was interrupted.
kept_entries=3000 # two or three times what report and book have
# shellcheck disable=SC2012 # entries are named by digests
tidy_store() {
    [ -d "$RAYKIT_STORE" ] || return 0
    (cd "$RAYKIT_STORE" && xargs touch -c . <"$RAYKIT_OUT/used" || exit
        set -- *
        [ $# -lt $kept_entries ] || ls -t | tail -n +$kept_entries | xargs rm -rf
        if [ -d coloured ]; then touch coloured && find coloured -type f -mtime +30 -exec rm -f {} +; fi
        set -- *.part*
        [ ! -e "$1" ] || find . -maxdepth 1 -name '*.part*' -mmin +60 -exec rm -rf {} +) || :
}

# Prints the page if there is chromium, and replaces the old page.
publish() {
    tidy_store
    pdf="(no $RAYKIT_WEAVES.pdf: it needs chromium)"
    case ${CHROMIUM-} in
    '') ;;
    unused) pdf="(no $RAYKIT_WEAVES.pdf, which is left out of packs)" ;;
    *)
        print_pdf
        pdf="and $final/$RAYKIT_WEAVES.pdf"
        ;;
    esac
    parts="the same in pages: $final/$RAYKIT_WEAVES/index.html"
    [ "$RAYKIT_WEAVES" = book ] || parts="with its pictures as files: $final/$RAYKIT_WEAVES/index.html"
    rm -rf "$final.old" "$RAYKIT_OUT/process" || give_up "$unwritable"
    trap '' HUP INT TERM # the two moves belong together
    [ ! -e "$final" ] || mv "$final" "$final.old" || give_up "$unwritable"
    mv "$RAYKIT_OUT" "$final" || give_up "$unwritable"
    [ ! -e "$final.old" ] || rm -rf "$final.old"
    say "wrote $final/$RAYKIT_WEAVES.html, $parts $pdf"
    [ ! -e "$RAYKIT_SCRAPS/verdict" ] || cat "$RAYKIT_SCRAPS/verdict" >&2
    # Who makes or has a pack did not write its sentences.
    [ ! -e "$RAYKIT_SCRAPS/wrong" ] || [ "${RAYKIT_JUDGES:-yes}" = no ] || give_up_after_all
}
