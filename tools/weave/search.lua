-- What can be searched for: chapters, sections, functions, tests, terms, and each paragraph, item, caption
-- and row of a table, which get a name to which a result leads. Formulas and listings are not read. The index
-- is made by MiniSearch (RAYKIT_MINISEARCH, its folder; empty: there is no search).

local drive = require("drive")
local index = require("index")

local search = {}

local node, library = os.getenv("RAYKIT_NODE") or "", os.getenv("RAYKIT_MINISEARCH") or ""
local paragraphs = {} -- {section, id, text} in the document's order

function search.is_possible() return node ~= "" and library ~= "" end

-- --- paragraphs ------------------------------------------------------------------------------

local function text_of(block)
  local function leave_out(span)
    local class = span.classes[1]
    return (class == "parameters" or class == "from") and {} or nil
  end
  local text = pandoc.utils.stringify(block:walk({Image = function() return {} end, Span = leave_out,
    Math = function() return pandoc.Str("…") end}))
  return (text:gsub("%s+", " "):gsub("^ ", ""):gsub(" $", ""))
end

-- A function that notes a text of this section, and returns an element with its name.
local function namer(section)
  local count = 0
  return function(text)
    count = count + 1
    local id = section .. "-p" .. count
    paragraphs[#paragraphs + 1] = {section = section, id = id, text = text}
    return pandoc.Span({}, {id = id, class = "at"})
  end
end

-- A row of measured numbers has a name and units, and is no answer to a question.
local function has_words(text)
  local _, letters = text:gsub("%a", "")
  local _, digits = text:gsub("%d", "")
  return text:find("%a%a") and letters > digits
end

local function named(name)
  local function block(element)
    local text = text_of(element)
    if not has_words(text) then return nil end
    element.content:insert(1, name(text))
    return element
  end
  local function row(cells)
    local texts, first = {}, nil
    for _, cell in ipairs(cells) do
      local text = text_of(pandoc.Div(cell.contents))
      if text ~= "" then texts[#texts + 1] = text end
      first = first or cell.contents[1]
    end
    local text = table.concat(texts, "; ")
    if first and first.content and has_words(text) then first.content:insert(1, name(text)) end
  end
  return {traverse = "topdown", Para = block, Plain = block, Table = function(tabular)
    for _, body in ipairs(tabular.bodies) do
      for _, one in ipairs(body.body) do row(one.cells) end
    end
    return tabular, false
  end}
end

-- Names the paragraphs of a document, whose headings have names.
function search.name_paragraphs(doc)
  if not search.is_possible() then return doc end
  local names
  for at, block in ipairs(doc.blocks) do
    if block.t == "Header" then
      names = named(namer(block.identifier))
    elseif names then
      doc.blocks[at] = pandoc.Div({block}):walk(names).content[1]
    end
  end
  return doc
end

-- --- the index -------------------------------------------------------------------------------

local function quote(text)
  return '"' .. text:gsub('[%c"\\<]', function(c) return string.format("\\u%04x", c:byte()) end) .. '"'
end

-- The script with the library and its index; nil without the library. `pages` have their HTML and chapters,
-- `page_of` the page of each name.
function search.script(pages, page_of)
  if not search.is_possible() then return nil end
  local sections, places, entries = {}, {}, {}
  local function add(section, name, title, kind, text)
    entries[#entries + 1] = string.format('{"id":%d,"at":%d,"name":%s,"title":%s,"kind":%s,"text":%s}',
      #entries, places[section], quote(name), quote(title), quote(kind), quote(text))
  end
  for _, page in ipairs(pages) do
    local list = index.entries(page)
    for _, entry in ipairs(list) do
      if entry.kind == "chapter" or entry.kind == "section" then
        places[entry.id] = #sections
        sections[#sections + 1] = string.format("[%s,%s,%s,%s]", quote(page.page), quote(entry.id),
          quote(entry.title), quote(index.plain(page.chapter.title)))
      end
    end
    for _, entry in ipairs(list) do
      if places[entry.section.id] then add(entry.section.id, entry.id, entry.title, entry.kind, "") end
    end
  end
  for _, paragraph in ipairs(paragraphs) do
    if page_of[paragraph.id] and places[paragraph.section] then
      add(paragraph.section, paragraph.id, "", "", paragraph.text)
    end
  end
  local given = string.format('{"sections":[%s],"entries":[%s]}', table.concat(sections, ","),
    table.concat(entries, ","))
  return pandoc.pipe(node, {drive.source .. "/tools/weave/make_search.js", library}, given)
end

return search
