#!/bin/sh
# Gradescope runs this once, as root, when it makes the container of an assignment: unpacks the kit, installs what
# grading needs, and builds. What it is given goes to bootstrap. AUTOGRADER is another place than /autograder, for tests.
set -eu
place=${AUTOGRADER-/autograder}
mkdir -p "$place/kit"
tar -xzf "$place/source/kit.tar.gz" -C "$place/kit" --strip-components=1
cd "$place/kit"
./bootstrap --student "$@"
make -s grade-ready judges-ready ASSIGNMENTS="$(cat "$place/source/assignments")"
