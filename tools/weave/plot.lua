-- Plots by gnuplot from the CSV files that drivers write: .plot. Axes are logarithmic, but for bars and with
-- linear=yes.

local drive = require("drive")
local fit = require("fit")
local style_of = require("methods")
local tables = require("tables")
local fail_at, need, words = drive.fail_at, drive.need, drive.words

local gnuplot = os.getenv("RAYKIT_GNUPLOT") or ""

local function quote(text) return "'" .. text:gsub("'", "''") .. "'" end

-- The number in a row's column, or nil if it has no logarithm.
local function coordinate(div, row, column)
  local value = tonumber(row[column])
  if not value then drive.fail_by_driver(div, "%s is not a number: %s", column, row[column] or "") end
  return value > 0 and value or nil
end

-- Groups the rows into lines, one per value of the column `by`, in the order of the rows. Also returns
-- the number of rows that cannot be plotted, and of points at which a curve runs back: more samples took less
-- time. With `band`, points have the values of its columns, too.
local function lines_of(div, rows, x, y, by, band)
  local lines, by_title, left_out, back = {}, {}, 0, 0
  for _, row in ipairs(rows) do
    local title = by == "metric" and tables.label(row.metric) or by and tables.cell(row, by) or
      tables.label(y)
    local line = by_title[title]
    if not line then
      line = {title = title, points = {}}
      by_title[title] = line
      lines[#lines + 1] = line
    end
    local point = {coordinate(div, row, x), coordinate(div, row, y), samples = tonumber(row.samples),
      order = tonumber(x == "seconds" and row.samples or row[x])}
    if band then
      point.low, point.high = coordinate(div, row, band .. "_low"), coordinate(div, row, band .. "_high")
    end
    if point[1] and point[2] then line.points[#line.points + 1] = point else left_out = left_out + 1 end
  end
  for n = #lines, 1, -1 do
    local line = lines[n]
    if #line.points == 0 then table.remove(lines, n) end
    table.sort(line.points, function(a, b) return a.order < b.order end)
    for i = 2, #line.points do
      if line.points[i].order == line.points[i - 1].order then
        fail_at(div, "%s has several values at one %s; distinguish the rows by by=... or where=...",
          line.title, x == "seconds" and "number of samples" or x)
      end
      back = back + (line.points[i][1] < line.points[i - 1][1] and 1 or 0)
    end
  end
  if #lines == 0 then drive.fail_by_driver(div, "tables/%s.csv has nothing to plot", tables.name(div)) end
  return lines, left_out, back
end

-- The rows of some lines alone, from only="sobol, polar; sobol, concentric", and what the caption says of it.
-- from=4 leaves out what has fewer samples.
local function some_of(div, rows, by)
  local wanted, chosen, all, here = {}, {}, 0, 0
  for title in (div.attributes.only or ""):gmatch("[^;]+") do wanted[title:match("^%s*(.-)%s*$")] = 0 end
  if not next(wanted) then return rows end
  local seen = {}
  for _, row in ipairs(rows) do
    local title = tables.cell(row, by)
    if not seen[title] then seen[title], all, here = true, all + 1, here + (wanted[title] and 1 or 0) end
    local is_within = tonumber(row.samples or 1) >= tonumber(div.attributes.from or 0)
    if wanted[title] and is_within then wanted[title], chosen[#chosen + 1] = 1, row end
  end
  for title, found in pairs(wanted) do
    if found == 0 then fail_at(div, "only: the table has no %s %s", by, title) end
  end
  return chosen, here < all and here .. " of " .. all .. " methods" or nil
end

-- A method's colour and marker, and whether it is dashed.
local function need_style(div, name, place)
  local colour, marker, is_dashed = style_of(name, place)
  if not colour then
    fail_at(div, "%s has no colour and marker: give it some in tools/weave/methods.lua", name)
  end
  return colour, marker, is_dashed
end

-- Gives each line its method's colour and marker: a single line those of the method that it is about, lines
-- of numbers, such as shininesses, the first ones in their order. labels="sah50_3: SAH, all axes" renames
-- lines.
local function style(div, rows, lines, by)
  local seen, labels = {}, {}
  for part in (div.attributes.labels or ""):gmatch("[^;]+") do
    local name, label = part:match("^%s*([^:]+)%s*:%s*(.-)%s*$")
    labels[name:gsub("_", " ")] = label
  end
  for place, line in ipairs(lines) do
    local is_alone = #lines == 1 and (by or "metric") == "metric"
    local name = is_alone and (rows[1].method or "1") or line.title
    line.colour, line.marker, line.is_dashed = need_style(div, name, place)
    local look = line.colour .. line.marker
    if seen[look] then fail_at(div, "%s and %s look the same (tools/weave/methods.lua)", seen[look], name) end
    seen[look] = name
    line.title = labels[line.title] or line.title
  end
end

-- Powers of ten if the numbers span two of them or more, else the numbers themselves.
local function tics(lines, axis, i, linear)
  local least, most = math.huge, 0
  for _, line in ipairs(lines) do
    for _, point in ipairs(line.points) do
      least, most = math.min(least, point[i]), math.max(most, point[i])
    end
  end
  return "set format " .. axis .. (not linear and most / least >= 100 and " '10^{%L}'" or " '%g'")
end

-- Ticks at the points themselves, where all lines have the same few with room between them.
local function tics_at_points(lines, linear)
  local places, seen = {}, {}
  for _, line in ipairs(lines) do
    for _, point in ipairs(line.points) do
      if not seen[point[1]] then seen[point[1]], places[#places + 1] = true, point[1] end
    end
  end
  table.sort(places)
  local least, most = places[1], places[#places]
  if linear or #places > 8 or least < 1 or most >= 1e4 then return "" end
  for i = 2, #places do
    if places[i] / places[i - 1] < (most / least) ^ (1 / 12) then return "" end
  end
  for i, place in ipairs(places) do places[i] = string.format("'%g' %.9g", place, place) end
  return "set xtics (" .. table.concat(places, ", ") .. ")"
end

-- Where guides begin and end: at the smallest x and the largest y of all points; rising ones at the smallest
-- y.
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

-- The x axis ends at the data, not at a power of ten.
local function x_range(lines, linear)
  local left, right = corner(lines)
  if linear then
    local beyond = 0.02 * (right - left)
    return string.format("set xrange [%.9g:%.9g]", left - beyond, right + beyond)
  end
  local beyond = math.max(1.02, (right / left) ^ 0.02)
  return string.format("set xrange [%.9g:%.9g]", left / beyond, right * beyond)
end

-- A marker at every point of a curve of few points, at every eighth of a dense one.
local function markers(line) return #line.points > 16 and "pointinterval 8" or "pointinterval 1" end

local function longest_title(lines)
  local longest = 0
  for _, line in ipairs(lines) do longest = math.max(longest, utf8.len(line.title)) end
  return longest
end

-- Would a legend in this corner, such as "bottom left", cover a curve? Its size is about that of its
-- letters, in a plot of 500 x 290; the y axis reaches to powers of ten.
local function covers(lines, place)
  local left, right, top, bottom = corner(lines)
  bottom, top = math.floor(math.log(bottom, 10)), math.ceil(math.log(top, 10))
  local longest = longest_title(lines)
  local width, height = (70 + 8 * longest) / 500, (10 + 20 * #lines) / 290
  local function is_within(x, y) -- fractions of the plot
    if place:find("right") then x = 0.95 - x end -- gnuplot keeps a margin there
    if place:find("top") then y = 0.95 - y end
    return x < width and y < height
  end
  local function is_covered(point, next_point)
    for step = 0, 10 do
      local x = point[1] * (next_point[1] / point[1]) ^ (step / 10)
      local y = point[2] * (next_point[2] / point[2]) ^ (step / 10)
      local across = math.log(x / left) / math.log(right / left)
      local up = (math.log(y, 10) - bottom) / (top - bottom)
      if is_within(across, up) then return true end
    end
  end
  for _, line in ipairs(lines) do
    for i, point in ipairs(line.points) do
      if is_covered(point, line.points[i + 1] or point) then return true end
    end
  end
  return false
end

-- The legend is placed where falling or rising lines leave room; for many lines, or where they leave none,
-- below the plot.
local many = 4

local function place_of_legend(lines)
  local points = lines[1].points
  local falls = #points > 1 and points[#points][2] < points[1][2]
  return falls and (points[1].low and "bottom left" or "top right") or "top left"
end

local function is_legend_below(lines, linear)
  return #lines > many or not linear and covers(lines, place_of_legend(lines))
end

local function legend(lines, linear)
  if is_legend_below(lines, linear) then
    local longest = longest_title(lines)
    local width = longest > 24 and -longest * 2 // 5 or longest > 20 and -3 or 0
    return "bmargin " .. (longest > 30 and "left" or "center") ..
      " horizontal Left reverse maxcols 2 samplen 2 height 0.6 font ',13' " ..
      "width " .. width -- gnuplot takes letters to be wider than they are
  end
  local place = place_of_legend(lines)
  return place:find("left") and place .. " Left reverse" or place
end

-- "-0.5" or "-1/2"
local function slope_of(word)
  local sign, over, under = word:match("^(-?)(%d+)/(%d+)$")
  return over and (sign == "-" and -1 or 1) * over / under or tonumber(word)
end

-- Thin grey lines of these slopes, as parts of a plot, with the slopes at their ends.
local function guides(div, script, lines)
  local parts, left, right, top, bottom = {}, corner(lines)
  for i, word in ipairs(words(div.attributes.guides)) do
    local slope = slope_of(word) or fail_at(div, "guides: %s is not a slope", word)
    local start = slope > 0 and bottom or top
    parts[i] = string.format(
      "[x=%.9g:%.9g] %.9g * (x / %.9g) ** (%.9g) with lines lc rgb '#999999' dt %d lw 1 notitle",
      left, right, start, left, slope, i + 1)
    script[#script + 1] = string.format(
      "set label %s at %.9g, %.9g left offset 1, 0 tc rgb '#777777' font ',12'",
      quote(word:gsub("^-", "−")), right, start * (right / left) ^ slope)
  end
  return parts
end

-- Names the least value of each line at its place.
local function mark_least(script, lines)
  for _, line in ipairs(lines) do
    local least = line.points[1]
    for _, point in ipairs(line.points) do
      if point[2] < least[2] then least = point end
    end
    script[#script + 1] = string.format(
      "set label 'least: %.4g' at %.9g, %.9g center offset 0, 1.2 point pt 6 ps 2 lw 2 lc rgb '%s'",
      least[2], least[1], least[2], line.colour)
  end
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
  return string.format("$band%d using 1:2:3 with filledcurves lc rgb '%s' fs transparent solid 0.25 notitle",
    i, line.colour)
end

-- Puts the slope of each curve of errors over the number of samples into the legend: that of a table with a
-- row per method, if the directive names one (slopes=NAME), else a fit. Errors whose band reaches 0 are those
-- of the reference; where seeds differ by more than `unsteady` times, the variance may be infinite, and a
-- slope is luck.
local unsteady = 4

local function name_slopes(div, lines, feature)
  local slopes, table_name = {}, div.attributes.slopes
  if table_name then
    local list = pandoc.Div({}, {["data-pos"] = div.attributes["data-pos"], table = table_name,
      where = "feature=" .. feature})
    for _, row in ipairs((tables.read(list))) do slopes[tables.cell(row, "method")] = tonumber(row.slope) end
  end
  for _, line in ipairs(lines) do
    local points, is_steady = {}, true
    for _, point in ipairs(line.points) do
      is_steady = is_steady and not (point.low and point.high > unsteady * point.low)
      if point.samples >= fit.from and point.low then points[#points + 1] = {point.samples, point[2]} end
    end
    local slope = table_name and slopes[line.title] or
      not table_name and is_steady and #points > 2 and fit.slope(points)
    if slope then line.title = line.title .. string.format(" (%.2f)", slope):gsub("-", "−") end
  end
end

-- What band and legend show.
local function explain(div, rows, has_slopes)
  local seeds = rows[1] and rows[1].seeds
  local is_bench = div.attributes.driver == "bench"
  local band = is_bench and "band: 95 % confidence interval" or
    seeds and "RMS over " .. seeds .. " seeds, band: from the least to the largest of one" or nil
  local slopes = has_slopes and "in brackets: slope over samples, from " .. fit.from .. " on" or nil
  return band and slopes and band .. "; " .. slopes or band or slopes
end

local is_rough = false -- the plot that is being drawn

local function shown(div, path, notes)
  if is_rough then notes[#notes + 1] = tables.rough_note:gsub("^≈: ", "times: ") end
  notes[#notes + 1] = "numbers: "
  return pandoc.Div({
    pandoc.Plain({pandoc.Image(pandoc.utils.stringify(div.content), path)}),
    drive.caption(div.content,
      {pandoc.Str(drive.reservation(div) .. table.concat(notes, "; ")), tables.link(div)}),
  }, {class = "picture plot"})
end

local drawn = {} -- pictures

local function draw(div, name, xlabel, ylabel, lines, left_out, back, choice, note)
  local linear = div.attributes.linear
  drawn[name] = (drawn[name] or 0) + 1
  local path = "figures/" .. name .. (drawn[name] > 1 and "_" .. drawn[name] or "") .. ".svg"
  local is_below = is_legend_below(lines, linear)
  local width = is_below and 600 + 12 * math.max(longest_title(lines) - 28, 0) or 600
  local script = {
    "set terminal svg size " .. width .. "," .. (is_below and 440 or 380) ..
      " font 'Helvetica,15' background 'white'",
    "set output " .. quote(drive.out .. "/" .. path),
    linear and "unset logscale" or "set logscale xy",
    tics(lines, "x", 1, linear), tics(lines, "y", 2, linear), tics_at_points(lines, linear), "set grid",
    x_range(lines, linear),
    div.attributes.yrange and "set yrange [" .. div.attributes.yrange:gsub(" ", ":") .. "]" or "",
    div.attributes.guides and "set rmargin 7" or "set rmargin 2",
    linear and #lines == 1 and "unset key" or "set key " .. legend(lines, linear),
    "set xlabel " .. quote(xlabel), "set ylabel " .. quote(ylabel),
  }
  local parts = guides(div, script, lines)
  if div.attributes.mark == "least" then mark_least(script, lines) end
  for i, line in ipairs(lines) do
    script[#script + 1] = string.format("set style line %d lc rgb '%s' pt %d lw 2.5 %s%s",
      i, line.colour, line.marker, line.is_dashed and "dt 2 " or "", markers(line))
    script[#script + 1] = "$data" .. i .. " << EOD"
    for _, point in ipairs(line.points) do
      script[#script + 1] = string.format("%.9g %.9g", point[1], point[2])
    end
    script[#script + 1] = "EOD"
    parts[#parts + 1] = band_of(script, line, i)
    parts[#parts + 1] = string.format("$data%d using 1:2 with linespoints linestyle %d title %s noenhanced",
      i, i, quote(line.title))
  end
  local plot = div.attributes.guides and "plot sample " or "plot "
  script[#script + 1] = plot .. table.concat(parts, ", ") .. "\n"
  local pipe = io.popen(drive.quote(gnuplot), "w")
  pipe:write(table.concat(script, "\n"))
  if not pipe:close() then fail_at(div, "gnuplot failed (its reason is above)") end
  local notes = {choice}
  notes[#notes + 1] = note
  if left_out > 0 then
    notes[#notes + 1] = "left out: values of 0 or less, which have no logarithm (" .. left_out .. ")"
  end
  if back > 0 then
    notes[#notes + 1] = "where a curve runs back, more samples took less time: the machine was busy (" ..
      back .. ")"
  end
  return shown(div, path, notes)
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
    "set terminal svg size " .. (#places > many and 820 or 600) ..
      ",320 font 'Helvetica,15' background 'white'",
    "set output " .. quote(drive.out .. "/" .. path),
    "set style data histogram", "set style histogram clustered gap 1", "set style fill solid",
    "set boxwidth 0.9", "set yrange [0:*]", "set grid y",
    #groups > 1 and "set key top left Left reverse noenhanced" or "unset key",
    "set xlabel " .. quote(xlabel), "set ylabel " .. quote(ylabel), "$data << EOD",
  }
  for _, at in ipairs(places) do
    local line = {'"' .. at .. '"'}
    for _, group in ipairs(groups) do line[#line + 1] = height[at][group] or "NaN" end
    script[#script + 1] = table.concat(line, " ")
  end
  script[#script + 1] = "EOD"
  for i, group in ipairs(groups) do
    parts[i] = string.format("$data using %d:xtic(1) lc rgb '%s' title %s noenhanced",
      i + 1, (need_style(div, group, i)), quote(group))
  end
  if div.attributes.line then
    parts[#parts + 1] = need(div, "line") .. " with lines dt 2 lw 2 lc rgb '#000000' notitle"
  end
  script[#script + 1] = "plot " .. table.concat(parts, ", ") .. "\n"
  local pipe = io.popen(drive.quote(gnuplot), "w")
  pipe:write(table.concat(script, "\n"))
  if not pipe:close() then fail_at(div, "gnuplot failed (its reason is above)") end
  return shown(div, path, {})
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
    local x, by = given.x or "triangles", given.by or "metric"
    is_rough = tables.has_rough(div, rows, {"median"})
    for _, column in ipairs({x, given.by}) do tables.check_column(div, columns, column) end
    rows = some_of(div, rows, by)
    local ylabel = (given.ylabel or "time") .. ", " .. unit_of(div, rows)
    local lines, left_out, back = lines_of(div, rows, x, "median", by)
    style(div, rows, lines, by)
    return draw(div, tables.name(div) .. "_" .. metrics[1], given.xlabel or tables.label(x), ylabel, lines,
      left_out, back)
  end
  local x, y = need(div, "x"), need(div, "y")
  if given.driver then drive.measure(div, "--quiet") end
  local rows, columns = tables.read(div)
  for _, column in ipairs({x, y, given.by}) do tables.check_column(div, columns, column) end
  is_rough = tables.has_rough(div, rows, {x, y})
  if given.bars then
    return draw_bars(div, given.name or tables.name(div) .. "_bars", given.xlabel or tables.label(x),
      given.ylabel or tables.label(y), rows, x, y, need(div, "by"))
  end
  local chosen, choice = some_of(div, rows, given.by)
  rows = chosen
  local band = columns[y .. "_low"] and columns[y .. "_high"] and y or nil
  local has_slopes = band and columns.samples and (x == "samples" or x == "seconds")
  local lines, left_out, back = lines_of(div, rows, x, y, given.by, band)
  style(div, rows, lines, given.by)
  if has_slopes then name_slopes(div, lines, rows[1].feature) end
  local name = given.name or tables.name(div) .. "_" .. y .. "_over_" .. x
  return draw(div, name, given.xlabel or tables.label(x), given.ylabel or tables.label(y), lines, left_out,
    back, choice, band and explain(div, rows, has_slopes))
end
