-- What a unit draws on the way to the right picture: .wrong, its common mistakes, and .steps, its steps.

local drive = require("drive")
local pictures = require("pictures")
local fail_at = drive.fail_at

local tools = {}

-- --- thumbnails ------------------------------------------------------------------------------

local narrowest = 160 -- pixels, with room for a caption

-- A picture with blocks below it. The path begins at the page's folder.
local function thumbnail(path, alt, blocks, id)
  local width = pictures.size(path)
  local image = pandoc.Image({pandoc.Str(alt)}, path)
  return pandoc.Div({pandoc.Plain({image}), pandoc.Div(blocks, {class = "caption"})},
    {class = "thumbnail", id = id or "", style = "width: " .. math.max(width, narrowest) .. "px"})
end

-- A name that may go on in the next line behind each underscore.
local function breakable(name)
  local escaped = name:gsub("&", "&amp;"):gsub("<", "&lt;"):gsub("_", "_<wbr>")
  return pandoc.RawInline("html", "<code>" .. escaped .. "</code>")
end

local function sentence(text)
  local inlines = pandoc.utils.blocks_to_inlines(pandoc.read(text, "commonmark_x").blocks)
  return pandoc.Para(inlines):walk({Code = function(code) return breakable(code.text) end})
end

-- "assignments/06_bloom/points.tsv" and so on
local function file_of(stem, name)
  return drive.list(drive.source, "assignments/*_" .. stem .. "/" .. name)[1]
end

