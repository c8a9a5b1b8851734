# shellcheck shell=sh
# mesh_names TEXT: the files that a text names, a line each. Names are separated by spaces and may contain some: a word
# that is no file is taken together with those after it. Where there is no such file, says so and fails.
mesh_names() (
    rest=$1
    while rest=${rest#"${rest%%[! ]*}"} && [ -n "$rest" ]; do
        name= tail=$rest
        while [ ! -f "$name" ]; do
            [ -n "$tail" ] || {
                echo "MESHES: no file's name begins here: $rest" >&2
                exit 1
            }
            word=${tail%%[! ]*}
            tail=${tail#"$word"}
            word=$word${tail%% *}
            tail=${tail#"${tail%% *}"}
            name=$name$word
        done
        printf '%s\n' "$name"
        rest=$tail
    done
)
