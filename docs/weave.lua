-- Weaves the book: a pandoc filter that puts the real code, tests, figures and numbers into the
-- chapters. Beside the directives of tools/weave/weave.lua there are here:
--
--   ``` {.code file=src/features/bvh_median.c name=select_lowest}
--   The caption, in Markdown; may be empty.
--   ```
-- becomes the definition of that name (or of several, one below the other), from the comment above
-- it to its closing brace, with a link to its file. `select_lowest`{.code} links to it.
--
--   ::: {.claims stem=bvh_median}
--   :::
-- becomes the list of the suite's tests, each of which unfolds into its code, with its points and
-- the section to read where the assignment has a table of points. `up_to_four_...`{.test} links to
-- a test there.
--
--   ::: {.sketch file=docs/sketches/slabs.svg}
--   The caption.
--   :::
-- takes a drawing into the page itself, where it follows the reader's colours. So does ![The
-- caption](sketches/flow.svg), in a paragraph of its own, in texts that are also read as they are.
--
--   ::: {.output driver=bvh_median args="--scene cornell --pixel 400,300"}
--   The caption.
--   :::
-- shows what a driver prints. prints="0.647837 ..." lists numbers that the text around it repeats: weaving
-- ends if the kit's driver does not print one.
--
--   ::: {.replay unit=bvh_median figure=selection}
-- shows a unit's functions step by step: tools/weave/replay.lua.
--
--   Packets are older: @wald2001.
-- cites an entry of docs/bibliography.bib (tools/weave/cite.lua, tools/weave/bibliography.lua).
--
--   ::: {.index of=terms}
-- lists where terms, functions or tests are explained (tools/weave/index.lua).
--
-- Answers to exercises, in the instructor's edition, and hours: see tools/weave/answers.lua and hours.lua.
--
-- Metadata: solutions=no shows starters in the places of solutions. Environment: RAYKIT_NODE and
-- RAYKIT_KATEX (its folder) for formulas; without them they stay pandoc's affair.

local tools = os.getenv("RAYKIT_SOURCE") .. "/tools/weave/"
table.insert(package.searchers, 2, function(name) return loadfile(tools .. name .. ".lua") end)
local answers = require("answers")
local bibliography = require("bibliography")
local code = require("code")
local drive = require("drive")
local hours = require("hours")
local index = require("index")
local listings = require("listings")
local replay = require("replay")
local weave = require("weave")
local wrong = require("wrong")
local anchor, fail, fail_at, need, place = weave.anchor, drive.fail, drive.fail_at, drive.need, drive.place

local solutions = true

local function settings(meta)
  local given = meta.solutions and pandoc.utils.stringify(meta.solutions) or "yes"
  if given ~= "yes" and given ~= "no" then fail("solutions=%s: it is yes or no", given) end
  solutions = given == "yes"
end

-- --- code and tests --------------------------------------------------------------------------

-- Returns a definition and its file. Of a student's file in a pack, what lacks there is the starter's.
local function definition(element, file, name)
  local found, wrong = code.find(drive.source .. "/" .. file, file, name, solutions)
  local starters = file:gsub("^workbook/", "src/features/")
  if starters ~= file then
    local starter = code.find(drive.source .. "/" .. starters, starters, name, solutions)
    if starter and found then
      found.written = found.text ~= starter.text
      found.own = starter.own
    elseif starter then
      starter.missing = file
      return starter, starters
    end
  end
  if not found then fail_at(element, "%s", wrong) end
  return found, file
end

-- What is said below a student's part, or nil.
local function whose(found)
  if found.missing then return "This is the starter; " .. found.missing .. " does not define it." end
  if found.written then return "Your code." end
  if found.own and found.later then return "Left open here: a later assignment asks for it." end
  if found.own then return "Yours to write." end
end

local function file_line(element, file, line)
  local target = weave.link_to_file(file, element, line)
  return pandoc.Link({pandoc.Code(file), pandoc.Str(", line " .. line)}, target)
end

-- A name that may go on in the next line behind each underscore.
local function breakable(name)
  return pandoc.RawInline("html", "<code>" .. name:gsub("_", "_<wbr>") .. "</code>")
end

