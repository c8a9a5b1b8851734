-- Links a term to the glossary where a chapter uses it first: not in headings, code, links, tables and
-- captions.

local drive = require("drive")
local present = require("present")

local glossary = {}

-- Terms that texts use in their everyday sense, too.
local everyday = {}
for word in ([[
at rest|batch|block|blur|child|claim|clip|collapse|composite|counters|crossing|depth|descriptor|dimension|
driver|expansion|face|film|frame|gain|generation|hook|intensity|joint|kernel|lane|level|mask|medium|miss|
pack|plan|prefix|reach|region|root|round|sample|segment|selection|slope|split|stage|starter|static|step|
stream|tap|tile|unit|visibility|weights]]):gsub("\n", ""):gmatch("[^|]+") do
  everyday[word] = true
end

-- Lists of {words, id} by their first words, longer terms first.
local function read_terms()
  local terms = {}
  for line in io.lines(drive.source .. "/docs/glossary.md") do
    local cell = line:match("^| ([^|`($]-) |") -- no symbol; names of functions are linked to their listings
    for term in (cell ~= "term" and cell ~= "symbol" and cell or ""):gmatch("[^,]+") do
      local words = {}
      for word in term:gmatch("%S+") do words[#words + 1] = (word:lower():gsub("'", "’")) end
      if not everyday[table.concat(words, " ")] then
        terms[words[1]] = terms[words[1]] or {}
        table.insert(terms[words[1]], {words = words, id = present.term_id(cell)})
      end
    end
  end
  for _, list in pairs(terms) do table.sort(list, function(a, b) return #a.words > #b.words end) end
  return terms
end

local function is_same(text, word) return text == word or text == word .. "s" end

-- Whether the term stands at an inline; its last inline, and what stands before and after it in the first and
-- the last.
local function match(inlines, at, term, before)
  local last = at + 2 * (#term.words - 1)
  local after = ""
  for i, word in ipairs(term.words) do
    local inline, gap = inlines[at + 2 * (i - 1)], inlines[at + 2 * i - 1]
    if not inline or inline.t ~= "Str" then return nil end
    local text = inline.text
    if i == 1 then text = text:sub(#before + 1) end
    if i == #term.words then
      text, after = text:match("^(.-)([.,;:!?)]*)$")
    elseif not gap or gap.t ~= "Space" and gap.t ~= "SoftBreak" then
      return nil
    end
    if i == #term.words and not is_same(text:lower(), word) or
      i < #term.words and text:lower() ~= word then
      return nil
    end
  end
  return last, after
end

local function find(terms, seen, inlines, at)
  local before, first = inlines[at].text:match("^(%(*)([%w\128-\255-]+)")
  if not first then return nil end
  for _, form in ipairs({first:lower(), (first:lower():gsub("s$", ""))}) do
    for _, term in ipairs(terms[form] or {}) do
      local last, after = match(inlines, at, term, before)
      if last and seen[term.id] then return last end -- a part of this is no use of a shorter term
      if last then return last, term, before, after end
    end
  end
end

local has_text = {Emph = true, Strong = true, Quoted = true}

-- A function of inlines, which it reads in their order.
local function linked(terms, seen)
  local function link(inlines)
    local list, at = pandoc.List(), 1
    while at <= #inlines do
      local last, term, before, after
      if has_text[inlines[at].t] then inlines[at].content = link(inlines[at].content) end
      if inlines[at].t == "Str" then last, term, before, after = find(terms, seen, inlines, at) end
      if term then
        seen[term.id] = true
        local content = pandoc.List()
        for i = at, last do content:insert(inlines[i]:clone()) end
        content[1].text = content[1].text:sub(#before + 1)
        content[#content].text = content[#content].text:sub(1, -1 - #after)
        if before ~= "" then list:insert(pandoc.Str(before)) end
        list:insert(pandoc.Link(content, "#" .. term.id, "", {class = "term"}))
        if after ~= "" then list:insert(pandoc.Str(after)) end
      else
        for i = at, last or at do list:insert(inlines[i]) end
      end
      at = (last or at) + 1
    end
    return list
  end
  return function(block)
    block.content = link(block.content)
    return block
  end
end

-- Only a book with all its parts has the glossary.
function glossary.link(document)
  if drive.page ~= "book" or os.getenv("RAYKIT_ALONE") ~= "" then return nil end
  local terms, seen = nil, {}
  for at, block in ipairs(document.blocks) do
    if block.t == "Header" and block.level == 1 then
      seen = {}
      if block.identifier == "glossary" then break end
    elseif block.t ~= "Header" and block.t ~= "Div" and block.t ~= "Table" then
      terms = terms or read_terms()
      local link = linked(terms, seen)
      document.blocks[at] = pandoc.Div({block}):walk({Para = link, Plain = link}).content[1]
    end
  end
  return document
end

return glossary
