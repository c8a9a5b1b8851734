-- What drivers have made, kept in a folder of the build: an entry for each command line, with a digest of all
-- else that decides about it. Report and book share the folder; an interrupted weaving goes on where it was,
-- and a changed program draws anew. A pack has such a folder, too (RAYKIT_RECORD), whose entries serve any
-- program.
--
-- An entry has: key, the command; by, the digest; printed, the driver's output, with {folder} in place of its
-- folder; said, its messages; files, their list; made, the folder with them.

local csv = require("csv")

local store = {folder = os.getenv("RAYKIT_STORE") or "", used = {}}

-- Returns a file's contents, or nil where there is none.
function store.read(path)
  local file = io.open(path, "rb")
  if not file then return nil end
  local text = file:read("a")
  file:close()
  return text
end

function store.path(key) return store.folder .. "/" .. pandoc.utils.sha1(key) end

-- The entry of a command in a folder of them, or nil. by=nil: made by any program.
function store.find(folder, key, by)
  if folder == "" then return nil end
  local name = pandoc.utils.sha1(key)
  local entry = folder .. "/" .. name
  local made_by = store.read(entry .. "/by")
  if not made_by or by and made_by ~= by .. "\n" then return nil end
  store.used[entry] = name
  return entry
end

-- --- digests -------------------------------------------------------------------------------------

local digests = {} -- by path

local function quote(word) return "'" .. word:gsub("'", "'\\''") .. "'" end

local function first_line_of(command)
  local pipe = io.popen(command)
  local line = pipe:read("l") or ""
  pipe:close()
  return line
end

-- A file's digest; empty where there is none.
function store.digest_of_file(path)
  if not digests[path] then
    digests[path] = first_line_of(
      "{ sha256sum <" .. quote(path) .. " || shasum -a 256 <" .. quote(path) .. "; } 2>/dev/null")
  end
  return digests[path]
end

-- Of a mesh, with the materials, data and pictures that may belong to it: those in its folder and one below.
local function digest_of_named(path)
  local folder = path:match("^(.*)/[^/]*$") or "."
  digests[folder .. "/"] = digests[folder .. "/"] or first_line_of("find " .. quote(folder) ..
    " -maxdepth 2 -type f \\( -iname '*.mtl' -o -iname '*.bin' -o -iname '*.png' -o -iname '*.jp*g' -o " ..
    "-iname '*.tga' -o -iname '*.bmp' -o -iname '*.exr' -o -iname '*.hdr' \\) " ..
    "-exec ls -ln {} + 2>/dev/null | cksum")
  return store.digest_of_file(path) .. digests[folder .. "/"]
end

-- The words of a command's arguments, without the quotes that drive.quote gave them.
function store.named(args)
  local list = {}
  local function take(word) list[#list + 1] = word:gsub("\1", "'") return "" end
  local rest = args:gsub("'\\''", "\1"):gsub("'([^']*)'", take)
  rest:gsub("%S+", take)
  return list
end

-- Of files that decide about a command, of those that its words name, and of some texts.
function store.digest(files, named, texts)
  local parts = {table.unpack(texts)}
  for _, path in ipairs(files) do parts[#parts + 1] = store.digest_of_file(path) end
  for _, word in ipairs(named) do
    if word:find("[./]") and store.digest_of_file(word) ~= "" then
      parts[#parts + 1] = digest_of_named(word)
    end
  end
  return pandoc.utils.sha1(table.concat(parts, "\n"))
end

-- --- use -----------------------------------------------------------------------------------------

-- How many columns name a row, all if it is not known. Timings and errors are measured again under the same
-- name.
local function key_columns(header)
  for i, column in ipairs(header) do
    if column == "median" or column == "seconds" and header[i - 1] == "samples" then return i - 1 end
  end
  return #header
end

-- Puts the rows into a table, in the place of older ones of the same name.
local function add_rows(header, added, path)
  local there, rows = csv.read(path)
  if not there or table.concat(there, ",") ~= table.concat(header, ",") then rows = {} end
  local n, place = key_columns(header), {}
  for i, row in ipairs(rows) do place[table.concat(row, "\0", 1, n)] = i end
  for _, row in ipairs(added) do rows[place[table.concat(row, "\0", 1, n)] or #rows + 1] = row end
  return csv.write(path, header, rows)
end

local folders = {} -- that are there

local function make_folder(path)
  if not folders[path] then os.execute("mkdir -p " .. quote(path)) end
  folders[path] = true
end

local function copy(from, to)
  local text, file = store.read(from), io.open(to, "wb")
  return text and file and file:write(text) and file:close()
end

-- Puts an entry's files into a folder, and returns what the driver printed; or nil and the file that cannot
-- be written.
function store.place(entry, folder)
  for name in (store.read(entry .. "/files") or ""):gmatch("[^\n]+") do
    local from, to = entry .. "/made/" .. name, folder .. "/" .. name
    make_folder(to:match("^(.*)/"))
    local header, rows
    if name:find("^tables/.*%.csv$") then header, rows = csv.read(from) end
    local done
    if header then done = add_rows(header, rows, to) else done = copy(from, to) end
    if not done then return nil, to end
  end
  return (store.read(entry .. "/printed"):gsub("{folder}", (folder:gsub("%%", "%%%%"))))
end

-- What make() returns, a text; or what it returned for the same key in an earlier weaving. `kind` is a folder
-- of the store, of which weave.sh removes what is old.
function store.remember(kind, key, make)
  local folder = store.folder .. "/" .. kind
  local path = folder .. "/" .. pandoc.utils.sha1(key)
  local text = store.folder ~= "" and store.read(path)
  if text then return text end
  text = make()
  if store.folder == "" then return text end
  make_folder(folder)
  local part = path .. ".part" .. (os.getenv("RAYKIT_SCRAPS") or ""):match("[^/]*$") -- others may weave
  local file = io.open(part, "wb")
  if file and file:write(text) and file:close() then os.rename(part, path) end
  return text
end

-- The names of an entry's tables, one after the other.
function store.tables(entry) return (store.read(entry .. "/files") or ""):gmatch("tables/([^\n]+)%.csv") end

-- Keeps tables, {header, rows} by their files' names, as an entry. Returns its path, or nil where it cannot
-- be written.
function store.keep(key, by, tables)
  local entry = store.path(key)
  local part, names, done = entry .. ".part", {}, true
  os.execute("rm -rf " .. quote(part) .. " && mkdir -p " .. quote(part .. "/made/tables"))
  for name, all in pairs(tables) do
    names[#names + 1] = "tables/" .. name .. "\n"
    done = csv.write(part .. "/made/tables/" .. name, all.header, all.rows) and done
  end
  for name, text in pairs({files = table.concat(names), printed = "", key = key .. "\n", by = by .. "\n"}) do
    local file = io.open(part .. "/" .. name, "w")
    done = file and file:write(text) and file:close() and done
  end
  done = done and os.execute("rm -rf " .. quote(entry) .. " && mv " .. quote(part) .. " " .. quote(entry))
  return done and store.find(store.folder, key, by) or nil
end

-- What was used, for weave.sh: which entries are not to be removed, and which a pack takes along.
function store.list_used()
  local names = {}
  for _, name in pairs(store.used) do names[#names + 1] = name end
  table.sort(names)
  return table.concat(names, "\n") .. "\n"
end

return store
