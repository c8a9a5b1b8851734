# shellcheck shell=sh
# Runs a command for the weaver in a folder of its own, and keeps what it made in the store (tools/weave/store.lua), whole
# or not at all. draw.sh FOLDER NUMBER: the file FOLDER/NUMBER sets key, by and entry, and defines run FOLDER. Says
# "NUMBER STATUS" at the end; the command's own messages are kept, too, or in FOLDER/NUMBER.said if it failed. Ends with
# 255, at which xargs ends, if the command failed and forgiving is empty. Hundreds of these run for one page: it starts
# no process but mkdir, the command and mv.
job=$1/$2
# shellcheck disable=SC1090 # it is made for each job
. "$job"
: "${key?}" "${by?}" "${entry?}"
part=$entry.part.$$
trap '[ ! -e "$part" ] || rm -rf "$part"' EXIT
trap 'exit 255' HUP INT TERM

# The command's output, with {folder} in the place of its folder.
print() {
    while IFS= read -r line || [ -n "$line" ]; do
        head=
        while case $line in *"$part/made"*) ;; *) false ;; esac; do
            head="$head${line%%"$part/made"*}{folder}" line=${line#*"$part/made"}
        done
        printf '%s\n' "$head$line"
    done <"$job.out"
}

# list FOLDER: the files in it and below
list() {
    for file in "$1"/*; do
        if [ -d "$file" ]; then list "$file"; elif [ -e "$file" ]; then printf '%s\n' "${file#"$part/made/"}"; fi
    done
}

keep() {
    print >"$part/printed" && list "$part/made" >"$part/files" &&
        printf '%s\n' "$key" >"$part/key" && printf '%s\n' "$by" >"$part/by" || return
    [ ! -e "$entry" ] || rm -rf "$entry" || return
    mv "$part" "$entry"
}

status=1
if mkdir -p "$part/made/figures" "$part/made/tables" 2>"$job.said"; then
    run "$part/made" >"$job.out" 2>"$part/said"
    status=$?
    [ $status != 0 ] || keep 2>>"$part/said" || status=1
    [ $status = 0 ] || cp "$part/said" "$job.said"
fi
echo "$2 $status"
[ $status = 0 ] || [ -n "$forgiving" ] || exit 255
