#!/bin/sh
# Meshes of people's own go through make report to its end. The report's texts are cut down to what draws or
# measures each mesh, on few scenes of our own, because the whole takes minutes.
set -u
[ "${1-}" != --list ] || exit 0 # the driver asks for names of tests, which it can do without
source=$(cd "${srcdir:-.}" && pwd)
build=$PWD
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' HUP INT TERM
count=0

# verdict NAME: the status of the last command, and what was said
verdict() {
    result=$?
    count=$((count + 1))
    [ $result = 0 ] || sed 's/^/# /' "$folder/said"
    [ $result = 0 ] || printf 'not '
    echo "ok $count - $1"
}

command -v pandoc >/dev/null || {
    echo "ok 1 # SKIP meshes_are_reported: there is no pandoc"
    echo "1..1"
    exit 0
}

# --- what is reported ---

own=$folder/own
mkdir -p "$own/reports" "$folder/build/tests"
for part in docs tools assignments; do ln -s "$source/$part" "$own/$part"; done
ln -s "$source/reports/weave.lua" "$source/reports/report.css" "$own/reports"
for part in assignments tools tests/stress; do ln -s "$build/$part" "$folder/build/$part"; done
sections=
for text in "$source"/reports/[0-9][0-9]_*.md; do
    grep -q 'each=mesh' "$text" || continue
    stem=$(basename "$text" .md)
    sections="$sections ${stem#*_}"
    awk 'NR == 1 || /each=mesh/ { keeps = 1 }
         /^::: {.timings driver=(bvh_median|sah_binning|cubemap)/ { keeps = 1; sub(/scenes="[^"]*"/, "scenes=\"triangle\""); sub(/ labels="[^"]*"/, "") }
         keeps
         NR == 1 { keeps = 0; print "" }
         /^:::$/ { if (keeps) print ""; keeps = 0 }' "$text" >"$own/reports/${text##*/}"
done

# --- meshes ---

meshes=$folder/it\'s\ \$mine
mkdir "$meshes"
# A box of one colour, from corner (1, 1, 1) to (3, 2, 2).
cat >"$meshes/two  words.obj" <<'END_OF_MESH'
mtllib two  words.mtl
v 1 1 1
v 3 1 1
v 3 2 1
v 1 2 1
v 1 1 2
v 3 1 2
v 3 2 2
v 1 2 2
usemtl red
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 1 5 8 4
f 2 3 7 6
END_OF_MESH
printf 'newmtl red\nKd 0.8 0.1 0.1\n' >"$meshes/two  words.mtl"
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >"$meshes/triangle.ply"
# A ball, and a triangle 500 radii away.
awk 'BEGIN { rows = 12; columns = 24; pi = 3.14159265358979
    for (r = 0; r <= rows; r++) for (c = 0; c < columns; c++)
        printf "v %.6f %.6f %.6f\n", sin(pi*r/rows)*cos(2*pi*c/columns), cos(pi*r/rows), sin(pi*r/rows)*sin(2*pi*c/columns)
    for (r = 0; r < rows; r++) for (c = 0; c < columns; c++) {
        a = r*columns + c + 1; b = r*columns + (c + 1)%columns + 1
        print "f", a, b, b + columns, a + columns }
    print "v 500 0 0\nv 501 0 0\nv 500 1 0\nf -3 -2 -1" }' >"$meshes/stray,1.obj"

# report MESHES: by make, as its user does, but written elsewhere
report() {
    "${MAKE:-make}" -s -C "$build" report abs_srcdir="$own" abs_builddir="$folder/build" CHROMIUM= \
        QUICK=1 ONLY="${only-$sections}" ${up:+UP="$up"} MESHES="$1" >"$folder/said" 2>&1
}

report "$meshes/two  words.obj $meshes/triangle.ply  $meshes/stray,1.obj"
verdict three_meshes_of_different_kinds_are_reported

