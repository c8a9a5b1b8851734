# What make_report and make_book share, to be read in by them; they set RAYKIT_WEAVES first (book or
# report), and make sets the rest.
: "${RAYKIT_WEAVES:?}" "${RAYKIT_SOURCE:?run make $RAYKIT_WEAVES}" "${RAYKIT_BUILD:?}" "${RAYKIT_VERSION:?}"

say() { echo "$RAYKIT_WEAVES: $*" >&2; }

if [ -z "${PANDOC-}" ]; then
    say "pandoc is missing: run ./bootstrap, or install pandoc and run ./configure again"
    exit 1
fi

RAYKIT_RUNS=5
RAYKIT_SIZE=
note=
if [ -n "${QUICK-}" ]; then # a trial of the text itself, not of speed
    RAYKIT_RUNS=1 RAYKIT_SIZE=160 note=', a quick trial with small pictures and single runs'
fi
RAYKIT_GNUPLOT=${GNUPLOT-}

# Mesh files are named as seen from where make was called.
for mesh in ${MESHES-}; do
    [ -r "$mesh" ] || { say "MESHES: $mesh cannot be read"; exit 1; }
done

processor=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)
machine="${processor:-$(uname -m)}, $(getconf _NPROCESSORS_ONLN) processors"
system=$(sed -n 's/^PRETTY_NAME="\(.*\)"/\1/p' /etc/os-release 2>/dev/null)
system="${system:-$(uname -s)}, $(uname -sr)"

rm -rf "$RAYKIT_OUT"
mkdir -p "$RAYKIT_OUT/figures" "$RAYKIT_OUT/tables"
trap 'rm -rf "$RAYKIT_OUT/$RAYKIT_WEAVES".html.part "$RAYKIT_OUT/$RAYKIT_WEAVES".pdf.part "$RAYKIT_OUT/parts"' EXIT

# Pages link to sources by relative ways, so that a folder can move as a whole.
RAYKIT_SOURCE_LINK=$(realpath --relative-to="$RAYKIT_OUT" "$RAYKIT_SOURCE" 2>/dev/null) ||
    RAYKIT_SOURCE_LINK=$RAYKIT_SOURCE
export RAYKIT_WEAVES RAYKIT_SOURCE RAYKIT_SOURCE_LINK RAYKIT_BUILD RAYKIT_OUT RAYKIT_RUNS RAYKIT_SIZE \
    RAYKIT_GNUPLOT MESHES

# weave FOLDER TEXT... OPTION...: the page, from FOLDER's filter, template and stylesheet
weave() {
    folder=$1
    shift
    "$PANDOC" --standalone --self-contained --from=commonmark_x+sourcepos --to=html5 --toc --toc-depth=2 \
        --resource-path="$RAYKIT_OUT" --lua-filter="$RAYKIT_SOURCE/$folder/weave.lua" \
        --template="$RAYKIT_SOURCE/$folder/template.html" \
        --css="$RAYKIT_SOURCE/tools/weave/page.css" --css="$RAYKIT_SOURCE/$folder/$RAYKIT_WEAVES.css" \
        --variable=version:"$RAYKIT_VERSION" --variable=machine:"$machine" --variable=system:"$system" \
        --output="$RAYKIT_OUT/$RAYKIT_WEAVES.html.part" "$@"
    mv "$RAYKIT_OUT/$RAYKIT_WEAVES.html.part" "$RAYKIT_OUT/$RAYKIT_WEAVES.html"
    say "wrote $RAYKIT_OUT/$RAYKIT_WEAVES.html"
}

print_pdf() {
    if [ -z "${CHROMIUM-}" ]; then
        say "no $RAYKIT_WEAVES.pdf: it needs chromium"
        return
    fi
    sandbox=
    [ "$(id -u)" != 0 ] || sandbox=--no-sandbox # chromium refuses root otherwise
    profile=$(mktemp -d)
    status=0
    "$CHROMIUM" --headless $sandbox --disable-gpu --no-pdf-header-footer \
        --user-data-dir="$profile" --print-to-pdf="$RAYKIT_OUT/$RAYKIT_WEAVES.pdf.part" \
        "file://$RAYKIT_OUT/$RAYKIT_WEAVES.html" >"$profile/log" 2>&1 || status=1
    [ $status = 0 ] || tail -n 3 "$profile/log" >&2
    rm -rf "$profile"
    if [ $status != 0 ]; then
        say "chromium could not print the PDF (its last words stand above)"
        exit 1
    fi
    mv "$RAYKIT_OUT/$RAYKIT_WEAVES.pdf.part" "$RAYKIT_OUT/$RAYKIT_WEAVES.pdf"
    say "wrote $RAYKIT_OUT/$RAYKIT_WEAVES.pdf"
}
