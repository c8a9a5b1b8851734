-- Common to the report's filter and the book's: directives, by which a text requests figures, tables
-- and plots, and links. Figures and links are here, tables in tables.lua, plots in plot.lua, pictures
-- of mistakes and steps in wrong.lua.
--
--   ::: {.figure driver=bvh_median args="--scene teapot --debug level --level 4"}
--   The caption, in Markdown.
--   :::
-- runs the driver and becomes its picture, with the caption and the driver's line of parameters below.
-- A picture that is mostly black, or small in its frame, is a mistake unless dark=yes. The command
-- below it is folded unless command=open.
-- With each=mesh it is repeated for every file in MESHES (and left out if there is none); a note says where
-- little can
-- be seen of one.
--
-- crop="0.5 0.2 0.25 0.25" shows a part of the picture, magnified (crop.lua); label="0.6 0.3 0.8 0.2 red
-- pane; ..." puts words over it (labels.lua).
--
--   :::: {.row}
--   ::: {.figure ...}
--   ::::
-- puts figures and plots side by side, two or three if the page is wide enough; .pair puts two per
-- row. On a phone they are one below the other. Where there are two of equal size, they must differ visibly.
-- {.row .compare} makes one of two pictures of the same view and size, with a slider between them, their
-- difference and an enlargement, where scripts run.
--
-- Figures, plots, tables and displayed formulas have numbers within their chapter. With a name,
-- {.figure #halo ...} or [$$...$$]{#halo}, an empty link gives the number: [](#halo). alt="..." says
-- what is seen to who does not see it, in the place of the caption's first sentence.
--
--   ::: {.timings driver=bvh_median scenes="cornell teapot" variants="--shadows" metrics="build render"}
--   The caption.
--   :::
-- times the driver on each scene and each mesh, once without and once with each of the variants
-- (separated by commas), and becomes a table with a column for each of the metrics, from the
-- driver's CSV file; labels="build: building; ..." names them otherwise. rows="scene method" has a row for
-- each scene and method; rows="scene" is the default, rows=none has a row for each metric, where the scene
-- plays no part.
--
--   ::: {.table driver=shadows args="--convergence" columns="method, samples, rmse: error"}
--   The caption.
--   :::
-- shows columns of tables/shadows.csv, each under a title of its own if one follows its colon.
-- table=NAME reads tables/NAME.csv instead; keep=NAME keeps this run's table under another name, where two
-- runs with different options would write the same. The driver runs first, on each of scenes="..." if given;
-- without driver=... the table is that of an earlier directive.
--
--   ::: {.plot driver=shadows args="--convergence" x=samples y=rmse by=method}
-- plots a column over another, both with logarithmic axes, a line for each value of a third; from
-- the same table. xlabel="..." and ylabel="..." name the axes, with their units, if the columns'
-- names do not suffice. Where the table has columns y_low and y_high (rmse_low, rmse_high), they are a band,
-- and if it has samples, too, the legend has each curve's slope over their number: fitted, or with
-- slopes=NAME from tables/NAME.csv. guides="-1/2 -1" adds grey lines of these slopes (rising ones from the
-- lowest point on), and name=... names the picture's file. linear=yes has linear axes; mark=least names the
-- least value of each line; yrange="1e-3 1e5" gives two plots the same axis. bars=yes draws bars from 0 on
-- instead, beside each other for the values of `by`; x may be any text.
--
-- driver=bench stands for tools/bench.py, whose tables are those of make bench: the full measurement if
-- this build has one, else the quick one.
--
--   ::: {.plot driver=bvh_median scenes="statue:1000 statue:10000" metrics="build render" ylabel="median
-- time"} times as .timings does and plots the metrics over the number of triangles, or over x=...
--
-- where="threads=1 method=grid" keeps .timings, .table and .plot to rows with these values.
--
--   ::: {.live driver=bloom args="..." options="..."}
-- is a figure whose options the reader changes in the browser: tools/weave/live.lua.
--   ::: {.wrong stem=bloom}
-- shows the feature's wrong pictures (assignments/NN_bloom/wrong.tsv) beside the right ones, each with its
-- mistake and the claim that finds it; .wrong sees=holes those of all features in which one sees this.
--
--   ::: {.steps stem=bloom}
-- shows what can be seen after each step of the assignment (look.tsv), and the claims that then hold.
--
--   :::: {.if_measured table=peers}
--   ::: {.table table=peers ...}
--   ::::
-- stays only if tables/peers.csv was measured before the page is woven; .unless_measured is its counterpart.
--
--   [boxes]{.measured driver=bvh_median scene=statue:87130 metric=build}
-- becomes that one number; so does [gain]{.measured driver=bench table=accuracy where="case=lens"
-- column=time_ratio},
-- from any table of a driver.
--
--   [sobol]{.default driver=depth_of_field option=lens-sampling}
-- becomes the default of the driver's option.
--
-- Sentences that numbers or a driver's output must bear out, .check and .printed, and numbers computed from
-- others, .value: see values.lua.
--
--   [the suite](file:tests/test_bvh_median.c), [the section](report:bvh_median), [the chapter](book:boxes)
-- link to a file of the source tree and to a heading of the report or the book; [here](#boxes) to
-- one of the same page, as does [there](glossary.md#terms) in texts that are also read as they are.
--
-- A mistake in a text ends the weaving and names the text's file and line. So does a driver's
-- failure, but with a student's units it costs only the driver's output.
--
-- Environment: RAYKIT_WEAVES (report or book), RAYKIT_SOURCE, RAYKIT_SOURCE_LINK (the
-- path from the page to it), RAYKIT_DRIVERS (the folder over assignments/ with the drivers),
-- RAYKIT_BUILD, RAYKIT_WRONG (the command that draws wrong pictures, empty in a pack), RAYKIT_STORE (the
-- folder of what drivers made), RAYKIT_RECORD (a pack's, or empty), RAYKIT_MEASURED (not empty: times are
-- measured carefully), RAYKIT_MACHINE (whose times they are), RAYKIT_PROCESSORS (their number),
-- RAYKIT_TERMINAL (not empty: progress is told in one line), RAYKIT_ALONE (the features that are woven alone,
-- empty for all), RAYKIT_UNITS (the name of their units' author, empty for the kit's own), RAYKIT_OUT,
-- RAYKIT_SCRAPS (for temporary files), MESHES, RAYKIT_RUNS, RAYKIT_SIZE (pixels per side, empty for the
-- drivers' own), RAYKIT_PAIR (the program that compares two pictures, empty: none is compared),
-- RAYKIT_GNUPLOT (empty: no plots).

local drive = require("drive")
local glossary = require("glossary")
local tables = require("tables")
local plot = require("plot")
local values = require("values")
local crop = require("crop")
local defaults = require("defaults")
local labels = require("labels")
local pictures = require("pictures")
local listings = require("listings")
local numbering = require("numbering")
local paged = require("pages")
local present = require("present")
local sources = require("sources")
local store = require("store")
local live = require("live")
local wrong = require("wrong")
local fail_at = drive.fail_at

local weave = {}

-- --- figures ---------------------------------------------------------------------------------

-- "out/figures/x.png: its contents" -> "figures/x.png", "its contents"
local function split_line(div, line)
  local path, parameters = line:match("^([^\n]-%.png): ([^\n]*)")
  if not path then
    drive.fail_by_driver(div, "the driver printed no line with its picture's path: %s", line)
  end
  return path:sub(#drive.out + 2), parameters
end

local drawn_by = {} -- arguments, by picture

-- The picture or a part of it, with its labels, as a block.
local function shown(div, path)
  local alt = pandoc.utils.stringify(div.content) .. labels.as_text(div)
  local block, ratio = crop(div, pandoc.Image(alt, path))
  return div.attributes.label and labels.over(div, block, ratio) or block
end

-- The driver's picture: of a scene, or of a user's mesh.
local function figure(div, args, mesh)
  local answer, said = drive.run(div, args)
  local path, parameters = split_line(div, answer)
  if (drawn_by[path] or args) ~= args then
    fail_at(div, "%s is drawn already, but with %s; two pictures cannot have the same name",
      path, drawn_by[path])
  end
  drawn_by[path] = args
  local notes = mesh and pictures.notes(path, mesh, said) or {}
  if not mesh then pictures.check_subject(div, path) end
  if not args:find("--width", 1, true) and not args:find("--height", 1, true) then
    tables.picture_size[div.attributes.driver] = parameters:match("%d+ x %d+")
  end
  local caption = drive.caption(div.content, drive.without_times(parameters))
  for _, note in ipairs(notes) do
    caption.content:insert(2, pandoc.Plain({pandoc.Span(note, {class = "parameters"})}))
  end
  caption.content:insert(drive.command(div, args))
  local blocks = pandoc.List({shown(div, path)})
  blocks:extend({pictures.scale(path)})
  blocks:insert(caption)
  return pandoc.Div(blocks, {class = "picture"})
end

-- In the place of a picture.
local function not_made(reason)
  return pandoc.Div({pandoc.Plain({pandoc.Strong("Not made: " .. reason)})}, {class = "picture missing"})
end

local function undrawn(mesh)
  return not_made("this cannot be drawn of " .. mesh:gsub(".*/", "") ..
    "; the driver's reason is on the terminal.")
end

-- The options that turn users' meshes, where make was given UP or FRONT.
local function turning()
  local options = ""
  for _, name in ipairs({"up", "front"}) do
    local axis = os.getenv("RAYKIT_" .. name:upper()) or ""
    if axis ~= "" then options = options .. " --" .. name .. " " .. drive.quote(axis) end
  end
  return options
end

-- The figure with the mesh's name in its caption, in the place of `MESH`.
local function named(div, mesh)
  local name = mesh:gsub(".*/", "")
  return div:walk({Code = function(code) return code.text == "MESH" and pandoc.Str(name) or nil end})
end

-- needs=FILE: of an optional package, whose name follows.
local function lacks(div)
  local file, package = (div.attributes.needs or ""):match("^(%S+) (%S+)$")
  if not file or drive.exists(file) then return nil end
  return "it needs " .. file:gsub(".*/", "") .. " of Debian's package " .. package .. "."
end

local function figures(div)
  local args = div.attributes.args or ""
  if lacks(div) then return not_made(lacks(div)) end
  if div.attributes.each ~= "mesh" then return figure(div, args) end
  local list = pandoc.List()
  drive.each(drive.meshes, function(mesh)
    local of_mesh = args .. " --mesh " .. drive.quote(mesh) .. turning()
    list:insert(drive.forgiving_mesh(figure, named(div, mesh), of_mesh, mesh) or undrawn(mesh))
  end)
  return pandoc.Div(list, {class = "row"})
end

-- --- links -----------------------------------------------------------------------------------

local pages = {
  book = {folder = "docs", made = "docs/out/book.html", handed_out = "docs/handout/book.html"},
  report = {folder = "reports", made = "reports/out/report.html"},
}

-- Returns the text of a page that has a heading (or something else) with this name, or nil.
local function anchored_in(page, anchor)
  local pattern = "{[^}\n]*#" .. anchor:gsub("%W", "%%%0") .. "%f[%s}]"
  for _, path in ipairs(drive.list(drive.source, page.folder .. "/*.md")) do
    if drive.read_file(path):find(pattern) then return path:sub(#drive.source + 2) end
  end
  return nil
end

-- A link to a name in another page, if that is made or in the pack; else to the name in its text.
local function link_into(page, anchor, text)
  local source = os.getenv("RAYKIT_SOURCE_LINK")
  if drive.exists(os.getenv("RAYKIT_BUILD") .. "/" .. page.made) then
    return "../../" .. page.made .. "#" .. anchor
  end
  if page.handed_out and drive.exists(drive.source .. "/" .. page.handed_out) then text = page.handed_out end
  return source .. "/" .. text .. "#" .. anchor
end

function weave.link_to_file(path, element, line)
  if not drive.exists(drive.source .. "/" .. path) then fail_at(element, "there is no file %s", path) end
  return sources.link(path, line)
end

function weave.resolve(link)
  local text, name = link.target:match("^([%w_]+%.md)#?(.*)$")
  if text then link.target = name == "" and "file:docs/" .. text or "#" .. name end
  local kind, rest = link.target:match("^(%a+):(.*)$")
  if kind == "file" then
    link.target = weave.link_to_file(rest, link)
  elseif pages[kind] then
    local text = anchored_in(pages[kind], rest)
    if not text then fail_at(link, "nothing in the %s is called %s", kind, rest) end
    link.target = kind == drive.page and "#" .. rest or link_into(pages[kind], rest, text)
  elseif kind ~= "https" and link.target:sub(1, 1) ~= "#" then
    fail_at(link, "%s is not a link; begin it with #, file:, book:, report: or https:", link.target)
  end
  return link
end

local names = {} -- of anchors that are set already

-- The name, on its first use: an anchor must be unique.
function weave.anchor(name)
  if names[name] then return "" end
  names[name] = true
  return name
end

local named_at = {} -- places, by the names that texts give

-- Before the drivers run, which takes minutes.
local function check_unique(element)
  local name = element.identifier
  if name == "" then return end
  if named_at[name] then
    fail_at(element, "#%s is in %s already; a name must be unique in the %s, " ..
      "or links lead to the wrong place", name, named_at[name], drive.page)
  end
  named_at[name] = drive.place(element)
end

local function remember(element)
  if element.identifier ~= "" then names[element.identifier] = true end
end

-- Where some features are woven alone, links to others go elsewhere.
local function check_link(link)
  local target = link.target:match("^#(.*)$")
  if not target or names[target] then return end
  local is_alone = os.getenv("RAYKIT_ALONE") ~= ""
  if is_alone and target:find("^code%-") then return link.content end -- another chapter's listing
  local text = is_alone and anchored_in(pages[drive.page], target)
  if not text then fail_at(link, "nothing in the %s is called #%s", drive.page, target) end
  link.target = link_into(pages[drive.page], target, text)
  return link
end

-- --- filters ---------------------------------------------------------------------------------

-- Classes of divisions that affect only the layout.
local plain_classes = {row = true, pair = true}

-- The replacement where a student's units failed.
local function missing(element)
  local reason = drive.unmade(element) or "the driver failed with these units."
  local sentence = "Not made: " .. reason
  if element.t == "Span" then return pandoc.Emph(sentence) end
  return pandoc.Div({pandoc.Plain({pandoc.Strong(sentence)}), drive.caption(element.content)},
    {class = "picture missing"})
end

-- A name and a text for who cannot see the picture, given to the directive, are its result's.
local function inherit(result, element)
  if result.t ~= "Div" then return result end
  if result.identifier == "" then result.identifier = element.identifier end
  result.attributes.alt = element.attributes.alt
  return result
end

-- Directives that ask for drivers' runs.
local asking = {figure = true, timings = true, table = true, plot = true, live = true, wrong = true,
  output = true, measured = true, printed = true, steps = true}

local function note(directives)
  return function(element)
    local class = element.classes[1]
    local is_asked = element.attributes.driver or class == "wrong" or class == "steps"
    if is_asked and asking[class] and directives[class] then drive.note(directives[class], element) end
  end
end

local function expand(directives)
  return function(element)
    local class = element.classes[1]
    if plain_classes[class] then pictures.check_row(element) end
    if not class or plain_classes[class] or values.spans[class] then return nil end
    if not directives[class] then fail_at(element, "there is no directive called .%s", class) end
    return inherit(drive.forgiving(directives[class], element) or missing(element), element)
  end
end

-- Where there is no table, directives that would read it must not be expanded.
local function choose(element)
  local wanted = element.classes[1] == "if_measured"
  if not wanted and element.classes[1] ~= "unless_measured" then return nil end
  local path = drive.out .. "/tables/" .. drive.need(element, "table") .. ".csv"
  local is_there = drive.exists(path)
  return (wanted and is_there or not wanted and not is_there) and element.content or {}
end

local function forget(element)
  while element.attributes["data-pos"] do element.attributes["data-pos"] = nil end -- lists have two
  element.attributes["data-crop"] = nil
  return element
end

-- A wrapper that pandoc added only to record a position.
local function unwrap(element)
  forget(element)
  if element.identifier == "" and #element.classes == 0 and #element.attributes == 0 then
    return element.content
  end
  return element
end

-- The filters of a page: directives are replaced by their results, links within the page are checked,
-- and positions, which are of no use to readers, are removed. `own` has the page's own directives, by
-- element type and class.
function weave.filters(own)
  local divs = {figure = figures, timings = tables.timings, table = tables.table, plot = plot,
    live = live.figure, wrong = wrong.wrong(weave.resolve), steps = wrong.steps}
  for class, directive in pairs(own.Div or {}) do divs[class] = directive end
  local spans = {measured = tables.measured, printed = values.printed, default = defaults}
  for class, directive in pairs(own.Span or {}) do spans[class] = directive end
  local function code_block(block)
    return block.classes[1] ~= "values" and own.CodeBlock and own.CodeBlock(block) or nil
  end
  local stages = {
    {Div = choose},
    {Header = check_unique, Div = check_unique, Span = check_unique, CodeBlock = check_unique},
    {Pandoc = drive.begin_plan},
    {Div = note(divs), Span = note(spans), CodeBlock = values.note},
    {Pandoc = drive.draw},
    {Div = expand(divs), Span = expand(spans), Code = own.Code,
      CodeBlock = code_block, Link = weave.resolve, Para = own.Para},
    values.filters[1], values.filters[2], values.filters[3], {Pandoc = function()
      tables.check_kept()
      pictures.finish()
      drive.write_file(drive.out .. "/used", store.list_used())
    end},
    {Pandoc = numbering.assign},
    {Header = remember, Div = remember, Span = remember, CodeBlock = remember},
    {Link = numbering.refer},
    {Link = check_link},
    {Div = present.check_comparison},
    {Div = present.describe},
    {Span = present.formula},
  }
  for _, filter in ipairs(own.late or {}) do stages[#stages + 1] = filter end
  for _, filter in ipairs({
    {Div = unwrap, Span = unwrap, Header = forget, Code = forget, Link = forget,
      CodeBlock = forget, Image = forget, Table = forget},
    {Inlines = present.tie},
    {Pandoc = glossary.link},
    {Div = present.division, Table = present.table, Image = present.size, CodeBlock = listings.present},
    {Pandoc = paged.write},
  }) do stages[#stages + 1] = filter end
  return stages
end

return weave
