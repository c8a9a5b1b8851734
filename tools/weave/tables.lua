-- Tables and single numbers from the CSV files that drivers write: .timings, .table, .measured.

local csv = require("csv")
local drive = require("drive")
local rounds = require("rounds")
local fail_at, need, words = drive.fail_at, drive.need, drive.words

local tables = {
  picture_size = {}, -- the drivers' own, as seen in their pictures
}

-- --- reading ---------------------------------------------------------------------------------

function tables.name(element)
  return element.attributes.keep or element.attributes.table or need(element, "driver")
end

-- The values that rows must have in some columns: where="method=grid threads=1"; _ stands for a space, too,
-- and a * at the end for anything.
local function conditions(element, where)
  local wanted = {}
  for _, word in ipairs(words(where)) do
    local column, value = word:match("^([%w_]+)=(.+)$")
    if not column then fail_at(element, "where: %s is not column=value", word) end
    wanted[column] = value
  end
  return wanted
end

local function matches(cell, value)
  local start = value:match("^(.*)%*$")
  return cell == value or cell:gsub(" ", "_") == value or start and cell:sub(1, #start) == start
end

-- A mesh's name as drivers have it, of at most 63 bytes.
local function mesh_name(path) return (path:gsub(".*/", ""):sub(1, 63)) end

local is_users = {} -- by the names of users' meshes
for _, mesh in ipairs(drive.meshes) do is_users[mesh_name(mesh)] = true end

local was_read = {} -- elements with their rows

local function text_of(row)
  local cells = {}
  for column, cell in pairs(row) do cells[#cells + 1] = column .. "=" .. cell end
  table.sort(cells)
  return table.concat(cells, ",")
end

-- What a page shows stands in its table: no later run may have replaced it.
function tables.check_kept()
  for _, read in ipairs(was_read) do
    local element, there = read.element, {}
    for _, row in ipairs((tables.read(element, element.attributes.where or ""))) do
      there[text_of(row)] = true
    end
    for _, row in ipairs(read.rows) do
      if not there[text_of(row)] then
        fail_at(element, "a later run has replaced rows of tables/%s.csv that are shown here; keep=NAME " ..
          "keeps this run's table under a name of its own", tables.name(element))
      end
    end
  end
end

-- The rows that an element selects by `where` (its attribute), cells by column, and the set of columns. Rows
-- of users' meshes are among them only if asked for: the texts say nothing of these.
function tables.read(element, where, with_meshes)
  local header, lines = csv.read(drive.out .. "/tables/" .. tables.name(element) .. ".csv")
  if not header then drive.fail_by_driver(element, "%s", lines) end
  local columns, rows, wanted = {}, {}, {}
  for _, column in ipairs(header) do columns[column] = true end
  for column, value in pairs(conditions(element, where or element.attributes.where)) do
    wanted[tables.column(element, columns, column)] = value
  end
  for _, line in ipairs(lines) do
    local row, fits = {}, true
    for i, cell in ipairs(line) do row[header[i]] = cell end
    for column, value in pairs(wanted) do fits = fits and matches(row[column], value) end
    if fits and (with_meshes or not is_users[row.scene]) then rows[#rows + 1] = row end
  end
  if not where then was_read[#was_read + 1] = {element = element, rows = rows} end
  return rows, columns
end

function tables.check_column(element, columns, column)
  if not columns[column] then
    fail_at(element, "tables/%s.csv has no column %s", tables.name(element), column)
  end
end

-- A column's name, in which _ may stand for a space.
function tables.column(element, columns, name)
  local spaced = name:gsub("_", " ")
  if columns[spaced] then return spaced end
  tables.check_column(element, columns, name)
  return name
end

-- The scenes that an element selects, in its order.
function tables.scenes(element, with_meshes)
  local list = words(need(element, "scenes"))
  for _, mesh in ipairs(with_meshes and drive.meshes or {}) do list[#list + 1] = mesh_name(mesh) end
  return list
end

-- The rows of these metrics on the element's scenes, in the order of the metrics; and the columns.
function tables.read_metrics(element, metrics, with_meshes)
  local where = element.attributes.where or ""
  local rows, columns = tables.read(element, where, with_meshes) -- timings: each run adds to them
  local list, wanted = {}, {}
  for _, scene in ipairs(tables.scenes(element, with_meshes)) do wanted[scene] = true end
  for _, metric in ipairs(metrics) do
    local before = #list
    for _, row in ipairs(rows) do
      if row.metric == metric and wanted[row.scene] then list[#list + 1] = row end
    end
    if #list == before then drive.fail_by_driver(element, "the driver measured no %s", metric) end
  end
  return list, columns
end

-- --- showing ---------------------------------------------------------------------------------

local labels = {samples = "samples per pixel", seconds = "time, s", rmse = "RMS error",
  max_error = "largest error"}

-- The name of a column or a metric in a heading or beside an axis.
function tables.label(name, unit)
  local label = labels[name] or name:gsub("_", " ")
  return unit and unit ~= "1" and label .. ", " .. unit or label
end

-- A cell in a readable form: names of methods as words.
function tables.cell(row, column)
  local text = row[column] or ""
  return column == "method" and text:gsub("_", " ") or text
end

-- A link to the element's table, a file beside the page.
function tables.link(element)
  local path = "tables/" .. tables.name(element) .. ".csv"
  return pandoc.Link(path, path)
end

local function minus(digits) return (digits:gsub("^-", "−")) end

-- Some significant digits (3), or all of a larger number with thousands separated; inlines.
local function show(text, significant)
  local value = tonumber(text)
  if not value then return pandoc.List({pandoc.Str((text:gsub(" ± ", "\u{a0}±\u{a0}")))}) end
  local places = (significant or 3) - 1
  local exponent = tonumber(string.format("%." .. places .. "e", value):match("e(.*)$")) or 0
  if value ~= 0 and exponent < -3 then
    local digits = string.format("%." .. places .. "f", value / 10 ^ exponent)
    return pandoc.List({pandoc.Str(minus(digits) .. "\u{a0}×\u{a0}10"),
      pandoc.Superscript({pandoc.Str("−" .. -exponent)})})
  end
  local decimals = value == math.floor(value) and 0 or math.max(0, places - exponent)
  local digits, again = string.format("%." .. decimals .. "f", value), 1
  while again > 0 do digits, again = digits:gsub("^(-?%d+)(%d%d%d)", "%1,%2") end
  return pandoc.List({pandoc.Str(minus(digits))})
end
tables.show = show

-- Columns of times, and of what depends on them, in tables that have no units.
local timed = {seconds = true, milliseconds = true, efficiency = true, primary = true, shadow = true,
  diffuse = true, primary_gain = true, shadow_gain = true, diffuse_gain = true}
local is_no_time = {["1"] = true, rays = true, bytes = true, MiB = true, ["%"] = true}

-- Whether a number depends on a time that was measured once, on a machine that may have been busy.
function tables.is_rough(element, row, column)
  if drive.runs == "1" then return false end -- a trial, which says so at its top
  if row.unit and row.median then return row.runs == "1" and not is_no_time[row.unit] end
  return drive.rough[tables.name(element)] and timed[column] or false
end

-- What a caption says of such numbers.
tables.rough_note = "≈: measured once, beside other programs; " ..
  "make " .. drive.page .. " MEASURED=1 measures carefully"

function tables.has_rough(element, rows, columns)
  for _, row in ipairs(rows) do
    for _, column in ipairs(columns) do
      if tables.is_rough(element, row, column) then return true end
    end
  end
  return false
end

-- Whether the runs of a timing differ too much for three digits.
local function is_unsteady(row)
  return row.is_rough or tonumber(row.max) - tonumber(row.min) > rounds.tolerated * tonumber(row.median)
end

-- A time that is known roughly: two digits, marked, with its range as a title.
local function show_roughly(row)
  local inlines = pandoc.List({pandoc.Str("≈\u{a0}")})
  inlines:extend(show(row.median, 2))
  local range = row.is_rough and "measured once" or "from " .. row.min .. " to " .. row.max
  return pandoc.List({pandoc.Span(inlines, {class = "rough", title = range})})
end

-- Few long rows become columns, so that the table fits the page; the first titles are those of the rows.
local function transposed(titles, rows)
  if #titles < 4 + 2 * #rows or #rows > 2 then return titles, rows end
  local head, body = {titles[1]}, {}
  for r, row in ipairs(rows) do head[r + 1] = row[1] end
  for i = 2, #titles do
    body[i - 1] = {titles[i]}
    for r, row in ipairs(rows) do body[i - 1][r + 1] = row[i] end
  end
  return head, body
end

-- A table with headings, rows of texts or timings, numbers aligned right, and a caption.
local function lay_out(div, titles, rows, small)
  titles, rows = transposed(titles, rows)
  local head, body, aligns, widths = {}, {}, {}, {}
  for i, title in ipairs(titles) do
    head[i], aligns[i], widths[i] = {pandoc.Plain({pandoc.Str(title)})}, pandoc.AlignRight, 0
  end
  for r, row in ipairs(rows) do
    body[r] = {}
    for i, cell in ipairs(row) do
      local text = type(cell) == "table" and cell.median or cell
      local is_rough = type(cell) == "table" and is_unsteady(cell)
      body[r][i] = {pandoc.Plain(is_rough and show_roughly(cell) or show(text))}
      if text ~= "" and not tonumber(text) then aligns[i] = pandoc.AlignLeft end
    end
  end
  local simple = pandoc.SimpleTable({}, aligns, widths, head, body)
  return pandoc.Div({
    pandoc.Div({pandoc.utils.from_simple_table(simple)}, {class = "wide"}),
    drive.caption(div.content, {pandoc.Str(small .. "all of it: "), tables.link(div)}),
  }, {class = "numbers"})
end

-- --- directives ------------------------------------------------------------------------------

-- Titles for metrics and methods, from labels="render_3_30: render, f = 3, A = 30; sah50_3: sah, all axes;
-- ...".
local function own_titles(div, metrics, rows)
  local titles, wanted = {}, {}
  for _, metric in ipairs(metrics) do wanted[metric] = true end
  for _, row in ipairs(rows) do wanted[row.method or ""] = true end
  for part in (div.attributes.labels or ""):gmatch("[^;]+") do
    local name, title = part:match("^%s*([^:%s]+)%s*:%s*(.-)%s*$")
    if not wanted[name] then
      fail_at(div, "labels: %s is neither a metric nor a method of the table", name or part)
    end
    titles[name] = title
  end
  return titles
end

-- Groups rows by the columns that distinguish them. Returns the groups, each with rows by metric,
-- and each metric's name.
local function group(div, rows, apart, own)
  local groups, by_key, titles = {}, {}, {}
  for _, row in ipairs(rows) do
    local key = {}
    for i, column in ipairs(apart) do
      key[i] = column == "method" and own[row.method] or tables.cell(row, column)
    end
    local name = row.scene .. "\0" .. table.concat(key, "\0")
    local found = by_key[name]
    if not found then
      found = {scene = row.scene, triangles = row.triangles, cells = key, timings = {}}
      by_key[name] = found
      groups[#groups + 1] = found
    end
    if found.timings[row.metric] then
      fail_at(div, "%s of %s is measured twice; distinguish the rows by rows=... or where=...",
        row.metric, table.concat(key, ", "))
    end
    found.timings[row.metric] = row
    titles[row.metric] = tables.label(own[row.metric] or row.metric, row.unit)
  end
  return groups, titles
end

-- The scene plays no part: a row for each metric.
local function without_scene(metrics, found, titles)
  local body = {}
  for i, metric in ipairs(metrics) do body[i] = {titles[metric], found.timings[metric] or ""} end
  return {"measured", "result"}, body
end

function tables.timings(div)
  local scenes, metrics = tables.scenes(div, true), words(need(div, "metrics"))
  drive.measure(div, drive.timing, true)
  local rows, columns = tables.read_metrics(div, metrics, true)
  for _, row in ipairs(rows) do row.is_rough = tables.is_rough(div, row, "median") end
  local sceneless = div.attributes.rows == "none"
  local apart, head, body, by_scene = sceneless and {} or words(div.attributes.rows or "scene"), {}, {}, false
  for i, column in ipairs(apart) do
    tables.check_column(div, columns, column)
    head[i] = tables.label(column)
    by_scene = by_scene or column == "scene"
  end
  local groups, titles = group(div, rows, apart, own_titles(div, metrics, rows))
  if by_scene then head[#head + 1] = "triangles" end
  for _, metric in ipairs(metrics) do head[#head + 1] = titles[metric] end
  for _, scene in ipairs(scenes) do
    local before = #body
    for _, found in ipairs(groups) do
      if found.scene == scene then
        local line = {table.unpack(found.cells)}
        if by_scene then line[#line + 1] = found.triangles end
        for _, metric in ipairs(metrics) do line[#line + 1] = found.timings[metric] or "" end
        body[#body + 1] = line
      end
    end
    if #body == before then drive.fail_by_driver(div, "%s has no row in the table", scene) end
  end
  local pixels = not sceneless and tables.picture_size[div.attributes.driver]
  if sceneless then head, body = without_scene(metrics, groups[1], titles) end
  local how = drive.runs == "1" and "single runs" or
    tables.has_rough(div, rows, {"median"}) and tables.rough_note or
    "medians of " .. drive.runs .. " rounds by turns, or more; ≈: rounds differ by more than a fifth"
  return lay_out(div, head, body, how .. (pixels and ", " .. pixels .. " pixels; " or "; "))
end

function tables.table(div)
  if div.attributes.driver then drive.measure(div, "--quiet") end
  local rows, columns = tables.read(div)
  local head, names, body, seen = {}, {}, {}, {}
  for part in need(div, "columns"):gmatch("[^,]+") do
    local name, title = part:match("^%s*([%w_]+)%s*:%s*(.-)%s*$")
    name = name or part:match("^%s*(.-)%s*$")
    tables.check_column(div, columns, name)
    if seen[name] then fail_at(div, "columns=...: %s stands there twice; a column is shown once", name) end
    seen[name] = true
    names[#names + 1], head[#head + 1] = name, title or tables.label(name)
  end
  for r, row in ipairs(rows) do
    body[r] = {}
    for i, name in ipairs(names) do
      local cell = tables.cell(row, name)
      local is_rough = tables.is_rough(div, row, name) and tonumber(cell)
      body[r][i] = is_rough and {median = cell, is_rough = true} or cell
    end
  end
  if #body == 0 then drive.fail_by_driver(div, "tables/%s.csv has no such row", tables.name(div)) end
  local rough = tables.has_rough(div, rows, names) and tables.rough_note .. "; " or ""
  return lay_out(div, head, body, drive.reservation(div) .. rough)
end

-- A number in a sentence, marked where it is rough.
function tables.roughly(is_rough, inlines)
  if not is_rough then return inlines end
  inlines = pandoc.List({pandoc.Str("≈\u{a0}")}) .. inlines
  return pandoc.List({pandoc.Span(inlines, {class = "rough", title = "measured once"})})
end

-- The cell of the only row that is selected.
local function one_cell(span)
  drive.measure(span, "--quiet")
  local rows, columns = tables.read(span)
  tables.check_column(span, columns, span.attributes.column)
  if #rows ~= 1 then drive.fail_by_driver(span, "where=...: %d rows are selected in place of one", #rows) end
  local row, column = rows[1], span.attributes.column
  return tables.roughly(tables.is_rough(span, row, column), show(row[column]))
end

local function measure_one(span)
  local scene, metric = need(span, "scene"), need(span, "metric")
  span.attributes.scenes = scene
  drive.measure(span, drive.timing)
  for _, row in ipairs((tables.read(span, span.attributes.where or ""))) do
    if row.scene == scene and row.metric == metric then
      return {row.median, tables.is_rough(span, row, "median")}
    end
  end
  drive.fail_by_driver(span, "the driver measured no %s of %s", metric, scene)
end

-- Set by values.lua: takes a span, its name and its number.
tables.on_name = nil

-- One number from the driver's table. It has a place in the record of its own, because a later run with other
-- options may replace its row.
function tables.measured(span)
  if span.attributes.column then return one_cell(span) end
  local a, parts = span.attributes, {}
  for i, key in ipairs({"driver", "scene", "metric", "args", "variants", "where"}) do
    parts[i] = a[key] or ""
  end
  local found = drive.once("measured " .. table.concat(parts, " "), function() return measure_one(span) end)
  local median, is_rough = table.unpack(found)
  if a.name then tables.on_name(span, a.name, tonumber(median), is_rough) end
  return tables.roughly(is_rough, show(median))
end

return tables
