-- Figures that go step by step: what a unit's variables held after each line that it ran.
--
--   ::: {.replay unit=bvh_median figure=selection}
--   The caption.
--   :::
-- becomes a player of the states that gdb has noted (tools/live/steps/trace.py), beside the functions' code,
-- and where no scripts run a table of some of them. Without gdb, and in packs, the build has none, and the
-- caption alone stays.

local code = require("code")
local csv = require("csv")
local drive = require("drive")

local replay = {}

local folder = os.getenv("RAYKIT_STEPS") or "" -- empty: there are none
local views = {} -- texts of their files, by figure

local function quote(text)
  return '"' .. text:gsub('[\\"]', "\\%0"):gsub("\n", "\\n"):gsub("</", "<\\/") .. '"'
end

-- The functions of a figure's steps, in their order in the file, as JSON; a step's line must be among theirs.
local function listing(div, steps, path, solutions)
  local functions, seen = {}, {}
  for name, line in steps:gmatch('%["([%w_]+)",(%d+),') do
    if not seen[name] then
      local found, wrong = code.find(drive.source .. "/" .. path, path, name, true)
      if not found then drive.fail_at(div, "%s", wrong) end
      seen[name] = {found = found, lines = {}}
      for _, number in ipairs(found.numbers) do seen[name].lines[number] = true end
      functions[#functions + 1] = name
    end
    if not seen[name].lines[tonumber(line)] then
      drive.fail_at(div, "gdb has seen line %s of %s, which %s does not have", line, name, path)
    end
  end
  if not solutions then return "[]" end
  table.sort(functions, function(a, b) return seen[a].found.line < seen[b].found.line end)
  for i, name in ipairs(functions) do
    local found = seen[name].found
    functions[i] = string.format('{"name":%s,"numbers":[%s],"text":%s}', quote(name),
      table.concat(found.numbers, ","), quote(found.text))
  end
  return "[" .. table.concat(functions, ",") .. "]"
end

local function cell(text) return {pandoc.Plain({pandoc.Str(text)})} end

local function table_of(path)
  local header, rows = csv.read(path)
  if not header then drive.fail("%s", rows) end
  local cells, alignments, widths = {}, {}, {}
  for i, row in ipairs(rows) do
    cells[i] = {}
    for j, text in ipairs(row) do cells[i][j] = cell(text) end
  end
  for j, name in ipairs(header) do
    header[j], alignments[j], widths[j] = {pandoc.Plain({pandoc.Code(name)})}, "AlignLeft", 0
  end
  return pandoc.utils.from_simple_table(pandoc.SimpleTable({}, alignments, widths, header, cells))
end

-- solutions: whether it may show these.
function replay.figure(solutions)
  return function(div)
    local unit, figure = drive.need(div, "unit"), drive.need(div, "figure")
    local traces = folder ~= "" and drive.read_file(folder .. "/" .. unit .. ".json")
    if not traces then
      local reason = "This book cannot play the steps: it was made without gdb, which notes them."
      return pandoc.Div({drive.caption(div.content, reason)}, {class = "picture missing"})
    end
    local trace = traces:match('\n"' .. figure .. '":([^\n]-),?\n')
    if not trace then drive.fail_at(div, "tools/live/steps/trace.py has no figure %s of %s", figure, unit) end
    views[figure] = views[figure] or drive.read_file(drive.source .. "/tools/live/steps/" .. figure .. ".js")
    if not views[figure] then drive.fail_at(div, "tools/live/steps has no view %s.js", figure) end
    local file = trace:match('"file":"([^"]+)"')
    local data = string.format('<script type="application/json">{"trace":%s,"code":%s}</script>', trace,
      listing(div, trace, file, solutions()))
    return pandoc.Div({
      pandoc.Div({pandoc.RawBlock("html", data), table_of(folder .. "/" .. unit .. "." .. figure .. ".csv")},
        {class = "replay", ["data-figure"] = figure, ["data-unit"] = unit, ["data-file"] = file}),
      drive.caption(div.content),
    }, {class = "picture"})
  end
end

-- The script of pages with such figures; empty if no page has any.
function replay.script()
  local names, texts = {}, {}
  for name in pairs(views) do names[#names + 1] = name end
  if #names == 0 then return "" end
  table.sort(names)
  for i, name in ipairs(names) do texts[i] = name .. ": " .. views[name] end
  local function read(name) return drive.read_file(drive.source .. "/tools/live/" .. name) end
  return "{\n" .. read("make.js") .. "const Plot = (" .. read("widgets/plot.js") .. ")(make);\n(" ..
    read("widgets/steps.js") .. ")({make, Plot}, {\n" .. table.concat(texts, ",\n") .. "});\n}\n"
end

return replay
