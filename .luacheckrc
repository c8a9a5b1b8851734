-- Lua runs inside pandoc, which brings these names.
std = "lua54"
read_globals = { "pandoc", "PANDOC_VERSION", "PANDOC_WRITER_OPTIONS", "PANDOC_SCRIPT_FILE", "FORMAT" }
max_line_length = 110
ignore = { "421", "431" } -- an inner block may use a name anew
