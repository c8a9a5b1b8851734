#!/bin/sh
# The Cornell box, a lens and a moving block by raykit and by Blender's Cycles: both pictures of each, their
# difference, and the ratio in each region. Fails if the two disagree. Run by `make compare` in the build
# folder, which sets what is used here. RAYKIT_SIDE and RAYKIT_SAMPLES, of raykit's pictures, are for tests.
set -eu
: "${RAYKIT_SOURCE:?run make compare}" "${RAYKIT_BUILD:?run make compare}"
tools=$RAYKIT_SOURCE/tools/compare final=$RAYKIT_BUILD/compare
new=$final.part

fail() {
    echo "compare: $*" >&2
    exit 1
}

[ -n "${BLENDER-}" ] ||
    fail "Blender is missing: run ./bootstrap --peers, or install the package blender and run ./configure again"

# Enough for a standard error below the largest that counts as agreement (src/driver/region_ratio.h).
side=${RAYKIT_SIDE-128} samples=${RAYKIT_SAMPLES-256} their_samples=512

log=$(mktemp) || exit 1
trap 'rm -rf "$log" "$new"' EXIT
trap 'exit 130' HUP INT TERM
rm -rf "$new"

echo "compare: rendering by raykit" >&2
"$RAYKIT_BUILD/tools/compare/compare" --export --pictures "$new" --side "$side" --samples "$samples"

# Two pictures of each scene, with seeds of their own: their difference is the noise.
for scene in "$new"/*.json; do
    for seed in 1 2; do
        picture=${scene%.json}_cycles_$seed.exr
        echo "compare: rendering ${scene##*/} by Blender, $seed of 2" >&2
        "$BLENDER" --background --factory-startup --python-exit-code 1 --python "$tools/cycles.py" -- \
            "$scene" "$picture" $their_samples $seed >"$log" 2>&1 </dev/null && [ -s "$picture" ] || {
            tail -n 5 "$log" >&2
            fail "Blender could not render ${scene##*/} (its last messages are above); older pictures are untouched"
        }
    done
done
rm -rf "$final" && mv "$new" "$final"

agree=yes
"$RAYKIT_BUILD/tools/compare/compare" --table --check --pictures "$final" --out "$final" || agree=no
echo "compare: pictures are in $final; make report ONLY=compare makes a page of them" >&2
[ $agree = yes ]
