-- Numbers: chapters by the order of their files; sections, figures, tables and displayed formulas within
-- their chapter. A link without a text, [](#name), becomes the name of its target, such as "Figure 9.4".

local drive = require("drive")

local numbering = {
  label = {}, -- "Figure 9.4", by identifier
}

-- The places of the texts whose names begin with two digits, from 0.
local function order_of_files()
  local order, folder = {}, drive.page == "report" and "reports" or "docs"
  for i, path in ipairs(drive.list(drive.source, folder .. "/[0-9][0-9]_*.md")) do
    order[path:sub(#drive.source + 2)] = i - 1
  end
  return order
end

-- --- headings --------------------------------------------------------------------------------

local counts = {} -- of headings, by level; the first is the chapter's number

local function number_heading(header)
  if not counts[1] or header.classes:includes("unnumbered") then return end
  for level = 2, header.level do counts[level] = counts[level] or 0 end
  if header.level > 1 then counts[header.level] = counts[header.level] + 1 end
  for level = header.level + 1, 6 do counts[level] = nil end
  local number = table.concat(counts, ".", 1, header.level)
  numbering.label[header.identifier] = (header.level == 1 and "Chapter " or "Section ") .. number
  header.content:insert(1, pandoc.Span({pandoc.Str(number)}, {class = "header-section-number"}))
  header.content:insert(2, pandoc.Space())
end

-- --- figures, tables and formulas ------------------------------------------------------------

local seen -- figures, tables and formulas of the chapter so far

-- The next number of a kind in this chapter, and a name for what has none.
local function next_of(kind)
  seen[kind] = seen[kind] + 1
  local number = (counts[1] and counts[1] .. "." or "") .. seen[kind]
  return number, kind:lower() .. "-" .. number:gsub("%.", "-")
end

local function is_caption(block) return block.t == "Div" and block.classes:includes("caption") end

-- A listing shows no number; without a name it gets one of it.
local function name_listing(div)
  if div.identifier == "" and counts[1] then
    local _, name = next_of("Listing")
    div.identifier = name
  end
  return div
end

-- Figures and tables are divisions until they are presented (present.lua).
local function number_division(div)
  if div.classes:includes("listing") then return name_listing(div) end
  local kind = div.classes:includes("picture") and "Figure" or div.classes:includes("numbers") and "Table"
  if not kind or not counts[1] then return nil end
  local number, name = next_of(kind)
  local caption = div.content[#div.content]
  if div.identifier == "" then div.identifier = name end
  numbering.label[div.identifier] = kind .. " " .. number
  if caption and is_caption(caption) and caption.content[1] then
    local link = pandoc.Link({pandoc.Str(kind .. "\u{a0}" .. number)}, "#" .. div.identifier, "",
      {class = "number"})
    caption.content[1].content:insert(1, link)
    caption.content[1].content:insert(2, pandoc.Space())
  end
  return div
end

local function number_formula(math)
  if math.mathtype ~= "DisplayMath" then return nil end
  if not counts[1] then return pandoc.Span({math}, {class = "equation"}) end
  local number, name = next_of("Equation")
  numbering.label[name] = "Equation (" .. number .. ")"
  local link = pandoc.Link({pandoc.Str("(" .. number .. ")")}, "#" .. name, "", {class = "number"})
  return pandoc.Span({math, link}, {id = name, class = "equation"})
end

-- [$$...$$]{#name}: the name moves to the formula.
local function name_formula(span)
  local equation = span.identifier ~= "" and #span.content == 1 and span.content[1]
  while equation and equation.t == "Span" and not equation.classes:includes("equation") do
    equation = #equation.content == 1 and equation.content[1]
  end
  if not equation or equation.t ~= "Span" or not equation.content[2] then return nil end
  numbering.label[span.identifier] = numbering.label[equation.identifier]
  equation.identifier = span.identifier
  equation.content[2].target = "#" .. span.identifier
  return equation
end

-- --- filters ---------------------------------------------------------------------------------

function numbering.assign(doc)
  local order = order_of_files()
  for i, block in ipairs(doc.blocks) do
    if block.t == "Header" then
      if block.level == 1 then
        counts = {order[drive.place(block):match("^(.-):%d+$")]}
        seen = {Figure = 0, Table = 0, Equation = 0, Listing = 0}
      end
      number_heading(block)
    elseif seen then
      block = pandoc.Div({block}):walk({Math = number_formula})
      block = block:walk({Div = number_division, Span = name_formula})
      doc.blocks[i] = block.content[1]
    end
  end
  return doc
end

function numbering.refer(link)
  local name = link.target:match("^#(.*)$")
  if #link.content > 0 or not name then return nil end
  local label = numbering.label[name]
  if not label then
    if os.getenv("RAYKIT_ALONE") == "" then
      drive.fail_at(link, "[](#%s): this is no numbered heading, figure, table or formula; " ..
        "give the link a text", name)
    end
    label = "another chapter" -- which is not woven now
  end
  link.content = {pandoc.Str((label:gsub(" ", "\u{a0}")))}
  return link
end

return numbering
