#!/bin/sh
# Linters, for make check-format: shellcheck for shell, luacheck for Lua, flake8 for Python. Their settings stand in
# .shellcheckrc, .luacheckrc and .flake8. One that is missing is said, and is a failure where CI is set, as git hosts
# and .ci/run do.
# usage: tools/lint.sh
set -u
cd "$(dirname "$0")/.." || exit 1
failed=0

# A clone that was built in has more files than are ours.
ours() {
    find . \( -name build-aux -o -name .git -o -name 'raykit-*' -o -name out -o -name 'out.*' -o -name impl \) -prune \
        -o -type f "$@" -print
}

shell_files() {
    ours -name '*.sh'
    for file in .ci/run bootstrap docs/make_book reports/make_report tests/fresh_debian tests/lean/check \
        tests/stress/matrix tests/tap_driver tools/autograder/run_autograder tools/hooks/pre-push; do
        [ ! -f "$file" ] || echo "$file" # packs lack some
    done
}

# lint LINTER PACKAGE OPTION...: names of files come from standard input
lint() {
    linter=$1 package=$2
    shift 2
    if command -v "$linter" >/dev/null; then
        xargs "$linter" "$@" || failed=1
    else
        echo "check-format: $linter is missing (Debian: apt-get install $package), so its files are not checked" >&2
        [ -z "${CI-}" ] || failed=1
    fi
}

lint shellcheck shellcheck --format=gcc <<FILES
$(shell_files)
FILES
lint luacheck lua-check --quiet --codes --no-color <<FILES
$(ours -name '*.lua')
FILES
lint flake8 flake8 <<FILES
$(ours -name '*.py')
FILES
exit $failed
