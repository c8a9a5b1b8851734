-- Weaves the report: a pandoc filter that runs the drivers where the sections ask for it.
--
--   ::: {.figure driver=bvh_median args="--scene teapot --debug level --level 4"}
--   The caption, in Markdown.
--   :::
-- runs the driver and becomes its picture, with the caption and the driver's own line of
-- parameters under it. With each=mesh it is repeated for every file in MESHES (and is left out
-- when there is none).
--
--   ::: {.timings driver=bvh_median scenes="cornell teapot" variants="--shadows" metrics="build render"}
--   The caption.
--   :::
-- times the driver on each scene and each mesh, once plainly and once with each of the variants
-- (separated by commas), and becomes a table with a row for each scene and a column for each
-- of the metrics, from the driver's CSV file.
--
--   ::: {.plot driver=bvh_median scenes="scan:1000 scan:10000" metrics="build"}
--   times likewise and becomes a log-log plot of the metrics over the number of triangles.
--
-- Environment: RAYKIT_DRIVERS (the folder over assignments/ with the drivers), RAYKIT_OUT, MESHES, RAYKIT_RUNS,
-- RAYKIT_SIZE (pixels a side, empty for the drivers' own), RAYKIT_GNUPLOT (empty: no plots).

local drivers = os.getenv("RAYKIT_DRIVERS")
local out = os.getenv("RAYKIT_OUT")
local runs = os.getenv("RAYKIT_RUNS")
local size = os.getenv("RAYKIT_SIZE") or ""
local gnuplot = os.getenv("RAYKIT_GNUPLOT") or ""

-- With a student's units a driver that fails or never ends costs its own figure, not the report.
local units = os.getenv("RAYKIT_UNITS") or ""

local function fail(...)
  local sentence = string.format(...)
  io.stderr:write("report: ", sentence, "\n")
  if units ~= "" then error({sentence = sentence}) end
  os.exit(1)
end

local function words(text)
  local list = {}
  for word in (text or ""):gmatch("%S+") do list[#list + 1] = word end
  return list
end

local meshes = words(os.getenv("MESHES"))

local function quote(word)
  return "'" .. word:gsub("'", "'\\''") .. "'"
end

local function run(command)
  local pipe = io.popen(command, "r")
  local answer = pipe:read("a")
  local done, how = pipe:close()
  if how == "signal" then os.exit(130) end
  if not done then fail("this command failed (its reason stands above): %s", command) end
  return answer
end

local function driver_path(name)
  local path = run("ls -d " .. quote(drivers) .. "/assignments/*_" .. name .. "/" .. name .. " 2>/dev/null || true")
  path = path:match("[^\n]+")
  if not path then fail("no driver called %s under %s/assignments", name, drivers) end
  return path
end

-- Runs a driver and returns what it printed.
local function drive(name, args)
  if size ~= "" then args = args .. " --width " .. size .. " --height " .. size end
  io.stderr:write("report: ", name, " ", args, "\n")
  local guard = units ~= "" and "timeout -k 5 120 " or ""
  return run(guard .. quote(driver_path(name)) .. " " .. args .. " --out " .. quote(out))
end

-- "out/figures/x.png: what it shows" -> "figures/x.png", "what it shows"
local picture_size
local function split_line(line)
  local path, parameters = line:match("^(.-%.png): ([^\n]*)")
  if not path then fail("a driver printed no line with its picture's path: %s", line) end
  picture_size = parameters:match("%d+ x %d+")
  return path:sub(#out + 2), parameters
end

local function figure(name, args, caption)
  local path, parameters = split_line(drive(name, args))
  local inlines = pandoc.List(pandoc.utils.blocks_to_inlines(caption))
  local small = pandoc.Span(parameters, {class = "parameters"})
  local picture = pandoc.Image(pandoc.utils.stringify(caption), path)
  return pandoc.Div({
    pandoc.Plain({picture}),
    pandoc.Div({pandoc.Plain(inlines), pandoc.Plain({small})}, {class = "caption"}),
  }, {class = "picture"})
end

local function figures(div)
  local name, args = div.attributes.driver, div.attributes.args or ""
  if div.attributes.each ~= "mesh" then return figure(name, args, div.content) end
  local list = pandoc.List()
  for _, mesh in ipairs(meshes) do
    list:insert(figure(name, args .. " --mesh " .. quote(mesh), div.content))
  end
  return pandoc.Div(list, {class = "row"})
end

-- Times a driver on scenes (and meshes); the numbers go to its CSV file.
local function time(div, with_meshes)
  local name, args = div.attributes.driver, div.attributes.args or ""
  local variants = {""}
  for variant in (div.attributes.variants or ""):gmatch("[^,]+") do variants[#variants + 1] = variant end
  local targets = {}
  for _, scene in ipairs(words(div.attributes.scenes)) do targets[#targets + 1] = "--scene " .. scene end
  for _, mesh in ipairs(with_meshes and meshes or {}) do targets[#targets + 1] = "--mesh " .. quote(mesh) end
  for _, target in ipairs(targets) do
    for _, variant in ipairs(variants) do
      drive(name, target .. " " .. args .. " " .. variant .. " --timing --quiet --runs " .. runs)
    end
  end
end

-- The cells of a CSV line without line breaks in cells (the drivers write none).
local function cells(line)
  local list, at = {}, 1
  while at <= #line + 1 do
    local cell
    if line:sub(at, at) == '"' then
      local stop = at + 1
      while line:sub(stop, stop) ~= '"' or line:sub(stop + 1, stop + 1) == '"' do
        stop = stop + (line:sub(stop, stop) == '"' and 2 or 1)
        if stop > #line then fail("an unclosed quote in a table: %s", line) end
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

local function read_table(name)
  local path = out .. "/tables/" .. name .. ".csv"
  local file = io.open(path) or fail("%s is missing: no driver wrote it", path)
  local header = cells(file:read("l"))
  local rows = {}
  for line in file:lines() do
    local row = {}
    for i, cell in ipairs(cells(line)) do row[header[i]] = cell end
    rows[#rows + 1] = row
  end
  file:close()
  return rows
end

local function basename(path) return (path:gsub(".*/", "")) end

-- The scenes that a division asks for, in its order.
local function wanted_scenes(div, with_meshes)
  local list = words(div.attributes.scenes)
  for _, mesh in ipairs(with_meshes and meshes or {}) do list[#list + 1] = basename(mesh) end
  return list
end

-- Three significant digits, or a whole number with thousands marked.
local function show(text)
  local value = tonumber(text)
  if not value then return text end
  if value == math.floor(value) then
    local digits = string.format("%d", value)
    while true do
      local count
      digits, count = digits:gsub("^(-?%d+)(%d%d%d)", "%1,%2")
      if count == 0 then return digits end
    end
  end
  local decimals = math.max(0, 2 - math.floor(math.log(math.abs(value), 10)))
  return string.format("%." .. decimals .. "f", value)
end

local function title(row)
  local name = row.metric:gsub("_", " ")
  return row.unit == "1" and name or name .. ", " .. row.unit
end

local function timings(div)
  time(div, true)
  local by_scene, titles, title_of = {}, {}, {}
  for _, row in ipairs(read_table(div.attributes.driver)) do
    by_scene[row.scene] = by_scene[row.scene] or {triangles = row.triangles}
    by_scene[row.scene][title(row)] = row.median
    title_of[row.metric] = title(row)
  end
  for _, metric in ipairs(words(div.attributes.metrics)) do
    titles[#titles + 1] = title_of[metric] or fail("no driver measured %s", metric)
  end
  local head = {{pandoc.Plain("scene")}, {pandoc.Plain("triangles")}}
  local aligns = {pandoc.AlignLeft, pandoc.AlignRight}
  for _, text in ipairs(titles) do
    head[#head + 1] = {pandoc.Plain(text)}
    aligns[#aligns + 1] = pandoc.AlignRight
  end
  local body = {}
  for _, scene in ipairs(wanted_scenes(div, true)) do
    local figures_of = by_scene[scene] or fail("%s has no row in the table", scene)
    local line = {{pandoc.Plain(scene)}, {pandoc.Plain(show(figures_of.triangles))}}
    for _, text in ipairs(titles) do
      line[#line + 1] = {pandoc.Plain(figures_of[text] and show(figures_of[text]) or "")}
    end
    body[#body + 1] = line
  end
  local widths = {}
  for i = 1, #head do widths[i] = 0 end
  local caption = pandoc.List(pandoc.utils.blocks_to_inlines(div.content))
  caption:insert(pandoc.Span("medians of " .. runs .. (runs == "1" and " run, " or " runs, ") ..
    (picture_size or "") .. " pixels; " ..
    "all of it: tables/" .. div.attributes.driver .. ".csv", {class = "parameters"}))
  return pandoc.Div({
    pandoc.utils.from_simple_table(pandoc.SimpleTable({}, aligns, widths, head, body)),
    pandoc.Div({pandoc.Plain(caption)}, {class = "caption"}),
  }, {class = "timings"})
end

local function plot(div)
  if gnuplot == "" then
    io.stderr:write("report: a plot is left out: it needs gnuplot\n")
    return pandoc.Para({pandoc.Emph("A plot is left out here: this build found no gnuplot.")})
  end
  time(div, false)
  local wanted, names = {}, words(div.attributes.metrics)
  for _, scene in ipairs(wanted_scenes(div, false)) do wanted[scene] = true end
  local data, lines, unit = {}, {}, nil
  for i, metric in ipairs(names) do
    data[#data + 1] = "$data" .. i .. " << EOD"
    for _, row in ipairs(read_table(div.attributes.driver)) do
      if row.metric == metric and wanted[row.scene] then
        data[#data + 1] = table.concat({row.triangles, row.median, row.min, row.max}, " ")
        unit = row.unit
      end
    end
    data[#data + 1] = "EOD"
    lines[#lines + 1] = string.format("$data%d using 1:2 with linespoints linestyle %d title %q", i, i,
      (metric:gsub("_", " ")))
  end
  local path = "figures/" .. div.attributes.driver .. "_" .. names[1] .. ".svg"
  local script = table.concat({
    "set terminal svg size 720,420 font 'Helvetica,15' background 'white'",
    "set output '" .. out .. "/" .. path .. "'",
    "set logscale xy", "set format '10^{%L}'", "set grid", "set key top left",
    "set xlabel 'triangles'", "set ylabel '" .. (div.attributes.ylabel or "time") .. ", " .. unit .. "'",
    "set style line 1 lc rgb '#0072b2' pt 7 lw 2", "set style line 2 lc rgb '#d55e00' pt 5 lw 2",
    "set style line 3 lc rgb '#009e73' pt 9 lw 2",
    table.concat(data, "\n"), "plot " .. table.concat(lines, ", "), "",
  }, "\n")
  local pipe = io.popen(quote(gnuplot), "w")
  pipe:write(script)
  if not pipe:close() then fail("gnuplot failed (its reason stands above)") end
  local caption = pandoc.List(pandoc.utils.blocks_to_inlines(div.content))
  return pandoc.Div({
    pandoc.Plain({pandoc.Image(pandoc.utils.stringify(div.content), path)}),
    pandoc.Div({pandoc.Plain(caption)}, {class = "caption"}),
  }, {class = "picture plot"})
end

local makers = {figure = figures, timings = timings, plot = plot}

return {{Div = function(div)
  local maker = makers[div.classes[1]]
  if not maker then return nil end
  local made, result = pcall(maker, div)
  if made then return result end
  if type(result) ~= "table" then error(result) end
  return pandoc.Div({
    pandoc.Para({pandoc.Strong("Not made: "), pandoc.Str("the driver failed with these units (" .. units .. ").")}),
    pandoc.Div(div.content, {class = "caption"}),
  }, {class = "picture"})
end}}
