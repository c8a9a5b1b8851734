# shellcheck shell=sh
# Runs a command for the weaver in a folder of its own, and keeps what it made in the store (tools/weave/store.lua), whole
# or not at all. draw.sh FOLDER NUMBER: the file FOLDER/NUMBER sets key, by and entry, and defines run FOLDER. Says
# "NUMBER STATUS" at the end; the command's own messages are in FOLDER/NUMBER.said, and kept, too. Ends with 255, at which xargs ends, if the
# command failed and forgiving is empty.
job=$1/$2
# shellcheck disable=SC1090 # it is made for each job
. "$job"
: "${key?}" "${by?}" "${entry?}"
part=$entry.part.$$
trap 'rm -rf "$part"' EXIT
trap 'exit 255' HUP INT TERM

run_it() {
    mkdir -p "$part/made/figures" "$part/made/tables" || return
    run "$part/made" >"$part/out"
}

keep_it() {
    # shellcheck disable=SC2097,SC2098 # awk is told the same folder
    part=$part awk 'BEGIN { folder = ENVIRON["part"] "/made" }
        { while (at = index($0, folder)) $0 = substr($0, 1, at - 1) "{folder}" substr($0, at + length(folder)); print }' \
        "$part/out" >"$part/printed" &&
        (cd "$part/made" && find . -type f | sed 's|^\./||') >"$part/files" &&
        rm "$part/out" && cp "$job.said" "$part/said" && printf '%s\n' "$key" >"$part/key" && printf '%s\n' "$by" >"$part/by" || return
    rm -rf "$entry" && mv "$part" "$entry"
}

run_it 2>"$job.said"
status=$?
if [ $status = 0 ]; then keep_it 2>>"$job.said" || status=1; fi
echo "$2 $status"
[ $status = 0 ] || [ -n "$forgiving" ] || exit 255
