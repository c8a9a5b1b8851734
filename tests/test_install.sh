#!/bin/sh
# Can a stranger build against what `make install` left? Run by `make installcheck`.
# usage: CC=compiler CXX=compiler test_install.sh pkgconfigdir includedir version [destdir]
# shellcheck disable=SC2046,SC2086 # the words of CC and of pkg-config are meant to be split
set -eu
pkgconfig=$1 include=$2 version=$3 staging=${4-}

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'exit 1' HUP INT TERM
fail() {
    echo "installcheck: $*" >&2
    exit 1
}

PKG_CONFIG_PATH=$staging$pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
export PKG_CONFIG_PATH
if [ -n "$staging" ]; then
    PKG_CONFIG_SYSROOT_DIR=$staging
    export PKG_CONFIG_SYSROOT_DIR
fi
found=$(pkg-config --modversion raykit) || fail "pkg-config finds no raykit in $staging$pkgconfig"
[ "$found" = "$version" ] || fail "raykit.pc says version $found, not $version"

cat >"$folder/user.c" <<'END'
#include <raykit.h>
#include <stdio.h>
int main(void)
{
    rk_mesh mesh;
    rk_error error;
    if (!rk_mesh_init(&mesh, 3, 1, 1, 0, &error))
        return 1;
    for (unsigned i = 0; i < 3; i++)
        mesh.positions[i] = rk_vec((float)(i * i), 0, 0);
    if (!rk_mesh_validate(&mesh, "mesh", &error) || !rk_mesh_normalize(&mesh, &error))
        return 2;
    for (unsigned i = 0; i < 3; i++)
        printf("%.2f ", (double)mesh.positions[i].x);
    rk_mesh_free(&mesh);
}
END
# The words of CC and of pkg-config's answers are meant to be split.
$CC -std=c17 -o "$folder/user" "$folder/user.c" $(pkg-config --cflags --libs raykit) ||
    fail "a program does not build with what pkg-config says: $(pkg-config --cflags --libs raykit)"
answer=$("$folder/user") || fail "the program ends with status $?"
# 0, 1, 4 less their mean 5/3, over the largest distance 7/3.
[ "$answer" = "-0.71 -0.29 1.00 " ] || fail "the normalized mesh should be -0.71 -0.29 1.00, not $answer"

example=$(dirname "$0")/../examples/render.c
$CC -std=c17 -Wall -Wextra -o "$folder/render" "$example" $(pkg-config --cflags --libs raykit) ||
    fail "examples/render.c does not build"
"$folder/render" teapot "$folder/teapot.png" >/dev/null && [ -s "$folder/teapot.png" ] ||
    fail "examples/render.c made no picture"

if "$folder/render" teapot "$folder/teapot.jpg" >"$folder/said" 2>&1 || [ -e "$folder/teapot.jpg" ]; then
    fail "examples/render.c took a name that it writes no picture for: teapot.jpg"
fi
grep -q 'teapot.jpg.*\.png or \.exr' "$folder/said" || fail "examples/render.c does not say why: $(cat "$folder/said")"

# C++ compilers that are here; configure names g++ even where there is none.
compilers=
for compiler in "$CXX" clang++; do
    if command -v "${compiler%% *}" >/dev/null; then compilers="$compilers|$compiler"; fi
done
cat >"$folder/user.cpp" <<'END'
#include <base/image.h>
#include <raykit.h>
#include <cstdio>
int main()
{
    rk_image image;
    rk_error error;
    if (!rk_image_init(&image, 2, 2, &error))
        return 1;
    *rk_image_at(&image, 1, 1) = rk_add(rk_vec(1, 2, 3), rk_vec(4, 5, 6));
    std::printf("%g", double(image.pixels[3].y));
    rk_image_free(&image);
}
END
IFS='|'
for compiler in ${compilers#|}; do
    unset IFS
    $compiler -std=c++17 -Wall -Wextra -pedantic -Werror -o "$folder/user++" "$folder/user.cpp" \
        $(pkg-config --cflags --libs raykit) || fail "a program does not build with $compiler"
    answer=$("$folder/user++") || fail "the program of $compiler ends with status $?"
    [ "$answer" = 7 ] || fail "the program of $compiler says $answer, not 7"
    $compiler -std=c++17 -x c++ -Wall -Wextra -pedantic -Werror -o "$folder/render++" "$example" \
        $(pkg-config --cflags --libs raykit) || fail "examples/render.c does not build with $compiler"
done

kit=$(cd "$(dirname "$0")/.." && pwd)
if [ -n "$compilers" ]; then
    ! $CXX -std=c++17 -fsyntax-only -I"$kit/src" "$folder/user.cpp" >"$folder/said" 2>&1 &&
        grep -q 'source folder.s headers are for C; make install' "$folder/said" ||
        fail "C++ is not told where its headers are: $(head -3 "$folder/said")"
fi

# All but the list of features, which is for a macro of whoever includes it.
(cd "$staging$include" && find . -name '*.h' ! -path '*/features/list.h') >"$folder/headers"
while read -r header; do
    echo "#include <${header#./}>" >"$folder/header.c"
    $CC -std=c17 -Wall -Wextra -Werror -fsyntax-only $(pkg-config --cflags raykit) "$folder/header.c" ||
        fail "$header does not compile on its own"
    case $compilers in
    "|$CXX"*) $CXX -std=c++17 -x c++ -Wall -Wextra -pedantic -Werror -fsyntax-only \
        $(pkg-config --cflags raykit) "$folder/header.c" || fail "$header does not compile on its own as C++" ;;
    esac
done <"$folder/headers"
echo "installcheck: a program builds and runs, $(wc -l <"$folder/headers") headers compile on their own${compilers:+, as C++ too}"