local function code_inline(element)
  local class = element.classes[1]
  if class == "code" or class == "test" then
    return pandoc.Link({breakable(element.text)}, "#" .. class .. "-" .. element.text, "",
      {["data-pos"] = element.attributes["data-pos"]})
  elseif class then
    fail_at(element, "there is no directive called .%s", class)
  end
end

-- A caption that stands where Markdown is not read, in a code block.
local function inlines_of(block)
  local function placed(directive)
    return function(element)
      element.attributes["data-pos"] = block.attributes["data-pos"]
      return directive(element)
    end
  end
  local inlines = pandoc.utils.blocks_to_inlines(pandoc.read(block.text, "commonmark_x").blocks)
  return pandoc.Plain(inlines):walk({Code = placed(code_inline), Link = placed(weave.resolve)}).content
end

local function listing(block)
  local file = need(block, "file")
  local texts, numbers, said, first, from, anchors = {}, pandoc.List(), {}, nil, nil, {}
  for name in need(block, "name"):gmatch("%S+") do
    local found, place = definition(block, file, name)
    texts[#texts + 1] = found.text
    if #numbers > 0 then numbers:insert(0) end
    numbers:extend(found.numbers)
    first, from = first or found.line, from or place
    local note = whose(found)
    if note and not said[note] then said[note], said[#said + 1] = true, note end
    local id = anchor("code-" .. name)
    if id ~= "" then
      anchors[#anchors + 1] = id .. ":" .. found.line
      listings.define(name, place, found.signature)
    end
  end
  local top = pandoc.List({pandoc.Span({file_line(block, from, first)}, {class = "from"})})
  top:extend(inlines_of(block))
  local content = {
    pandoc.Div({pandoc.Plain(top)}, {class = "caption"}),
    listings.block(table.concat(texts, "\n\n"), from, numbers, block.attributes.name,
      table.concat(anchors, " ")),
  }
  if #said > 0 then
    content[3] = pandoc.Div({pandoc.Plain(table.concat(said, " "))}, {class = "yours"})
  end
  local _, line_ends = content[2].text:gsub("\n", "")
  local name = "listing-" .. need(block, "name"):match("%S+")
  return pandoc.Div(content, {id = anchor(name), class = line_ends > 22 and "listing long" or "listing"})
end

local known_languages = {c = true, sh = true, text = true}

local function code_block(block)
  local class = block.classes[1]
  if class == "code" then return listing(block) end
  if class and not known_languages[class] then
    fail_at(block, "there is no directive called .%s", class)
  end
end

-- Points and sections by test, in the order of the table; empty while there is no table.
local function read_points(stem)
  local path = drive.list(drive.source, "assignments/*_" .. stem .. "/points.tsv")[1]
  local rows = {}
  if not path then return rows end
  local at = nil
  for line in io.lines(path) do
    local test, points, section = line:match("^([^\t]*)\t([^\t]*)\t[^\t]*\t#?([^\t]*)$")
    if not test then fail("%s: this line is not test, points, step and section: %s", path, line) end
    if at then rows[test] = {points = points, section = section} end
    at = true -- the first line is the header
  end
  return rows
end

local function claims(div)
  local stem = need(div, "stem")
  local file = "tests/test_" .. stem .. ".c"
  local tests, wrong = code.tests(drive.source .. "/" .. file, file)
  if not tests then fail_at(div, "%s", wrong) end
  local points, blocks = read_points(stem), pandoc.List()
  for _, test in ipairs(tests) do
    local found = definition(div, file, test)
    local id = anchor("test-" .. test):gsub("^.+$", ' id="%0"') -- the first of this name
    local top = pandoc.List({breakable(test)})
    local bottom = pandoc.List({file_line(div, file, found.line)})
    if points[test] then
      local count = points[test].points
      if count ~= "0" then
        top:insert(pandoc.Span(count .. (count == "1" and " point" or " points"), {class = "points"}))
      end
      bottom:extend({pandoc.Str("; explained in "), pandoc.Link("its section", "#" .. points[test].section,
        "", {["data-pos"] = div.attributes["data-pos"]})})
      points[test] = nil
    end
    blocks:extend({
      pandoc.RawBlock("html", '<details class="claim"' .. id .. "><summary>"),
      pandoc.Plain(top), pandoc.RawBlock("html", "</summary>"),
      listings.block(found.text, file, found.numbers, test),
      pandoc.Div({pandoc.Plain(bottom)}, {class = "caption"}),
      pandoc.RawBlock("html", "</details>"),
    })
  end
  local left = next(points)
  if left then fail_at(div, "points.tsv names a test that %s does not have: %s", file, left) end
  blocks:insert(1, pandoc.RawBlock("html", '<details class="list-of-claims"><summary>All ' .. #tests ..
    " claims of the suite, each with its test; a check adds two that all units have in common</summary>"))
  blocks:insert(pandoc.RawBlock("html", "</details>"))
  return pandoc.Div(blocks, {class = "claims"})
end

-- --- sketches and outputs --------------------------------------------------------------------

local function sketch(div)
  local path = need(div, "file")
  local drawing = drive.read_file(drive.source .. "/" .. path) or fail_at(div, "there is no file %s", path)
  return pandoc.Div({pandoc.RawBlock("html", drawing), drive.caption(div.content)},
    {class = "picture sketch"})
end

local function lone_sketch(paragraph)
  local image = #paragraph.content == 1 and paragraph.content[1]
  if not image or image.t ~= "Image" or not image.src:find("^sketches/") then return nil end
  local at = image.attributes["data-pos"] or paragraph.attributes and paragraph.attributes["data-pos"]
  return sketch(pandoc.Div({pandoc.Plain(image.caption)}, {file = "docs/" .. image.src, ["data-pos"] = at}))
end

-- A student's units, and starters in a pack, may print other numbers.
local function check_printed(div, text)
  if drive.units ~= "" then return end
  for _, number in ipairs(drive.words(div.attributes.prints)) do
    if not text:find("%f[%w.-]" .. number:gsub("%p", "%%%0") .. "%f[^%w.]") then
      fail_at(div, "the text repeats %s, but the driver does not print it; correct the text or prints=",
        number)
    end
  end
end

local function output(div)
  local args = need(div, "args")
  local text = drive.run(div, args .. " --quiet", drive.scraps)
  check_printed(div, text)
  local command = "$ " .. div.attributes.driver .. " " .. args .. "\n"
  return pandoc.Div({
    pandoc.CodeBlock(command .. text:gsub("%s+$", ""), {class = "text"}), drive.caption(div.content),
  }, {class = "listing"})
end

-- --- formulas --------------------------------------------------------------------------------

local node, katex = os.getenv("RAYKIT_NODE") or "", os.getenv("RAYKIT_KATEX") or ""
local formulas, places, rendered = pandoc.List(), {}, {}

local function key_of(math)
  return (math.mathtype == "DisplayMath" and "D" or "I") .. math.text
end

local collect = {
  Math = function(math)
    if not rendered[key_of(math)] then formulas:insert(key_of(math)) end
  end,
  Span = function(span)
    local first = span.content[1]
    if first and first.t == "Math" then places[key_of(first)] = place(span) end
  end,
}

-- Before the drivers run, which takes minutes: a formula may be wrong.
local function render_all()
  if katex == "" or #formulas == 0 then return end
  local answers = pandoc.pipe(node, {tools .. "formulas.js", katex}, table.concat(formulas, "\30"))
  local i = 0
  for answer in (answers .. "\30"):gmatch("([^\30]*)\30") do
    i = i + 1
    if answer:sub(1, 1) ~= "H" then
      fail("%s: %s", places[formulas[i]] or "a formula", answer:sub(2))
    end
    rendered[formulas[i]] = answer:sub(2)
  end
  formulas = pandoc.List()
end

local function render(math)
  if katex == "" then return nil end
  return pandoc.RawInline("html", rendered[key_of(math)])
end

return {
  {Meta = settings},
  {Pandoc = bibliography.list},
  {Pandoc = answers.weave},
  collect,
  {Pandoc = render_all},
  table.unpack(weave.filters({
    Div = {claims = claims, hours = hours.div, index = index.directive, sketch = sketch, output = output,
      replay = replay.figure(function() return solutions end)},
    Span = {hours = hours.span},
    Code = code_inline,
    CodeBlock = code_block,
    Para = lone_sketch,
    late = {{Pandoc = wrong.mark_steps}, {Pandoc = bibliography.name_sections}, collect,
      {Pandoc = render_all}, {Math = render}},
  })),
}