-- The rows of a table, each a list of cells.
local function read_rows(text)
  local rows = {}
  for line in text:gmatch("[^\n]+") do
    local cells = {}
    for cell in (line .. "\t"):gmatch("([^\t]*)\t") do cells[#cells + 1] = cell end
    rows[#rows + 1] = cells
  end
  return rows
end

local read_file = drive.read_file

-- --- mistakes --------------------------------------------------------------------------------

-- What tools/wrong.py prints of a feature.
local function mistakes(div, stem)
  div.attributes.driver = "wrong"
  local list = {}
  for _, cells in ipairs(read_rows(drive.run(div, stem))) do
    local name, sees, caption, mistake, test, wrong, right, options = table.unpack(cells)
    list[#list + 1] = {name = name, sees = sees, caption = caption, mistake = mistake, test = test,
      wrong = wrong:sub(#drive.out + 2), right = right:sub(#drive.out + 2), options = options, stem = stem}
  end
  return list
end

-- Where some features are woven alone, the claims and chapters of others are not on the page.
local is_alone = os.getenv("RAYKIT_ALONE") ~= ""

local function test_link(div, row, here)
  local name = breakable(row.test)
  if not here and is_alone then return name end
  return pandoc.Link({name}, "#test-" .. row.test, "", {["data-pos"] = div.attributes["data-pos"]})
end

-- Beside the wrong picture the right one, where the chapter does not show it.
local function with_right(block, row)
  local image = pandoc.Image({pandoc.Str("As it should be.")}, row.right)
  local function named(said, picture)
    local name = pandoc.Span({pandoc.Str(said)}, {class = "said"})
    return pandoc.Div({pandoc.Plain({picture, name})}, {class = "one"})
  end
  local width = 2 * math.max(pictures.size(row.right), narrowest) + 10
  block.content[1] = pandoc.Div({named("wrong", block.content[1].content[1]), named("right", image)},
    {class = "beside"})
  block.attributes.style = "width: " .. width .. "px"
  return block
end

local function wrong_picture(div, row, more, here)
  local seen = pandoc.Para({pandoc.Strong(sentence(row.caption).content)})
  local claim = pandoc.Para(pandoc.List(more):__concat({test_link(div, row, here)}))
  return thumbnail(row.wrong, row.caption, {seen, sentence(row.mistake), claim},
    here and "wrong-" .. row.stem .. "-" .. row.name)
end

-- The right picture, and then what is wrong with the same options.
local function of_feature(div, stem)
  local rows, blocks = mistakes(div, stem), pandoc.List()
  if #rows == 0 then fail_at(div, "assignments/*_%s/wrong.tsv lists no picture", stem) end
  local groups, order = {}, {}
  for _, row in ipairs(rows) do
    if not groups[row.options] then
      order[#order + 1] = row.options
      groups[row.options] = pandoc.List({thumbnail(row.right, "The right picture.",
        {pandoc.Para({pandoc.Strong("Right."), pandoc.Space(), pandoc.Code(row.options)})})})
    end
    groups[row.options]:insert(wrong_picture(div, row, {}, true))
  end
  for _, options in ipairs(order) do blocks:insert(pandoc.Div(groups[options], {class = "thumbnails"})) end
  return pandoc.Div(blocks)
end

-- The feature, linked to the picture in its chapter, or to the section of mistakes there.
local function chapter_link(div, row)
  local stem = row.stem
  local path = drive.list(drive.source, "docs/[0-9][0-9]_" .. stem .. ".md")[1]
  local text = path and read_file(path) or ""
  local anchor = text:match("\n## Common mistakes {#([%w_-]+)}")
  if not anchor then fail_at(div, "docs/*_%s.md has no section \"Common mistakes {#NAME}\"", stem) end
  local target = is_alone and "book:" .. anchor or "#wrong-" .. stem .. "-" .. row.name
  return pandoc.Link({breakable(stem)}, target, "", {["data-pos"] = div.attributes["data-pos"]})
end

local function of_all(div, sees, resolve)
  local found = pandoc.List()
  drive.each(drive.list(drive.source, "assignments/[0-9][0-9]_*/points.tsv"), function(path)
    local stem = path:match("/%d+_([^/]*)/points.tsv$")
    for _, row in ipairs(mistakes(div, stem)) do
      if row.sees == sees then
        local chapter = {resolve(chapter_link(div, row)), pandoc.Str(": ")}
        found:insert(with_right(wrong_picture(div, row, chapter, false), row))
      end
    end
  end)
  if #found == 0 then fail_at(div, "no wrong.tsv has a picture in which one sees %s", sees) end
  return pandoc.Div(found, {class = "thumbnails"})
end

-- `resolve` makes links of names.
function tools.wrong(resolve)
  return function(div)
    local stem, sees = div.attributes.stem, div.attributes.sees
    if (not stem) == (not sees) then fail_at(div, ".wrong needs stem=... or sees=...") end
    return stem and of_feature(div, stem) or of_all(div, sees, resolve)
  end
end

-- --- steps -----------------------------------------------------------------------------------

-- The steps of sections, by their names: none for a chapter without an assignment, or whose assignment a pack
-- does not hand out.
local function steps_of_sections(stem)
  local handout, steps = file_of(stem, "handout.md"), {}
  local table_of_steps = handout and read_file(handout) or ""
  for step, sections in table_of_steps:gmatch("\n| (%d+) | [^|]* | ([^|]*) |") do
    for section in sections:gmatch("[%w-]+") do
      steps[section] = steps[section] or {}
      table.insert(steps[section], step)
    end
  end
  return steps
end

local function named(steps)
  local last = #steps
  local said = last == 1 and "Step " .. steps[1] or
    "Steps " .. table.concat(steps, ", ", 1, last - 1) .. " and " .. steps[last]
  return pandoc.Div({pandoc.Plain({pandoc.Str(said .. " of the assignment")})}, {class = "of-step"})
end

-- Below the heading of a section stand the steps for which the handout names it.
function tools.mark_steps(doc)
  local blocks, known = pandoc.List(), {}
  for _, block in ipairs(doc.blocks) do
    blocks:insert(block)
    local stem = block.t == "Header" and drive.place(block):match("%d%d_([^/]*)%.md:%d+$")
    if stem then
      known[stem] = known[stem] or steps_of_sections(stem)
      local steps = known[stem][block.identifier]
      if steps then blocks:insert(named(steps)) end
    end
  end
  doc.blocks = blocks
  return doc
end

local side = 400 -- pixels, of a square picture of a step; others are as large

-- A look's options for a picture of that size.
local function sized(options)
  local size, scale = {width = 800, height = 800}
  for name in pairs(size) do
    options = options:gsub(" ?%-%-" .. name .. " (%d+)", function(number)
      size[name] = tonumber(number)
      return ""
    end)
  end
  scale = side / math.sqrt(size.width * size.height)
  return string.format("%s --width %.0f --height %.0f", options, scale * size.width, scale * size.height)
end

-- Draws a step's picture; returns its path.
local function drawn(div, stem, look)
  local folder = "figures/look_" .. stem .. "_" .. look[1]
  local line = drive.run(div, sized(look[2]), drive.out .. "/" .. folder)
  local name = line:match("/figures/([^/\n]*%.png): ")
  if not name then
    drive.fail_by_driver(div, "the driver printed no line with its picture's path: %s", line)
  end
  return folder .. "/figures/" .. name
end

-- The small one that students compare theirs with: in trials, and where the driver has a student's unit.
local function wanted(div, stem, looks, step)
  local path = "figures/look_" .. stem .. "_" .. step .. ".png"
  local from = looks:gsub("%.tsv$", "/" .. step .. ".png")
  local copy = io.open(drive.out .. "/" .. path, "wb")
  copy:write(read_file(from) or fail_at(div, "there is no %s; make look FEATURES=%s draws it", from, stem))
  copy:close()
  return path
end

-- The picture of each step, what was written, and the claims that hold since the picture before.
function tools.steps(div)
  local stem = drive.need(div, "stem")
  local looks, points = file_of(stem, "look.tsv"), file_of(stem, "points.tsv")
  local handout = file_of(stem, "handout.md")
  if not (looks and points) then fail_at(div, "there is no assignment %s", stem) end
  local written = {} -- nothing where a pack does not hand out the assignment
  for step, cell in (handout and read_file(handout) or ""):gmatch("\n| (%d+) | (.-) | ") do
    written[tonumber(step)] = cell
  end
  local blocks, before, rows = pandoc.List(), 0, read_rows(read_file(looks))
  local is_drawn = drive.units == "" and drive.runs ~= "1"
  div.attributes.driver = stem
  if is_drawn then drive.each({table.unpack(rows, 2)}, function(look) drawn(div, stem, look) end) end
  for at, look in ipairs(rows) do
    local step = tonumber(look[1])
    if at > 1 then
      local claims = pandoc.List()
      for _, test in ipairs(read_rows(read_file(points))) do
        local of = tonumber(test[3]:match("^%d+"))
        if of and of > before and of <= step then
          claims:insert({pandoc.Plain({test_link(div, {test = test[1]}, true)})})
        end
      end
      local path = is_drawn and drawn(div, stem, look) or wanted(div, stem, looks, step)
      local seen = look[3]:gsub("^%l", string.upper)
      local caption = pandoc.List({sentence("**Step " .. step .. ".** " .. seen .. ".")})
      if written[step] then caption:insert(sentence("Written: " .. written[step] .. ".")) end
      if #claims > 0 then
        local said = #claims == 1 and "One more claim holds" or #claims .. " more claims hold"
        caption:extend({pandoc.RawBlock("html", "<details><summary>" .. said .. "</summary>"),
          pandoc.BulletList(claims), pandoc.RawBlock("html", "</details>")})
      end
      blocks:insert(thumbnail(path, look[3], caption))
      written[step], before = nil, step
    end
  end
  local pictures_of = pandoc.Div(blocks, {class = "thumbnails"})
  local others = pandoc.List()
  for step, cell in pairs(written) do others:insert({step, cell}) end
  if #others == 0 then return pictures_of end
  table.sort(others, function(a, b) return a[1] < b[1] end)
  local said = others:map(function(of) return "step " .. of[1] .. ", " .. of[2] end)
  local text = "Without a picture of " .. (#others == 1 and "its" or "their") .. " own: " ..
    table.concat(said, "; ") .. "."
  return pandoc.Div({pictures_of, sentence(text)})
end

return tools
