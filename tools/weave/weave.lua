-- What the report's filter and the book's share: running the drivers where a text asks for it, and
-- errors that name the text's file and line (pandoc reads it with the extension sourcepos).
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
--   [the suite](file:tests/test_bvh_median.c)
--   [the section](report:bvh_median), [the chapter](book:boxes)
-- link to a file of the source tree and to a heading of the report or the book.
--
-- Environment: RAYKIT_WEAVES (book or report: what is woven), RAYKIT_SOURCE, RAYKIT_SOURCE_LINK
-- (the way from the page to it), RAYKIT_BUILD (where the drivers are), RAYKIT_OUT, MESHES,
-- RAYKIT_RUNS, RAYKIT_SIZE (pixels a side, empty for the drivers' own), RAYKIT_GNUPLOT (empty: no
-- plots).

local weave = {}

local source = os.getenv("RAYKIT_SOURCE")
local build = os.getenv("RAYKIT_BUILD")
local out = os.getenv("RAYKIT_OUT")
local runs = os.getenv("RAYKIT_RUNS")
local size = os.getenv("RAYKIT_SIZE") or ""
local gnuplot = os.getenv("RAYKIT_GNUPLOT") or ""

local name_of_all = os.getenv("RAYKIT_WEAVES")

local function say(...) io.stderr:write(name_of_all, ": ", string.format(...), "\n") end

local function fail(...)
  say(...)
  os.exit(1)
end

