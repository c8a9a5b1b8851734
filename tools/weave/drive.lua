-- The weaver's base: its parameters from the environment, errors that name the text's file and line
-- (pandoc reads it with the extension sourcepos), and running drivers.

local csv = require("csv")
local rounds = require("rounds")

local drive = {
  page = os.getenv("RAYKIT_WEAVES"),
  source = os.getenv("RAYKIT_SOURCE"),
  out = os.getenv("RAYKIT_OUT"),
  scraps = os.getenv("RAYKIT_SCRAPS"),
  runs = os.getenv("RAYKIT_RUNS"),
  units = os.getenv("RAYKIT_UNITS") or "",
}
local drivers = os.getenv("RAYKIT_DRIVERS")
local size = os.getenv("RAYKIT_SIZE") or ""

function drive.say(...) io.stderr:write(drive.page, ": ", string.format(...), "\n") end

function drive.fail(...)
  drive.say(...)
  os.exit(1)
end

-- An element's position, such as "docs/01_bvh_median.md:12".
function drive.place(element)
  local file, line = (element.attributes["data-pos"] or ""):match("^(.-)@(%d+):")
  if not file then return "a text" end
  if file:sub(1, #drive.source + 1) == drive.source .. "/" then file = file:sub(#drive.source + 2) end
  return file .. ":" .. line
end

-- A text's mistake ends the weaving.
function drive.fail_at(element, ...)
  drive.fail("%s: %s", drive.place(element), string.format(...))
end

local draws_users_mesh = false

-- So does a driver's failure, but with a student's units, or where it draws a user's mesh, it costs only the driver's
-- output: see drive.forgiving.
local function fail_by_driver(element, ...)
  if drive.units == "" and not draws_users_mesh then drive.fail_at(element, ...) end
  drive.say("%s: %s", drive.place(element), string.format(...))
  error({by_driver = true})
end
drive.fail_by_driver = fail_by_driver

-- Returns a directive's result for an element, or nil if a student's units failed.
function drive.forgiving(directive, ...)
  local made, result = pcall(directive, ...)
  if made then return result end
  if type(result) ~= "table" or not result.by_driver then error(result, 0) end
  return nil
end

-- The same where it draws a user's mesh.
function drive.forgiving_mesh(directive, ...)
  draws_users_mesh = true
  local result = drive.forgiving(directive, ...)
  draws_users_mesh = false
  return result
end

-- A directive's mandatory attribute.
function drive.need(element, key)
  local value = element.attributes[key]
  if not value or value == "" then
    drive.fail_at(element, ".%s needs %s=...", element.classes[1], key)
  end
  return value
end

function drive.words(text)
  local list = {}
  for word in (text or ""):gmatch("%S+") do list[#list + 1] = word end
  return list
end

-- The paths of MESHES, which weave.sh has put on a line each.
drive.meshes = {}
for path in (os.getenv("MESHES") or ""):gmatch("[^\n]+") do drive.meshes[#drive.meshes + 1] = path end

function drive.quote(word) return "'" .. word:gsub("'", "'\\''") .. "'" end

-- SIGHUP, SIGINT and SIGTERM: the whole weaving is to end.
local interruptions = {[1] = true, [2] = true, [15] = true}

-- Runs a command and returns its output, or nil and its exit status.
local function answer_of(command)
  local pipe = io.popen(command, "r")
  local answer = pipe:read("a")
  local done, how, number = pipe:close()
  local signal = how == "signal" and number or number - 128 -- the shell's way to tell of it
  if interruptions[signal] then os.exit(130) end
  if done then return answer end
  return nil, number
end

-- Returns a file's contents, or nil where there is none.
function drive.read_file(path)
  local file = io.open(path, "rb")
  if not file then return nil end
  local text = file:read("a")
  file:close()
  return text
end

function drive.write_file(path, text)
  local file, wrong = io.open(path, "wb")
  if not file or not file:write(text) or not file:close() then
    drive.fail("%s cannot be written: %s", path, wrong or "no space is left")
  end
end

function drive.exists(path)
  local file = io.open(path)
  return file and file:close()
end

-- Paths in the source tree and the build folder that fit a shell's pattern.
function drive.list(folder, pattern)
  local list = answer_of("ls -d " .. drive.quote(folder) .. "/" .. pattern .. " 2>/dev/null || true")
  local paths = {}
  for path in list:gmatch("[^\n]+") do paths[#paths + 1] = path end
  return paths
end

local function driver_path(element)
  local name = drive.need(element, "driver")
  if not name:find("^[%w_]+$") then drive.fail_at(element, "there is no driver called %s", name) end
  return drive.list(drivers, "assignments/*_" .. name .. "/" .. name)[1] or
    drive.list(os.getenv("RAYKIT_BUILD"), "tests/stress/" .. name)[1] or
    drive.list(os.getenv("RAYKIT_BUILD"), "tools/" .. name .. "/" .. name)[1] or
    drive.fail_at(element, "there is no driver called %s", name)
end

-- Its place in the build folder, as a reader starts it. The figures of a pack are drawn by the kit's own drivers; its
-- readers make theirs in impl.
function drive.program(element)
  local path, build = driver_path(element), os.getenv("RAYKIT_BUILD") .. "/"
  return path:sub(1, #build) == build and path:sub(#build + 1) or "impl/" .. path:sub(#drivers + 2)
end

-- What it prints about its options.
function drive.help(element) return answer_of(drive.quote(driver_path(element)) .. " --help") or "" end

-- The program of make bench is used like a driver.
local function is_bench(element) return element.attributes.driver == "bench" end
local python = os.getenv("RAYKIT_PYTHON") or ""

local draws_mistakes = os.getenv("RAYKIT_WRONG") or ""

local function command_of(element)
  if element.attributes.driver == "wrong" then return draws_mistakes end
  if not is_bench(element) then return drive.quote(driver_path(element)) end
  return drive.quote(python) .. " -B " .. drive.quote(drive.source .. "/tools/bench.py") ..
    " --build " .. drive.quote(drivers)
end

-- The reason why there is no such driver, or nil: a student's unit could not be built into it.
function drive.unmade(element)
  if element.attributes.driver == "wrong" then
    return draws_mistakes == "" and (python == "" and "this build found no Python 3." or
      "this pack was made without its book, which would have them.") or nil
  end
  if is_bench(element) then
    return python == "" and "this build found no Python 3." or
      drive.units ~= "" and "make bench measures the kit's own units." or nil
  end
  local file = io.open(driver_path(element) .. ".unmade")
  return file and file:read("a"):gsub("%s+$", "") or nil
end

local patience = 120 -- seconds for a driver with a student's units, which may never end
local timed_out = 124 -- timeout's exit status
local printed = {} -- by driver and arguments: what was measured once is not measured again

-- What drivers printed while an earlier page was woven, by driver and arguments. weave.sh has put the
-- pictures and tables of that page into the folder of this one.
local function read_record(folder)
  local record = {answers = {}}
  if folder ~= "" then
    local load_record, wrong = loadfile(folder .. "/record.lua", "t", record)
    if not load_record then drive.fail("%s: %s", folder, wrong) end
    load_record()
  end
  return record.answers
end

local recorded = read_record(os.getenv("RAYKIT_RECORD") or "")

-- A pack has no mistakes to draw; weave.sh has put its book's pictures of them into the page's folder.
local handed_out = drive.source .. "/docs/handout/record"
local handed_file = draws_mistakes == "" and io.open(handed_out .. "/record.lua")
if handed_file then
  handed_file:close()
  for key, answer in pairs(read_record(handed_out)) do
    if key:find("^wrong ") then recorded[key] = recorded[key] or answer end
  end
end

-- Adds an answer to this page's own record; the folder's place in it stays open.
local function write_record(key, answer, folder)
  local file = io.open(drive.out .. "/record.lua", "a")
  local open = answer:gsub(folder:gsub("%W", "%%%0"), "{folder}")
  file:write(string.format("answers[%q] = %q\n", key, open))
  file:close()
end

-- The answer to a question, from the record or asked now.
function drive.once(key, ask)
  local answer = printed[key] or recorded[key] or ask()
  if not printed[key] then write_record(key, answer, drive.out) end
  printed[key] = answer
  return answer
end

-- Runs a driver and returns its output.
local function run_driver(element, args, folder)
  if (is_bench(element) or element.attributes.driver == "wrong") and drive.unmade(element) then
    drive.say("%s: left out: %s", drive.place(element), drive.unmade(element))
    error({by_driver = true})
  end
  local command = command_of(element) .. " " .. args .. " --out " .. drive.quote(folder)
  if drive.units ~= "" then command = "timeout --foreground -k 5 " .. patience .. " " .. command end
  drive.say("%s %s", element.attributes.driver, args)
  local answer, status = answer_of(command)
  if not answer and drive.units ~= "" and status == timed_out then
    fail_by_driver(element, "this command did not end within %d seconds: %s", patience, command)
  elseif not answer then
    fail_by_driver(element, "this command failed (its reason is above): %s", command)
  end
  return answer
end

-- Returns the output of an element's driver, run now or for the record. Its files go into the common
-- folder, in trials at the trial's size unless the text gives one; or into `folder`, unchanged.
function drive.run(element, args, folder)
  local driver = element.attributes.driver
  local sized = args:find("--width", 1, true) or args:find("--height", 1, true) or is_bench(element) or
    driver == "compare" or driver == "wrong" or driver_path(element):find("/tests/stress/", 1, true)
  if size ~= "" and not folder and not sized then args = args .. " --width " .. size .. " --height " .. size end
  folder = folder or drive.out
  local key = drive.need(element, "driver") .. " " .. args
  if printed[key] then return printed[key] end
  local answer = recorded[key] and recorded[key]:gsub("{folder}", (folder:gsub("%%", "%%%%"))) or
    run_driver(element, args, folder)
  write_record(key, answer, folder)
  printed[key] = answer
  return answer
end

-- Timings of configurations that were not measured before, by turns.
local function measure_by_turns(element, configurations)
  local left = {}
  for _, args in ipairs(configurations) do
    local key = drive.need(element, "driver") .. " " .. args
    if printed[key] or recorded[key] then drive.run(element, args) else left[#left + 1] = args end
  end
  if #left == 0 then return end
  local done, reason = rounds.measure(left, tonumber(drive.runs),
    function(args, folder) run_driver(element, args, folder) end, drive.list, drive.scraps, drive.out)
  if not done then drive.fail("%s", reason) end
  for _, args in ipairs(left) do
    local key = element.attributes.driver .. " " .. args
    write_record(key, "", drive.out)
    printed[key] = ""
  end
end

local bench_is_quick = false

-- What is said of a measurement that is not the full one, or "".
function drive.reservation(element)
  return is_bench(element) and bench_is_quick and "by the quick form of make bench, with small pictures and few samples; " or ""
end

-- Runs the driver on each of the element's scenes, and on each mesh if these count, too; once without
-- and once with each of the variants. Its measurements go to its CSV file. Returns what it printed last.
function drive.measure(element, options, with_meshes)
  local attributes, targets, variants = element.attributes, {}, {""}
  for variant in (attributes.variants or ""):gmatch("[^,]+") do variants[#variants + 1] = variant end
  for _, scene in ipairs(drive.words(attributes.scenes)) do targets[#targets + 1] = "--scene " .. scene end
  for _, mesh in ipairs(with_meshes and drive.meshes or {}) do
    targets[#targets + 1] = "--mesh " .. drive.quote(mesh)
  end
  if #targets == 0 then targets[1] = "" end
  local configurations, answer = {}, nil
  for _, target in ipairs(targets) do
    for _, variant in ipairs(variants) do
      configurations[#configurations + 1] = target .. " " .. (attributes.args or "") .. " " .. variant .. " " .. options
    end
  end
  if options == drive.timing and drive.runs ~= "1" then return measure_by_turns(element, configurations) end
  local keep = attributes.keep
  local folder = keep and drive.scraps .. "/" .. keep
  for _, args in ipairs(configurations) do answer = drive.run(element, args, folder) end
  if is_bench(element) then bench_is_quick = answer:find("quick", 1, true) ~= nil end
  if keep then
    local header, rows = csv.read(folder .. "/tables/" .. drive.need(element, "table") .. ".csv")
    if header then csv.write(drive.out .. "/tables/" .. keep .. ".csv", header, rows) end -- else it is on record
  end
  return answer
end

-- In a round each configuration runs three times.
drive.timing = "--timing --quiet --runs " .. (drive.runs == "1" and 1 or 3)

-- A driver's line of parameters without its times: those of one picture, drawn once, on a busy machine.
function drive.without_times(parameters)
  return (parameters:gsub(", built in [^,]*", ""):gsub(", rendered in [^,]*", ""))
end

-- The command that draws a picture, folded below its caption.
function drive.command(element, args)
  local text = (drive.program(element) .. " " .. args):gsub("[&<>]", {["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;"})
  text = text:gsub("%-%-[%w-]+", '<span class="tied">%0</span>') -- no line ends within an option
  return pandoc.RawBlock("html", '<details class="command"><summary>command</summary><code>' .. text .. "</code></details>")
end

-- The caption of a picture or a table: a text, and in small print its parameters, a text or inlines.
function drive.caption(blocks, small)
  local caption = {pandoc.Plain(pandoc.utils.blocks_to_inlines(blocks))}
  if small then caption[2] = pandoc.Plain({pandoc.Span(small, {class = "parameters"})}) end
  return pandoc.Div(caption, {class = "caption"})
end

return drive
