-- Plots by gnuplot from the CSV files that drivers write: .plot. Axes are logarithmic, but for bars.

local drive = require("drive")
local tables = require("tables")
local fail_at, need, words = drive.fail_at, drive.need, drive.words

local gnuplot = os.getenv("RAYKIT_GNUPLOT") or ""

-- Colours that people with any colour vision can distinguish (M. Okabe and K. Ito, 2008), and points
-- of different shapes for print.
local styles = {{"#0072b2", 7}, {"#d55e00", 5}, {"#009e73", 9}, {"#cc79a7", 13}, {"#56b4e9", 11},
  {"#e69f00", 6}, {"#000000", 4}, {"#777777", 8}}

local function quote(text) return "'" .. text:gsub("'", "''") .. "'" end

-- The number in a row's column, or nil if it has no logarithm.
local function coordinate(div, row, column)
  local value = tonumber(row[column])
  if not value then drive.fail_by_driver(div, "%s is not a number: %s", column, row[column] or "") end
  return value > 0 and value or nil
end

-- Groups the rows into lines, one per value of the column `by`, in the order of the rows. Also returns
-- the number of rows that cannot be plotted. With `band`, points have the values of its columns, too.
local function lines_of(div, rows, x, y, by, band)
  local lines, by_title, left_out = {}, {}, 0
  for _, row in ipairs(rows) do
    local title = by == "metric" and tables.label(row.metric) or by and tables.cell(row, by) or
      tables.label(y)
    local line = by_title[title]
    if not line then
      line = {title = title, points = {}}
      by_title[title] = line
      lines[#lines + 1] = line
    end
    local point = {coordinate(div, row, x), coordinate(div, row, y)}
    if band then point.low, point.high = coordinate(div, row, band .. "_low"), coordinate(div, row, band .. "_high") end
    if point[1] and point[2] then line.points[#line.points + 1] = point else left_out = left_out + 1 end
  end
  for n = #lines, 1, -1 do
    local line = lines[n]
    if #line.points == 0 then table.remove(lines, n) end
    table.sort(line.points, function(a, b) return a[1] < b[1] end)
    for i = 2, #line.points do -- measured times may be equal by chance
      if x ~= "seconds" and line.points[i][1] == line.points[i - 1][1] then
        fail_at(div, "%s has several values at one %s; distinguish the rows by by=... or where=...",
          line.title, x)
      end
    end
  end
  if #lines == 0 then drive.fail_by_driver(div, "tables/%s.csv has nothing to plot", tables.name(div)) end
  if #lines > #styles then fail_at(div, "%d lines are too many to distinguish", #lines) end
  return lines, left_out
end

-- Powers of ten if the numbers span two of them or more, else the numbers themselves.
local function tics(lines, axis, i)
  local least, most = math.huge, 0
  for _, line in ipairs(lines) do
    for _, point in ipairs(line.points) do
      least, most = math.min(least, point[i]), math.max(most, point[i])
    end
  end
  return "set format " .. axis .. (most / least >= 100 and " '10^{%L}'" or " '%g'")
end

-- The legend is placed where falling or rising lines leave room; for many lines, beside the plot.
local many = 5

local function legend(lines, steep)
  local points = lines[1].points
  if #lines > many then return "outside right top" end
  if steep then return "bottom left Left reverse" end
  return #points > 1 and points[#points][2] < points[1][2] and "top right" or "top left Left reverse"
end

-- Where guides begin and end: at the smallest x and the largest y of all points; rising ones at the smallest y.
local function corner(lines)
  local left, right, top, bottom = math.huge, 0, 0, math.huge
  for _, line in ipairs(lines) do
    for _, point in ipairs(line.points) do
      left, right = math.min(left, point[1]), math.max(right, point[1])
      top, bottom = math.max(top, point[2]), math.min(bottom, point[2])
    end
  end
  return left, right, top, bottom
end

-- Grey lines of these slopes, as parts of a plot, with the slopes at their ends.
local function guides(div, script, lines)
  local parts, left, right, top, bottom = {}, corner(lines)
  for i, word in ipairs(words(div.attributes.guides)) do
    local slope = tonumber(word) or fail_at(div, "guides: %s is not a slope", word)
    local start = slope > 0 and bottom or top
    parts[i] = string.format("[x=%.9g:%.9g] %.9g * (x / %.9g) ** (%.9g) with lines lc rgb '#999999' dt %d lw 1.5 notitle",
      left, right, start, left, slope, i + 1)
    script[#script + 1] = string.format("set label %s at %.9g, %.9g left offset 0.5, 0 tc rgb '#777777' font ',12'",
      quote(word:gsub("^-", "−")), right, start * (right / left) ^ slope)
  end
  return parts
end

-- A line's band, as a part of a plot; points without a lower limit above 0 have none.
local function band_of(script, line, i)
  local points = {}
  for _, point in ipairs(line.points) do
    if point.low and point.high then
      points[#points + 1] = string.format("%.9g %.9g %.9g", point[1], point.low, point.high)
    end
  end
  if #points < 2 then return nil end
  script[#script + 1] = "$band" .. i .. " << EOD\n" .. table.concat(points, "\n") .. "\nEOD"
  return string.format("$band%d using 1:2:3 with filledcurves lc rgb '%s' fs transparent solid 0.25 notitle", i, styles[i][1])
end

local drawn = {} -- pictures

local function draw(div, name, xlabel, ylabel, lines, left_out)
  drawn[name] = (drawn[name] or 0) + 1
  local path = "figures/" .. name .. (drawn[name] > 1 and "_" .. drawn[name] or "") .. ".svg"
  local script = {
    "set terminal svg size " .. (#lines > many and 820 or 600) .. ",380 font 'Helvetica,15' background 'white'",
    "set output " .. quote(drive.out .. "/" .. path),
    "set logscale xy", tics(lines, "x", 1), tics(lines, "y", 2), "set grid",
    "set key " .. legend(lines, div.attributes.band),
    "set xlabel " .. quote(xlabel), "set ylabel " .. quote(ylabel),
  }
  local parts = guides(div, script, lines)
  for i, line in ipairs(lines) do
    script[#script + 1] = string.format("set style line %d lc rgb '%s' pt %d lw 2", i, table.unpack(styles[i]))
    script[#script + 1] = "$data" .. i .. " << EOD"
    for _, point in ipairs(line.points) do
      script[#script + 1] = string.format("%.9g %.9g", point[1], point[2])
    end
    script[#script + 1] = "EOD"
    parts[#parts + 1] = band_of(script, line, i)
    parts[#parts + 1] = string.format("$data%d using 1:2 with linespoints linestyle %d title %s noenhanced", i, i,
      quote(line.title))
  end
  script[#script + 1] = (div.attributes.guides and "plot sample " or "plot ") .. table.concat(parts, ", ") .. "\n"
  local pipe = io.popen(drive.quote(gnuplot), "w")
  pipe:write(table.concat(script, "\n"))
  if not pipe:close() then fail_at(div, "gnuplot failed (its reason is above)") end
  local note = left_out > 0 and "left out: values of 0 or less, which have no logarithm (" .. left_out .. ")"
  return pandoc.Div({
    pandoc.Plain({pandoc.Image(pandoc.utils.stringify(div.content), path)}), drive.caption(div.content, note),
  }, {class = "picture plot"})
end

-- --- bars ------------------------------------------------------------------------------------

-- The values of a column in the order of the rows, each once.
local function distinct(rows, column)
  local list, seen = {}, {}
  for _, row in ipairs(rows) do
    local cell = tables.cell(row, column)
    if not seen[cell] then seen[cell], list[#list + 1] = true, cell end
  end
  return list
end

-- Each row's y, by the text of its x and then of its `by`.
local function heights(div, rows, x, y, by)
  local all = {}
  for _, row in ipairs(rows) do
    local at, group = tables.cell(row, x), tables.cell(row, by)
    if not tonumber(row[y]) then drive.fail_by_driver(div, "%s is not a number: %s", y, row[y] or "") end
    all[at] = all[at] or {}
    if all[at][group] then
      fail_at(div, "%s has several values at %s; distinguish the rows by where=...", group, at)
    end
    all[at][group] = row[y]
  end
  return all
end

local function draw_bars(div, name, xlabel, ylabel, rows, x, y, by)
  local places, groups, height = distinct(rows, x), distinct(rows, by), heights(div, rows, x, y, by)
  local path, parts = "figures/" .. name .. ".svg", {}
  local script = {
    "set terminal svg size " .. (#places > many and 820 or 600) .. ",320 font 'Helvetica,15' background 'white'",
    "set output " .. quote(drive.out .. "/" .. path),
    "set style data histogram", "set style histogram clustered gap 1", "set style fill solid", "set boxwidth 0.9",
    "set yrange [0:*]", "set grid y", #groups > 1 and "set key top left Left reverse noenhanced" or "unset key",
    "set xlabel " .. quote(xlabel), "set ylabel " .. quote(ylabel), "$data << EOD",
  }
  for _, at in ipairs(places) do
    local line = {'"' .. at .. '"'}
    for _, group in ipairs(groups) do line[#line + 1] = height[at][group] or "NaN" end
    script[#script + 1] = table.concat(line, " ")
  end
  script[#script + 1] = "EOD"
  for i, group in ipairs(groups) do
    parts[i] = string.format("$data using %d:xtic(1) lc rgb '%s' title %s noenhanced", i + 1, styles[i][1], quote(group))
  end
  script[#script + 1] = "plot " .. table.concat(parts, ", ") .. "\n"
  local pipe = io.popen(drive.quote(gnuplot), "w")
  pipe:write(table.concat(script, "\n"))
  if not pipe:close() then fail_at(div, "gnuplot failed (its reason is above)") end
  return pandoc.Div({
    pandoc.Plain({pandoc.Image(pandoc.utils.stringify(div.content), path)}), drive.caption(div.content),
  }, {class = "picture plot"})
end

local function unit_of(div, rows)
  local unit = rows[1].unit
  for _, row in ipairs(rows) do
    if row.unit ~= unit then fail_at(div, "one axis cannot be in %s and %s", unit, row.unit) end
  end
  return unit
end

return function(div)
  if gnuplot == "" then
    drive.say("a plot is left out: it needs gnuplot")
    return pandoc.Para({pandoc.Emph("A plot is left out here: this build found no gnuplot.")})
  end
  local given, metrics = div.attributes, words(div.attributes.metrics)
  if #metrics > 0 then
    drive.measure(div, drive.timing)
    local rows, columns = tables.read_metrics(div, metrics)
    local x = given.x or "triangles"
    for _, column in ipairs({x, given.by}) do tables.check_column(div, columns, column) end
    local ylabel = (given.ylabel or "time") .. ", " .. unit_of(div, rows)
    return draw(div, tables.name(div) .. "_" .. metrics[1], given.xlabel or tables.label(x), ylabel,
      lines_of(div, rows, x, "median", given.by or "metric"))
  end
  local x, y = need(div, "x"), need(div, "y")
  if given.driver then drive.measure(div, "--quiet") end
  local rows, columns = tables.read(div)
  for _, column in ipairs({x, y, given.by}) do tables.check_column(div, columns, column) end
  if given.bars then
    return draw_bars(div, given.name or tables.name(div) .. "_bars", given.xlabel or tables.label(x),
      given.ylabel or tables.label(y), rows, x, y, need(div, "by"))
  end
  local band = given.band and y
  for _, side in ipairs(band and {"_low", "_high"} or {}) do tables.check_column(div, columns, band .. side) end
  return draw(div, given.name or tables.name(div) .. "_" .. y .. "_over_" .. x, given.xlabel or tables.label(x),
    given.ylabel or tables.label(y), lines_of(div, rows, x, y, given.by, band))
end
