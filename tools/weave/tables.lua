-- Tables and single numbers from the CSV files that drivers write: .timings, .table, .measured.

local drive = require("drive")
local fail_at, need, words = drive.fail_at, drive.need, drive.words

local tables = {
  picture_size = {}, -- the drivers' own, as seen in their pictures
}

-- --- reading ---------------------------------------------------------------------------------

-- The cells of a CSV line without line breaks in cells (the drivers write none).
local function cells(line)
  local list, at = {}, 1
  while at <= #line + 1 do
    local cell
    if line:sub(at, at) == '"' then
      local stop = at + 1
      while line:sub(stop, stop) ~= '"' or line:sub(stop + 1, stop + 1) == '"' do
        stop = stop + (line:sub(stop, stop) == '"' and 2 or 1)
        if stop > #line then drive.fail("an unclosed quote in a table: %s", line) end
      end
      cell, at = line:sub(at + 1, stop - 1):gsub('""', '"'), stop + 2
    else
      local stop = line:find(",", at, true) or #line + 1
      cell, at = line:sub(at, stop - 1), stop + 1
    end
    list[#list + 1] = cell
  end
  return list
end

function tables.name(element) return element.attributes.table or need(element, "driver") end

-- The values that rows must have in some columns: where="method=grid threads=1".
local function conditions(element)
  local wanted = {}
  for _, word in ipairs(words(element.attributes.where)) do
    local column, value = word:match("^([%w_]+)=(.+)$")
    if not column then fail_at(element, "where: %s is not column=value", word) end
    wanted[column] = value
  end
  return wanted
end

-- The rows that an element selects, cells by column, and the set of columns.
function tables.read(element)
  local path = "tables/" .. tables.name(element) .. ".csv"
  local file = io.open(drive.out .. "/" .. path)
  if not file then drive.fail_by_driver(element, "%s is missing: no driver wrote it", path) end
  local header, columns, rows = cells(file:read("l") or ""), {}, {}
  for _, column in ipairs(header) do columns[column] = true end
  local wanted = conditions(element)
  for column in pairs(wanted) do tables.check_column(element, columns, column) end
  for line in file:lines() do
    local row, fits = {}, true
    for i, cell in ipairs(cells(line)) do row[header[i]] = cell end
    for column, value in pairs(wanted) do fits = fits and row[column] == value end
    if fits then rows[#rows + 1] = row end
  end
  file:close()
  return rows, columns
end

function tables.check_column(element, columns, column)
  if not columns[column] then
    fail_at(element, "tables/%s.csv has no column %s", tables.name(element), column)
  end
end

local function basename(path) return (path:gsub(".*/", "")) end

-- The scenes that an element selects, in its order.
function tables.scenes(element, with_meshes)
  local list = words(need(element, "scenes"))
  for _, mesh in ipairs(with_meshes and drive.meshes or {}) do list[#list + 1] = basename(mesh) end
  return list
end

-- The rows of these metrics on the element's scenes, in the order of the metrics; and the columns.
function tables.read_metrics(element, metrics, with_meshes)
  local rows, columns = tables.read(element)
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

local function minus(digits) return (digits:gsub("^-", "−")) end

-- Three significant digits, or all of a larger number with thousands separated; inlines.
local function show(text)
  local value = tonumber(text)
  if not value then return pandoc.List({pandoc.Str(text)}) end
  local exponent = tonumber(string.format("%.2e", value):match("e(.*)$")) or 0
  if value ~= 0 and exponent < -3 then
    local digits = string.format("%.2f", value / 10 ^ exponent)
    return pandoc.List({pandoc.Str(minus(digits) .. "\u{a0}×\u{a0}10"),
      pandoc.Superscript({pandoc.Str("−" .. -exponent)})})
  end
  local decimals = value == math.floor(value) and 0 or math.max(0, 2 - exponent)
  local digits, again = string.format("%." .. decimals .. "f", value), 1
  while again > 0 do digits, again = digits:gsub("^(-?%d+)(%d%d%d)", "%1,%2") end
  return pandoc.List({pandoc.Str(minus(digits))})
end

-- A table with headings, rows of texts, numbers aligned right, and a caption.
local function lay_out(div, titles, rows, small)
  local head, body, aligns, widths = {}, {}, {}, {}
  for i, title in ipairs(titles) do
    head[i], aligns[i], widths[i] = {pandoc.Plain({pandoc.Str(title)})}, pandoc.AlignRight, 0
  end
  for r, row in ipairs(rows) do
    body[r] = {}
    for i, text in ipairs(row) do
      body[r][i] = {pandoc.Plain(show(text))}
      if text ~= "" and not tonumber(text) then aligns[i] = pandoc.AlignLeft end
    end
  end
  local simple = pandoc.SimpleTable({}, aligns, widths, head, body)
  return pandoc.Div({
    pandoc.Div({pandoc.utils.from_simple_table(simple)}, {class = "wide"}),
    drive.caption(div.content, small .. "all of it: tables/" .. tables.name(div) .. ".csv"),
  }, {class = "numbers"})
end

-- --- directives ------------------------------------------------------------------------------

-- Groups rows by the columns that distinguish them. Returns the groups, each with medians by metric,
-- and each metric's name.
local function group(div, rows, apart)
  local groups, by_key, titles = {}, {}, {}
  for _, row in ipairs(rows) do
    local key = {}
    for i, column in ipairs(apart) do key[i] = tables.cell(row, column) end
    local name = row.scene .. "\0" .. table.concat(key, "\0")
    local found = by_key[name]
    if not found then
      found = {scene = row.scene, triangles = row.triangles, cells = key, medians = {}}
      by_key[name] = found
      groups[#groups + 1] = found
    end
    if found.medians[row.metric] then
      fail_at(div, "%s of %s is measured twice; distinguish the rows by rows=... or where=...",
        row.metric, table.concat(key, ", "))
    end
    found.medians[row.metric] = row.median
    titles[row.metric] = tables.label(row.metric, row.unit)
  end
  return groups, titles
end

function tables.timings(div)
  local scenes, metrics = tables.scenes(div, true), words(need(div, "metrics"))
  drive.measure(div, drive.timing, true)
  local rows, columns = tables.read_metrics(div, metrics, true)
  local apart, head, body = words(div.attributes.rows or "scene"), {}, {}
  for i, column in ipairs(apart) do
    tables.check_column(div, columns, column)
    head[i] = tables.label(column)
  end
  local groups, titles = group(div, rows, apart)
  head[#head + 1] = "triangles"
  for _, metric in ipairs(metrics) do head[#head + 1] = titles[metric] end
  for _, scene in ipairs(scenes) do
    local before = #body
    for _, found in ipairs(groups) do
      if found.scene == scene then
        local line = {table.unpack(found.cells)}
        line[#line + 1] = found.triangles
        for _, metric in ipairs(metrics) do line[#line + 1] = found.medians[metric] or "" end
        body[#body + 1] = line
      end
    end
    if #body == before then drive.fail_by_driver(div, "%s has no row in the table", scene) end
  end
  local pixels = tables.picture_size[div.attributes.driver]
  return lay_out(div, head, body, "medians of " .. drive.runs .. (drive.runs == "1" and " run" or " runs") ..
    (pixels and ", " .. pixels .. " pixels; " or "; "))
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
    for i, name in ipairs(names) do body[r][i] = tables.cell(row, name) end
  end
  if #body == 0 then drive.fail_by_driver(div, "tables/%s.csv has no such row", tables.name(div)) end
  return lay_out(div, head, body, "")
end

-- The cell of the only row that is selected.
local function one_cell(span)
  drive.measure(span, "--quiet")
  local rows, columns = tables.read(span)
  tables.check_column(span, columns, span.attributes.column)
  if #rows ~= 1 then drive.fail_by_driver(span, "where=...: %d rows are selected in place of one", #rows) end
  return show(rows[1][span.attributes.column])
end

-- One number from the driver's table.
function tables.measured(span)
  if span.attributes.column then return one_cell(span) end
  local scene, metric = need(span, "scene"), need(span, "metric")
  span.attributes.scenes = scene
  drive.measure(span, drive.timing)
  for _, row in ipairs((tables.read(span))) do
    if row.scene == scene and row.metric == metric then return show(row.median) end
  end
  drive.fail_by_driver(span, "the driver measured no %s of %s", metric, scene)
end

return tables
