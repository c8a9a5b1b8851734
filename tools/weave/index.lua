-- The names in a woven document: headings, functions, tests and terms, each with its place. Of these the page
-- is searched (pages.lua), and the index consists.
--
--   ::: {.index of=terms}
--   :::
-- lists terms, functions or tests by their letters, each with the sections that explain it: for a function
-- where its listing stands, for a term where it is in a title or, the first time in a chapter, in italics.

local drive = require("drive")

local index = {}

function index.plain(html)
  local text = html:gsub("<[^>]*>", ""):gsub("%s+", " ")
  return (text:gsub("&lt;", "<"):gsub("&gt;", ">"):gsub("&quot;", '"'):gsub("&amp;", "&"))
end

-- --- names and their places ------------------------------------------------------------------

-- Headings of a chapter in their order: {at, level, id, title, number}.
local function headings_of(chapter)
  local list = {}
  for at, level, heading in chapter.html:gmatch("()<h(%d)(.-)</h%d>") do
    local id, title = heading:match('%sid="([^"]+)"[^>]*>(.*)$')
    local number = id and title:match('header%-section%-number">([%d.]+)<')
    if id then
      list[#list + 1] = {at = at, level = level, id = id, title = index.plain(title), number = number}
    end
  end
  return list
end

local function section_at(headings, at)
  local found = headings[1]
  for _, heading in ipairs(headings) do found = heading.at < at and heading or found end
  return found
end

-- Names of a chapter: {title, kind, id, section}; headings first.
function index.entries(chapter)
  local list, headings = {}, headings_of(chapter)
  local function add(title, kind, id, at)
    list[#list + 1] = {title = title, kind = kind, id = id, section = section_at(headings, at)}
  end
  for _, h in ipairs(headings) do add(h.title, h.level == "1" and "chapter" or "section", h.id, h.at + 1) end
  for at, name in chapter.html:gmatch('()<span%s+id="code%-([%w_]+)"') do
    add(name, "code", "code-" .. name, at)
  end
  for at, name in chapter.html:gmatch('()id="test%-([%w_]+)"') do
    add(name, "test", "test-" .. name, at)
  end
  for at, id, term in chapter.html:gmatch('()<span%s+id="(term%-[^"]+)">(.-)</span>') do
    add(index.plain(term), "term", id, at)
  end
  return list
end

-- --- lists -----------------------------------------------------------------------------------

local kinds = {terms = "term", functions = "code", tests = "test"}
local wanted = {} -- lists that the document asks for

function index.directive(div)
  local of = drive.need(div, "of")
  if not kinds[of] then drive.fail_at(div, "of=%s: an index is of terms, functions or tests", of) end
  wanted[of] = true
  return pandoc.Div({}, {class = "index " .. of})
end

local function singular(text) return (text:lower():gsub("s$", "")) end

-- The chapters' headings, and their sections by the words that they have in italics, the first of each word.
local function introductions_of(chapters)
  local list = {}
  for _, chapter in ipairs(chapters) do
    local headings, italics = headings_of(chapter), {}
    for at, text in chapter.html:gmatch("()<em>(.-)</em>") do
      local word = singular(index.plain(text))
      italics[word] = italics[word] or section_at(headings, at)
    end
    local lists_terms = chapter.html:find('id="term-', 1, true) or chapter.html:find('class="index', 1, true)
    if not lists_terms then list[#list + 1] = {headings = headings, italics = italics} end
  end
  return list
end

-- The section of a chapter that introduces a term, if there is one.
local function introduction(chapter, word)
  local whole = "%f[%w]" .. word:gsub("%W", "%%%0") .. "s?%f[%W]"
  for _, heading in ipairs(chapter.headings) do
    if heading.title:gsub("^[%d.]+ ", ""):lower():find(whole) then return heading end
  end
  return chapter.italics[word]
end

local function link(id, text) return string.format('<a href="#%s">%s</a>', id, text) end

local function link_to_section(section) return link(section.id, section.number or section.title) end

local function escape(text) return (text:gsub("&", "&amp;"):gsub("<", "&lt;"):gsub(">", "&gt;")) end

local most_sections = 8 -- a word of most chapters, "claim" for instance, is introduced by none

local function term(entry, chapters)
  local parts, seen = {link(entry.id, escape(entry.title))}, {}
  for word in entry.title:gmatch("[^,]+") do
    for _, chapter in ipairs(chapters) do
      local section = introduction(chapter, singular(word:match("^%s*(.-)%s*$")))
      if section and not seen[section.id] then parts[#parts + 1] = link_to_section(section) end
      seen[section and section.id or ""] = true
    end
  end
  return table.concat(parts, ", ", 1, #parts > most_sections and 1 or #parts)
end

local function name(entry)
  local code = "<code>" .. entry.title:gsub("_", "_<wbr>") .. "</code>"
  return link(entry.id, code) .. ", " .. link_to_section(entry.section)
end

-- Functions without their prefix.
local function sort_key(entry) return entry.title:lower():gsub("^rk_", ""):gsub("^[^%w]+", "") end

local function list_of(entries, kind, chapters)
  local rows, lines, letter = {}, {}, nil
  for _, entry in ipairs(entries) do
    if entry.kind == kind then rows[#rows + 1] = {key = sort_key(entry), entry = entry} end
  end
  table.sort(rows, function(a, b) return a.key < b.key or a.key == b.key and a.entry.id < b.entry.id end)
  for _, row in ipairs(rows) do
    local first = row.key:sub(1, 1):upper()
    if first ~= letter then
      lines[#lines + 1] = (letter and "</ul>\n" or "") .. '<p class="letter">' .. first .. "</p>\n<ul>"
    end
    letter = first
    lines[#lines + 1] = "<li>" .. (kind == "term" and term(row.entry, chapters) or name(row.entry)) .. "</li>"
  end
  return table.concat(lines, "\n") .. (letter and "\n</ul>" or "")
end

-- The lists as HTML, by what they list; the document's chapters have their HTML.
function index.lists(chapters)
  local entries, lists = {}, {}
  if not next(wanted) then return lists end
  for _, chapter in ipairs(chapters) do
    local own = index.entries(chapter)
    table.move(own, 1, #own, #entries + 1, entries)
  end
  local introductions = introductions_of(chapters)
  for of in pairs(wanted) do lists[of] = list_of(entries, kinds[of], introductions) end
  return lists
end

return index