page=$folder/build/reports/out.some
drawn() { find "$page/figures" -name "*$1*.png" 2>/dev/null | wc -l; }
sections_count=$(echo "$sections" | wc -w)
[ "$sections_count" -ge 9 ] && [ "$(drawn two--words)" = "$sections_count" ] && [ "$(drawn triangle.ply)" = $((sections_count - 1)) ] &&
    [ "$(drawn stray-1)" = "$sections_count" ]
verdict each_section_has_a_picture_of_each

# frame_of MESH: per mille of the frame around all that is not black
frame_of() { grep -a -o 'raykit:frame.[01]\.[0-9]*' "$page/figures/shading_$1"*.png | tr -cd '0-9' | sed 's/^0*//'; }
# A ball has two thirds of each side, a box and half a square somewhat less of one.
[ "$(frame_of stray-1.obj)" -ge 400 ] && [ "$(frame_of two--words.obj)" -ge 250 ] &&
    [ "$(frame_of triangle.ply)" -ge 300 ]
verdict meshes_fill_their_pictures

grep -q "stray,1.obj: 576 of its 577 triangles lie in 0.4 % of its extent" "$folder/said" &&
    tr '\n' ' ' <"$page/report.html" | grep -q 'framed by 576 in 0.4 % of their extent'
verdict strays_are_told

grep -q 'its one triangle cannot be split' "$folder/said" && grep -q 'Not made: this cannot be drawn of triangle.ply' "$page/report.html"
verdict where_there_can_be_none_a_note_says_so

grep -q '^bvh_median,"\{0,1\}two  words.obj"\{0,1\},12,.*,levels,' "$page/tables/bvh_median.csv" &&
    grep -q '^bvh_median,"stray,1.obj",577,.*,leaves,' "$page/tables/bvh_median.csv"
verdict its_tables_have_a_row_for_each

only=shading
report "$meshes/stray,1.obj" && grep -q "stray,1.obj: 576 of its 577 triangles lie" "$folder/said" &&
    tr '\n' ' ' <"$page/report.html" | grep -q 'stray,1.obj: 576 of its 577 triangles lie'
verdict a_kept_picture_keeps_what_was_said_of_its_mesh

tr '\n' ' ' <"$page/report.html" | grep -q 'stray,1.obj by Blinn-Phong'
verdict captions_name_the_mesh

# Two names of one mesh: equal pictures. Nothing of it is seen: a mesh of no area.
cp "$meshes/two  words.obj" "$meshes/again.obj"
printf 'v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n' >"$meshes/nothing.obj"
only='bvh_median ambient_occlusion' up=z
report "$meshes/two  words.obj $meshes/again.obj $meshes/nothing.obj" &&
    grep -q 'nothing.obj.*: little can be seen' "$folder/said" && grep -q 'Little can be seen' "$page/report.html"
verdict where_little_can_be_seen_a_note_says_so

grep -a -q -- '--up z' "$page"/figures/bvh_median_again.obj_*.png
verdict meshes_whose_z_is_up_are_turned

only=bvh_median up=
refused() { # refused MESHES REASON
    ! report "$1" && grep -qF -- "$2" "$folder/said"
}
refused "$meshes/two  words.obj $meshes/missing.obj" "MESHES: there is no such file: $meshes/missing.obj"
verdict a_missing_file_is_named

mkdir "$folder/meshes"
refused "$folder/meshes" "MESHES: $folder/meshes is a folder"
verdict so_is_a_folder

up=w
refused "$meshes/triangle.ply" 'UP=w: it is x, y or z'
verdict an_axis_that_is_none_is_refused
up=

refused "$meshes/two words.obj" "MESHES: there is no such file: $meshes/two words.obj"
verdict a_name_has_all_of_its_spaces

cp "$meshes/triangle.ply" "$meshes/two--words.obj"
refused "$meshes/two  words.obj $meshes/two--words.obj" "the pictures of two files would be called two--words.obj"
verdict names_whose_pictures_would_be_the_same_are_refused

echo "1..$count"
