-- Citations: in the book's texts, @kay1986 refers to that entry of docs/bibliography.bib, as "Kay and Kajiya
-- (1986)"; [@kay1986], as "(Kay and Kajiya 1986)". A pandoc filter that runs before pandoc's citeproc, since
-- pandoc itself reads no citations in commonmark_x. An unknown key ends the weaving; so does, where the whole
-- book is woven, an entry that nothing cites.

local tools = os.getenv("RAYKIT_SOURCE") .. "/tools/weave/"
table.insert(package.searchers, 2, function(name) return loadfile(tools .. name .. ".lua") end)
local drive = require("drive")

local path = "docs/bibliography.bib"
local keys, is_cited = pandoc.List(), {}

local function read_keys()
  local text = drive.read_file(drive.source .. "/" .. path) or drive.fail("there is no file %s", path)
  for _, entry in ipairs(pandoc.read(text, "biblatex").meta.references or {}) do
    keys:insert(pandoc.utils.stringify(entry.id))
  end
end

-- A word, on which pandoc may have recorded a position, or "".
local function word_of(inline)
  local inner = inline and inline.t == "Span" and #inline.content == 1 and inline.content[1] or inline
  return inner and inner.t == "Str" and inner.text or ""
end

local function cite(at, key, mode)
  if not keys:includes(key) then
    drive.fail_at(at, "@%s: %s has no such entry; correct the key, or add the entry", key, path)
  end
  is_cited[key] = true
  return pandoc.Cite({pandoc.Str("@" .. key)}, {pandoc.Citation(key, mode)})
end

-- The key behind an "@" that does not belong to an address.
local function key_at(inlines, i)
  if word_of(inlines[i]) ~= "@" or word_of(inlines[i - 1]):find("%w$") then return nil end
  return word_of(inlines[i + 1]):match("^%a%w*$")
end

local function cite_all(inlines)
  local list, i = pandoc.List(), 1
  while inlines[i] do
    local key = key_at(inlines, i)
    local is_in_brackets = key and word_of(inlines[i - 1]) == "[" and word_of(inlines[i + 2]) == "]"
    if is_in_brackets then
      list[#list] = cite(inlines[i], key, "NormalCitation")
    else
      list:insert(key and cite(inlines[i], key, "AuthorInText") or inlines[i])
    end
    i = i + (is_in_brackets and 3 or key and 2 or 1)
  end
  return list
end

local function check_cited()
  local rest = keys:filter(function(key) return not is_cited[key] end)
  if #rest > 0 and os.getenv("RAYKIT_ALONE") == "" then
    drive.fail("%s: nothing cites %s; cite it as @%s, or remove the entry", path, table.concat(rest, ", "),
      rest[1])
  end
end

return {{Pandoc = read_keys}, {Inlines = cite_all}, {Pandoc = check_cited}}
