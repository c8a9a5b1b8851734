# shellcheck shell=sh
# mesh_names TEXT: the files that a text names, a line each. Names are separated by spaces and may contain some: a word
# that is no file is taken together with those after it. Where there is no such file, says so and fails.
mesh_names() (
    is_no_file() {
        if [ -d "${1%% *}" ]; then
            echo "MESHES: ${1%% *} is a folder: name a mesh file in it" >&2
        else
            echo "MESHES: there is no such file: $1 (names are written without quotes; ~ and * stand for themselves)" >&2
        fi
    }
    rest=$1
    while rest=${rest#"${rest%%[! ]*}"} && [ -n "$rest" ]; do
        name= tail=$rest
        while [ ! -f "$name" ]; do
            [ -n "$tail" ] || {
                is_no_file "$rest"
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
