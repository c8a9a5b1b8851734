-- The bibliography, of which pandoc's citeproc has made the entries (cite.lua finds citations): a list, in
-- which each entry names the sections that cite it. Citations become links that show their entry on pointing
-- at them.

local numbering = require("numbering")

local bibliography = {}

local function link_to_entry(entries)
  return function(cite)
    local id = "ref-" .. cite.citations[1].id
    local text = cite:walk({Link = function(link) return link.content end}).content
    return pandoc.Link(text, "#" .. id, entries[id] or "")
  end
end

local function is_year(inline) return inline.t == "Str" and inline.text:find("^%d%d%d%d%l?%.$") end

-- An entry's text, and the part with its authors, for which citeproc writes a dash where the entry before has
-- the same. But readers come here by links.
local function with_authors(entry, before)
  local text = pandoc.utils.blocks_to_inlines(entry.content)
  local _, year = text:find_if(is_year)
  year = year or 1
  local is_dash = text[1].t == "Str" and text[1].text:find("^———")
  local authors = is_dash and before or pandoc.List({table.unpack(text, 1, year - 1)})
  return authors .. {table.unpack(text, year)}, authors
end

-- Texts that cite nothing have no bibliography.
local function is_text(block) return block.identifier ~= "bibliography" and block.identifier ~= "refs" end

-- Before all else, as it removes citeproc's classes.
function bibliography.list(doc)
  local entries = {}
  doc = doc:walk({Div = function(div)
    if div.identifier ~= "refs" then return nil end
    local text, authors
    div = div:walk({Span = function(span) return span.content end}) -- with classes for citeproc alone
    local items = div.content:map(function(entry)
      text, authors = with_authors(entry, authors)
      entries[entry.identifier] = pandoc.utils.stringify(text)
      return {pandoc.Div({pandoc.Plain(text)}, {id = entry.identifier})}
    end)
    return pandoc.Div(#items > 0 and {pandoc.BulletList(items)} or {}, {id = "refs"})
  end})
  if not next(entries) then doc.blocks = doc.blocks:filter(is_text) end
  return doc:walk({Cite = link_to_entry(entries)})
end

-- --- the sections that cite an entry ---------------------------------------------------------

local function link_to(heading)
  local number = (numbering.label[heading.identifier] or ""):match("%S+$")
  return pandoc.Link(number and {pandoc.Str(number)} or heading.content, "#" .. heading.identifier)
end

-- Headings by the entries that their sections cite.
local function citing_sections(doc)
  local sections, heading = {}, nil
  local function note(link)
    local id = link.target:match("^#(ref%-.*)")
    if not id or not heading then return end
    sections[id] = sections[id] or {}
    if sections[id][#sections[id]] ~= heading then table.insert(sections[id], heading) end
  end
  for _, block in ipairs(doc.blocks) do
    if block.t == "Header" then heading = block else pandoc.Div({block}):walk({Link = note}) end
  end
  return sections
end

-- When sections have their numbers.
function bibliography.name_sections(doc)
  local sections = citing_sections(doc)
  return doc:walk({Div = function(div)
    local said = pandoc.List()
    for i, heading in ipairs(sections[div.identifier] or {}) do
      said:extend({pandoc.Str(i == 1 and "Cited in " or ", "), link_to(heading)})
    end
    if #said == 0 then return nil end
    said:insert(pandoc.Str("."))
    div.content[#div.content].content:extend({pandoc.Space(), pandoc.Span(said, {class = "cited"})})
    return div
  end})
end

return bibliography
