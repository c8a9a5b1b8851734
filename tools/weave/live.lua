-- Live figures: a picture that the reader's own browser draws anew, by the chapter's driver.
--
--   ::: {.live driver=bloom args="--scene teapot" options="bloom-threshold=0..1 scene=teapot|cornell"}
--   The caption: what to try.
--   :::
-- becomes the driver's picture, as .figure does. Where the page can run the drivers' WebAssembly module
-- (RAYKIT_LIVE; empty: there is none), each of the options gets a control: its kind, default and help are
-- those of the driver; a text may narrow a range (radius=1..100) or choices (scene=teapot|cornell,
-- debug=|mask, the empty one for none). leaf=0..255@leaf goes with --debug leaf alone, and is left out
-- otherwise; so are the driver's own options of views. Dragging the picture turns the camera, unless
-- drag=no; a click explains a pixel, unless click=no. widget=sah adds what this figure alone has:
-- tools/live/widgets/sah.js.

local drive = require("drive")
local steps = require("steps")

local live = {}

local module = os.getenv("RAYKIT_LIVE") or ""
local known = {} -- the options of each driver, from its --help
local widgets = {} -- texts of their files, by name
local count = 0  -- of live figures

local function check_options(div, options)
  local name = div.attributes.driver
  known[name] = known[name] or drive.help(div)
  for _, word in ipairs(drive.words(options)) do
    local option = word:match("^[^=@]+")
    if not known[name]:find("\n  %-%-" .. option:gsub("%W", "%%%0") .. "%f[^%w-]") then
      drive.fail_at(div, "the driver %s has no option --%s", name, option)
    end
    local low, high = word:match("=([-%d.]*)%.%.([-%d.]*)@?")
    if low and not (tonumber(low) and tonumber(high) and tonumber(low) < tonumber(high)) then
      drive.fail_at(div, "%s is no range; write it as in radius=1..100", word)
    end
  end
end

local function read(name) return drive.read_file(drive.source .. "/tools/live/" .. name) end

local function use_widget(div, name)
  widgets.plot = widgets.plot or read("widgets/plot.js")
  widgets[name] = read("widgets/" .. name .. ".js")
  if not widgets[name] then
    drive.fail_at(div, "there is no widget %s: tools/live/widgets has no %s.js", name, name)
  end
end

-- What to try, in a page where nothing can be tried.
local function where_live(content)
  local first = content[1]:clone()
  first.content:insert(1, pandoc.Str("Where figures are live: "))
  return pandoc.Blocks({first, table.unpack(content, 2)})
end

-- In a folder of its own: another figure may show the same view with other arguments.
function live.figure(div)
  local a = div.attributes
  local args, options = a.args or "", drive.need(div, "options")
  check_options(div, options)
  if a.widget then use_widget(div, a.widget) end
  if not args:find("--width", 1, true) then args = args .. " --width 480 --height 480" end
  local folder = "figures/live_" .. count + 1
  local line = drive.run(div, args, drive.out .. "/" .. folder)
  count = count + 1
  local name, parameters = line:match("/figures/([^/\n]*%.png): ([^\n]*)")
  if not name then
    drive.fail_by_driver(div, "the driver printed no line with its picture's path: %s", line)
  end
  local image = pandoc.Image(pandoc.utils.stringify(div.content), folder .. "/figures/" .. name)
  local by_hand = (module == "" and ". This book has no live figures; by hand: " or
    ". Where the figure is not live, try it by hand: ") .. drive.program(div) .. " " .. args
  return pandoc.Div({
    pandoc.Div({pandoc.Plain({image})}, {class = "live", ["data-driver"] = a.driver, ["data-args"] = args,
      ["data-options"] = options, ["data-program"] = drive.program(div), ["data-drag"] = a.drag,
      ["data-click"] = a.click, ["data-widget"] = a.widget}),
    drive.caption(module == "" and where_live(div.content) or div.content,
      drive.without_times(parameters) .. by_hand),
  }, {class = "picture"})
end

local function packed(path)
  local pipe = io.popen("gzip -9nc " .. drive.quote(path) .. " | base64 -w 0")
  local text = pipe:read("a")
  if not pipe:close() or text == "" then drive.fail("the module of live figures cannot be read: %s", path) end
  return text
end

local function quote(text) return '"' .. text:gsub('[\\"]', "\\%0"):gsub("\n", "\\n") .. '"' end

-- The script of a page that has live figures: the module, those with a student's units, and what runs them.
-- Empty if no page has any. solutions: whether it may show these, or the starters.
function live.script(solutions)
  if next(known) == nil or module == "" then return "" end
  local modules = {"kit: " .. quote(packed(module))}
  for name in pairs(known) do
    local own = os.getenv("RAYKIT_BUILD") .. "/impl/live/" .. name .. ".wasm"
    local file = drive.units ~= "" and io.open(own)
    if file then
      file:close()
      modules[#modules + 1] = name .. ": " .. quote(packed(own))
    end
  end
  local parts = {}
  for name, text in pairs(widgets) do parts[#parts + 1] = name .. ": " .. text end
  table.sort(parts)
  local page = read("make.js") .. read("arguments.js") .. read("converge.js") .. read("pixel_rays.js") ..
    read("numbers.js")
  return "{\n" .. page .. "const figures = " .. read("live.js") ..
    "figures({" .. table.concat(modules, ", ") .. "},\n" ..
    quote(read("run.js") .. read("worker.js")) .. ",\n{" .. table.concat(parts, ", ") .. "},\n" ..
    steps.script(solutions) .. ");\n}\n"
end

return live