-- "docs/01_bvh_median.md:12", where an element stands.
local function place(element)
  local file, line = (element.attributes["data-pos"] or ""):match("^(.-)@(%d+):")
  if not file then return "a text" end
  if file:sub(1, #source + 1) == source .. "/" then file = file:sub(#source + 2) end
  return file .. ":" .. line
end

-- An attribute that a directive cannot do without.
local function need(element, key)
  local value = element.attributes[key]
  if not value or value == "" then
    fail("%s: .%s wants %s=...", place(element), element.classes[1], key)
  end
  return value
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

-- Runs a command for an element of the text and returns what it printed.
local function run(command, element)
  local pipe = io.popen(command, "r")
  local answer = pipe:read("a")
  if not pipe:close() then
    fail("%s: this command failed (its reason stands above): %s", place(element), command)
  end
  return answer
end

local function driver_path(element)
  local name = need(element, "driver")
  local path = run("ls -d " .. quote(build) .. "/assignments/*_" .. name .. "/" .. name .. " 2>/dev/null || true", element)
  path = path:match("[^\n]+")
  if not path then fail("%s: there is no driver called %s", place(element), name) end
  return path
end

local driven = {} -- what was printed, by command: what was measured once is not measured again

-- Runs the driver that an element names and returns what it printed. Its files go where all go, in
-- the size of a trial if it is one; or into `folder`, as they are.
local function drive(element, args, folder)
  if size ~= "" and not folder then args = args .. " --width " .. size .. " --height " .. size end
  local command = quote(driver_path(element)) .. " " .. args .. " --out " .. quote(folder or out)
  if not driven[command] then
    say("%s %s", element.attributes.driver, args)
    driven[command] = run(command, element)
  end
  return driven[command]
end

-- "out/figures/x.png: what it shows" -> "figures/x.png", "what it shows"
local function split_line(line, div)
  local path, parameters = line:match("^(.-%.png): ([^\n]*)")
  if not path then fail("%s: the driver printed no line with its picture's path: %s", place(div), line) end
  return path:sub(#out + 2), parameters
end

local drawn_by = {} -- arguments, by picture

local function figure(div, args)
  local path, parameters = split_line(drive(div, args), div)
  if (drawn_by[path] or args) ~= args then
    fail("%s: %s is drawn already, but with %s; two pictures of one name cannot both be shown",
      place(div), path, drawn_by[path])
  end
  drawn_by[path] = args
  local inlines = pandoc.List(pandoc.utils.blocks_to_inlines(div.content))
  local small = pandoc.Span(parameters, {class = "parameters"})
  local picture = pandoc.Image(pandoc.utils.stringify(div.content), path)
  return pandoc.Div({
    pandoc.Plain({picture}),
    pandoc.Div({pandoc.Plain(inlines), pandoc.Plain({small})}, {class = "caption"}),
  }, {class = "picture"})
end

local function figures(div)
  local args = div.attributes.args or ""
  if div.attributes.each ~= "mesh" then return figure(div, args) end
  local list = pandoc.List()
  for _, mesh in ipairs(meshes) do
    list:insert(figure(div, args .. " --mesh " .. quote(mesh)))
  end
  return pandoc.Div(list, {class = "row"})
end

-- Times a driver on scenes (and meshes); the numbers go to its CSV file.
local function time(div, with_meshes)
  local args = div.attributes.args or ""
  local variants = {""}
  for variant in (div.attributes.variants or ""):gmatch("[^,]+") do variants[#variants + 1] = variant end
  local targets = {}
  for _, scene in ipairs(words(need(div, "scenes"))) do targets[#targets + 1] = "--scene " .. scene end
  for _, mesh in ipairs(with_meshes and meshes or {}) do targets[#targets + 1] = "--mesh " .. quote(mesh) end
  for _, target in ipairs(targets) do
    for _, variant in ipairs(variants) do
      drive(div, target .. " " .. args .. " " .. variant .. " --timing --quiet --runs " .. runs)
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

local function read_table(element)
  local path = out .. "/tables/" .. element.attributes.driver .. ".csv"
  local file = io.open(path) or fail("%s: %s is missing: no driver wrote it", place(element), path)
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
  for _, row in ipairs(read_table(div)) do
    by_scene[row.scene] = by_scene[row.scene] or {triangles = row.triangles}
    by_scene[row.scene][title(row)] = row.median
    title_of[row.metric] = title(row)
  end
  for _, metric in ipairs(words(need(div, "metrics"))) do
    titles[#titles + 1] = title_of[metric] or fail("%s: the driver measured no %s", place(div), metric)
  end
  local head = {{pandoc.Plain("scene")}, {pandoc.Plain("triangles")}}
  local aligns = {pandoc.AlignLeft, pandoc.AlignRight}
  for _, text in ipairs(titles) do
    head[#head + 1] = {pandoc.Plain(text)}
    aligns[#aligns + 1] = pandoc.AlignRight
  end
  local body = {}
  for _, scene in ipairs(wanted_scenes(div, true)) do
    local figures_of = by_scene[scene] or fail("%s: %s has no row in the table", place(div), scene)
    local line = {{pandoc.Plain(scene)}, {pandoc.Plain(show(figures_of.triangles))}}
    for _, text in ipairs(titles) do
      line[#line + 1] = {pandoc.Plain(figures_of[text] and show(figures_of[text]) or "")}
    end
    body[#body + 1] = line
  end
  local widths = {}
  for i = 1, #head do widths[i] = 0 end
  local caption = pandoc.List(pandoc.utils.blocks_to_inlines(div.content))
  caption:insert(pandoc.Span("medians of " .. runs .. (runs == "1" and " run; " or " runs; ") ..
    "all of it: tables/" .. div.attributes.driver .. ".csv", {class = "parameters"}))
  return pandoc.Div({
    pandoc.utils.from_simple_table(pandoc.SimpleTable({}, aligns, widths, head, body)),
    pandoc.Div({pandoc.Plain(caption)}, {class = "caption"}),
  }, {class = "timings"})
end

local function plot(div)
  if gnuplot == "" then
    say("a plot is left out: it needs gnuplot")
    return pandoc.Para({pandoc.Emph("A plot is left out here: this build found no gnuplot.")})
  end
  time(div, false)
  local wanted, names = {}, words(need(div, "metrics"))
  for _, scene in ipairs(wanted_scenes(div, false)) do wanted[scene] = true end
  local data, lines, unit = {}, {}, nil
  for i, metric in ipairs(names) do
    local rows = #data + 1
    data[#data + 1] = "$data" .. i .. " << EOD"
    for _, row in ipairs(read_table(div)) do
      if row.metric == metric and wanted[row.scene] then
        data[#data + 1] = table.concat({row.triangles, row.median, row.min, row.max}, " ")
        unit = row.unit
      end
    end
    if #data == rows then fail("%s: the driver measured no %s", place(div), metric) end
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
  if not pipe:close() then fail("%s: gnuplot failed (its reason stands above)", place(div)) end
  local caption = pandoc.List(pandoc.utils.blocks_to_inlines(div.content))
  return pandoc.Div({
    pandoc.Plain({pandoc.Image(pandoc.utils.stringify(div.content), path)}),
    pandoc.Div({pandoc.Plain(caption)}, {class = "caption"}),
  }, {class = "picture plot"})
end

-- One number from the driver's table: .measured with driver, scene and metric.
local function measured(span)
  local scene, metric = need(span, "scene"), need(span, "metric")
  time({attributes = {driver = need(span, "driver"), scenes = scene, args = span.attributes.args,
    ["data-pos"] = span.attributes["data-pos"]}, classes = span.classes}, false)
  for _, row in ipairs(read_table(span)) do
    if row.scene == scene and row.metric == metric then return pandoc.Str(show(row.median)) end
  end
  fail("%s: the driver measured no %s of %s", place(span), metric, scene)
end

-- --- links -----------------------------------------------------------------------------------

-- Has a text in one of these folders a heading (or something else) with this name?
local function is_anchored(folder, anchor)
  local pattern = "{[^}\n]*#" .. anchor:gsub("%W", "%%%0") .. "%f[%s}]"
  for path in run("ls " .. quote(source .. "/" .. folder) .. "/*.md", {attributes = {}}):gmatch("[^\n]+") do
    local file = io.open(path)
    local text = file:read("a")
    file:close()
    if text:find(pattern) then return true end
  end
  return false
end

local pages = {
  book = {folder = "docs", page = "../../docs/out/book.html"},
  report = {folder = "reports", page = "../../reports/out/report.html"},
}

local function link_to_file(path, element)
  local file = io.open(source .. "/" .. path)
  if not file then fail("%s: there is no file %s", place(element), path) end
  file:close()
  return os.getenv("RAYKIT_SOURCE_LINK") .. "/" .. path
end

local function resolve(link)
  local kind, rest = link.target:match("^(%a+):(.*)$")
  if kind == "file" then
    link.target = link_to_file(rest, link)
  elseif pages[kind] then
    if not is_anchored(pages[kind].folder, rest) then
      fail("%s: nothing in the %s is called %s", place(link), kind, rest)
    end
    link.target = (kind == name_of_all and "" or pages[kind].page) .. "#" .. rest
  elseif kind ~= "https" and link.target:sub(1, 1) ~= "#" then
    fail("%s: %s is no link; begin it with #, file:, book:, report: or https:", place(link), link.target)
  end
  return link
end

-- --- filters ---------------------------------------------------------------------------------

-- Classes of divisions that only look different.
local plain_classes = {row = true}

-- The first filter: directives become what they ask for. `own` holds a text's further ones, by
-- element type and class.
function weave.directives(own)
  local divs = {figure = figures, timings = timings, plot = plot}
  local spans = {measured = measured}
  for class, directive in pairs(own.Div or {}) do divs[class] = directive end
  local function expand(list)
    return function(element)
      local class = element.classes[1]
      if not class or plain_classes[class] then return nil end
      if not list[class] then
        fail("%s: there is no directive called .%s", place(element), class)
      end
      return list[class](element)
    end
  end
  return {Div = expand(divs), Span = expand(spans), Code = own.Code, CodeBlock = own.CodeBlock,
    Link = resolve}
end

local function forget(element)
  while element.attributes["data-pos"] do element.attributes["data-pos"] = nil end -- lists have two
  return element
end

-- A wrapper in which pandoc put something only to say where it stands.
local function unwrap(element)
  forget(element)
  if element.identifier == "" and #element.classes == 0 and #element.attributes == 0 then
    return element.content
  end
  return element
end

-- The last filter: the places are of no use to readers.
weave.without_places = {Div = unwrap, Span = unwrap, Header = forget, Code = forget, Link = forget,
  CodeBlock = forget, Image = forget, Table = forget}

weave.say, weave.fail, weave.place, weave.need = say, fail, place, need
weave.quote, weave.run, weave.drive, weave.link_to_file = quote, run, drive, link_to_file
weave.out, weave.resolve = out, resolve
weave.source = source

return weave
