-- The weaver's base: its parameters from the environment, errors that name the text's file and line
-- (pandoc reads it with the extension sourcepos), and running drivers.

local csv = require("csv")
local rounds = require("rounds")
local store = require("store")

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

-- So does a driver's failure, but with a student's units, or where it draws a user's mesh, it costs only the
-- driver's output: see drive.forgiving.
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
  local made, result = pcall(drive.forgiving, directive, ...)
  draws_users_mesh = false
  if not made then error(result, 0) end
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

drive.answer_of = answer_of

-- Returns a file's contents, or nil where there is none.
drive.read_file = store.read

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

local lists = {} -- of paths, by pattern

-- Paths that fit a shell's pattern. Those in the source tree and the build folder stay as they are: they are
-- asked for once.
function drive.list(folder, pattern)
  local whole = drive.quote(folder) .. "/" .. pattern
  if lists[whole] then return lists[whole] end
  local found = {}
  for path in answer_of("ls -d " .. whole .. " 2>/dev/null || true"):gmatch("[^\n]+") do
    found[#found + 1] = path
  end
  if folder:sub(1, #drive.scraps) ~= drive.scraps then lists[whole] = found end
  return found
end

local paths = {} -- of drivers, by name

local function driver_path(element)
  local name, build = drive.need(element, "driver"), os.getenv("RAYKIT_BUILD")
  if not name:find("^[%w_]+$") then drive.fail_at(element, "there is no driver called %s", name) end
  paths[name] = paths[name] or drive.list(drivers, "assignments/*_" .. name .. "/" .. name)[1] or
    drive.list(build, "tests/stress/" .. name)[1] or drive.list(build, "tools/" .. name .. "/" .. name)[1] or
    drive.fail_at(element, "there is no driver called %s", name)
  return paths[name]
end

-- Its place in the build folder, as a reader starts it. The figures of a pack are drawn by the kit's own
-- drivers; its readers make theirs in impl.
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
    return draws_mistakes == "" and (python == "" and "this build found no Python 3.10 or later." or
      "this pack was made without its book, which would have them.") or nil
  end
  if is_bench(element) then
    return python == "" and "this build found no Python 3.10 or later." or
      drive.units ~= "" and "make bench measures the kit's own units." or nil
  end
  local file = io.open(driver_path(element) .. ".unmade")
  return file and file:read("a"):gsub("%s+$", "") or nil
end

local patience = 120 -- seconds for a driver with a student's units, which may never end
local timed_out = 124 -- timeout's exit status

-- --- jobs ----------------------------------------------------------------------------------------

-- A job is a command that a text asks for: the element, the driver's arguments, and the key of its entry in
-- the store (store.lua). Before the texts are woven, the jobs of all of them are noted, and drive.draw runs
-- those that the store lacks, side by side where nothing is timed.

local record = os.getenv("RAYKIT_RECORD") or ""
local handed_out = drive.source .. "/docs/handout/record" -- a pack's
local measures = (os.getenv("RAYKIT_MEASURED") or "") ~= ""
local here = table.concat({os.getenv("RAYKIT_MACHINE") or "", os.getenv("RAYKIT_ISA") or ""}, " ")

local made, failed = {}, {} -- entries and exit statuses, by key
local placed = {} -- what was printed, by key and folder

-- Whether a run tells times, so that its numbers are rough unless it was alone on the machine.
local function tells_times(element, args)
  return is_bench(element) or args:find("--timing", 1, true) or args:find("--runs ", 1, true) or
    args:find("--convergence", 1, true) or args:find("--efficiency", 1, true)
end

-- The files that decide about what a driver makes.
local function files_of(element, args)
  local stem, build = args:match("%S+"), drivers:gsub("/impl$", "")
  if element.attributes.driver == "wrong" then
    local kit = draws_mistakes:match("'([^']*)/tools/wrong%.py'") or drive.source
    return {kit .. "/tools/wrong.py", kit .. "/tests/mutants/" .. stem .. ".mutants",
      drive.list(kit, "assignments/*_" .. stem .. "/wrong.tsv")[1] or "",
      drive.list(drivers, "assignments/*_" .. stem .. "/" .. stem)[1] or ""}
  end
  return {driver_path(element), build .. "/raykit-mesh", build .. "/raykit-image"}
end

-- Measured anew each time, because they keep their own measurements, or read files that nobody names.
local function is_fresh(element) return is_bench(element) or element.attributes.driver == "compare" end

local function job_of(element, args)
  local driver = drive.need(element, "driver")
  local key = driver .. " " .. args .. (drive.units ~= "" and " with a student's units" or "")
  return {element = element, args = args, key = key, may_fail = drive.units ~= "" or draws_users_mesh}
end

local function digest_of(job)
  job.by = job.by or store.digest(is_fresh(job.element) and {} or files_of(job.element, job.args),
    store.named(job.args), {here})
  return job.by
end

-- A job's entry, from this weaving, the store or a record, or nil.
local function entry_of(job)
  local key = job.key
  if not made[key] and failed[key] == nil then
    made[key] = store.find(record, key) or
      not is_fresh(job.element) and store.find(store.folder, key, digest_of(job)) or
      draws_mistakes == "" and job.element.attributes.driver == "wrong" and store.find(handed_out, key) or nil
  end
  return made[key]
end

local function command_with(job)
  local command = command_of(job.element) .. " " .. job.args .. ' --out "$1"'
  return drive.units ~= "" and "timeout --foreground -k 5 " .. patience .. " " .. command or command
end

local function tell_failure(job)
  if drive.units ~= "" and failed[job.key] == timed_out then
    fail_by_driver(job.element, "this command did not end within %d seconds: %s", patience, command_with(job))
  end
  fail_by_driver(job.element, "this command failed (its reason is above): %s", command_with(job))
end

local told = {} -- what drivers have said, without their names

-- Says on the terminal what a driver has said, and no other has.
function drive.tell(said)
  for line in (said or ""):gmatch("[^\n]+") do
    local sentence = line:gsub("^[%w_]+: ", "")
    if not told[sentence] then io.stderr:write(line, "\n") end
    told[sentence] = true
  end
end

-- Runs jobs, some at a time. A failure ends the weaving, but with a student's units or a user's mesh it is
-- told where the job is wanted.
local function run_jobs(jobs, at_a_time, progress)
  local folder = drive.scraps .. "/jobs"
  os.execute("rm -rf " .. drive.quote(folder) ..
    " && mkdir -p " .. drive.quote(store.folder) .. " " .. drive.quote(folder))
  for n, job in ipairs(jobs) do
    drive.write_file(folder .. "/" .. n, string.format(
      "key=%s\nby=%s\nentry=%s\nforgiving=%s\nrun() {\n%s\n}\n",
      drive.quote(job.key), drive.quote(digest_of(job)), drive.quote(store.path(job.key)),
      job.may_fail and "yes" or "", command_with(job)))
  end
  local pipe = io.popen(string.format("seq %d | xargs -P %d -n 1 sh %s %s", #jobs, at_a_time,
    drive.quote(drive.source .. "/tools/weave/draw.sh"), drive.quote(folder)))
  local first
  for line in pipe:lines() do
    local number, status = line:match("^(%d+) (%d+)$")
    local job = jobs[tonumber(number)]
    progress(job)
    drive.tell(drive.read_file(status == "0" and store.path(job.key) .. "/said" or
      folder .. "/" .. number .. ".said"))
    if status == "0" then made[job.key] = store.find(store.folder, job.key, job.by)
    else failed[job.key], first = tonumber(status), first or not job.may_fail and job or nil end
  end
  local done, how, number = pipe:close()
  if how == "signal" and interruptions[number] then os.exit(130) end
  if first then tell_failure(first) end
  if not done then drive.fail("the drivers were stopped (%s %d)", how, number) end
end

-- --- planning ------------------------------------------------------------------------------------

local plan = nil -- while jobs are noted: {} of lists by kind

local function note(kind, job)
  if entry_of(job) or plan.seen[job.key] then return end
  plan.seen[job.key] = true
  table.insert(plan[kind], job)
end

local function note_all(jobs)
  for _, job in ipairs(jobs) do plan.seen[job.key] = true end
  table.insert(plan.by_turns, jobs)
end

-- Ends a directive that is only to tell what it asks for.
local function noted() error({is_noted = true}) end

-- Calls a directive for the sake of its jobs.
function drive.note(directive, element)
  local done, reason = pcall(directive, element)
  local is_usual = done or type(reason) == "table" and (reason.is_noted or reason.by_driver)
  if not is_usual then error(reason, 0) end
end

-- Calls ask for each item of a list; where jobs are noted, for the sake of these.
function drive.each(list, ask)
  for _, item in ipairs(list) do
    if plan then drive.note(ask, item) else ask(item) end
  end
  if plan then noted() end
end

function drive.begin_plan() plan = {seen = {}, beside = {}, alone = {}, by_turns = {}} end

-- --- running -------------------------------------------------------------------------------------

local printed = {} -- answers to questions that were asked once

-- The answer to a question, asked now or before.
function drive.once(key, ask)
  printed[key] = printed[key] or ask()
  return printed[key]
end

-- In trials at the trial's size unless the text gives one.
local function sized(element, args)
  local driver = element.attributes.driver
  local is_sized = args:find("--width", 1, true) or args:find("--height", 1, true) or is_bench(element) or
    driver == "compare" or driver == "wrong" or driver_path(element):find("/tests/stress/", 1, true)
  return size ~= "" and not is_sized and args .. " --width " .. size .. " --height " .. size or args
end

-- Returns what a job's driver prints; its files go into the folder.
local function place(job, folder)
  local key = job.key .. "\0" .. folder
  if placed[key] then return placed[key] end
  if not entry_of(job) and failed[job.key] == nil then run_jobs({job}, 1, function() end) end
  local entry = entry_of(job)
  if not entry then tell_failure(job) end
  local answer, path = store.place(entry, folder)
  if not answer then drive.fail("%s cannot be written", path) end
  placed[key] = answer
  return answer
end

local function check_made(element)
  if (is_bench(element) or element.attributes.driver == "wrong") and drive.unmade(element) then
    if not plan then drive.say("%s: left out: %s", drive.place(element), drive.unmade(element)) end
    error({by_driver = true})
  end
end

-- A job of a run that tells times: measured alone, if it was or is to be, or else cheaply.
local function measured(job)
  local careful = {element = job.element, args = job.args, key = job.key .. ", measured alone",
    may_fail = job.may_fail, is_careful = true}
  return (measures or entry_of(careful)) and careful or job
end

drive.rough = {} -- tables with times that were taken once, beside other programs

local function mark_rough(entry)
  for name in store.tables(entry) do drive.rough[name] = true end
end

-- Returns the output of an element's driver, and what else it said. Its files go into the common folder, or
-- into `folder`.
function drive.run(element, args, folder)
  local job = job_of(element, folder and args or sized(element, args))
  local is_timed = tells_times(element, args)
  if is_timed and not is_fresh(element) then job = measured(job) end
  if not entry_of(job) then check_made(element) end
  if plan then
    note(is_timed and (job.is_careful or is_fresh(element)) and "alone" or "beside", job)
    noted()
  end
  local answer = place(job, folder or drive.out)
  if is_timed and not job.is_careful then mark_rough(entry_of(job)) end
  return answer, drive.read_file(entry_of(job) .. "/said") or ""
end

-- Measures jobs by turns, and keeps what was measured.
local function measure_by_turns(jobs, progress)
  local function run(job, folder)
    if progress then progress() end
    local command = command_of(job.element) .. " " .. job.args .. " --out " .. drive.quote(folder)
    if not answer_of(command) then
      drive.fail_at(job.element, "this command failed (its reason is above): %s", command)
    end
  end
  for job, tables in pairs(rounds.measure(jobs, tonumber(drive.runs), run, drive.list, drive.scraps)) do
    made[job.key] = store.keep(job.key, digest_of(job), tables) or
      drive.fail("%s cannot be written", store.folder)
  end
end

local on_terminal = (os.getenv("RAYKIT_TERMINAL") or "") ~= ""

local function duration(seconds)
  return seconds < 100 and string.format("%d s", seconds) or string.format("%d min", (seconds + 30) // 60)
end

-- Tells now and then how many of the jobs are done, and the time that is left, if they go on like this.
function drive.progress(count)
  local start, last, done = os.time(), os.time(), 0
  return function()
    done = math.min(done + 1, count)
    local now = os.time()
    if not on_terminal and now - last < 20 or on_terminal and now == last and done < count then return end
    last = now
    local can_tell = done < count and done * 20 >= count and now > start
    local left = can_tell and
      ", about " .. duration((now - start) * (count - done) // done) .. " left" or ""
    local line = string.format("%s: %d of %d commands done%s", drive.page, done, count, left)
    io.stderr:write(on_terminal and "\r\27[K" .. line .. (done == count and "\n" or "") or line .. "\n")
  end
end

local processors = tonumber(os.getenv("RAYKIT_PROCESSORS")) or 1
local most_beside = 8 -- drivers at a time: each uses all processors where it can

-- Runs what was noted.
function drive.draw()
  local beside, alone, by_turns = plan.beside, plan.alone, plan.by_turns
  plan = nil
  local count = #beside + #alone
  for _, jobs in ipairs(by_turns) do count = count + drive.runs * #jobs end -- or more rounds
  local progress = drive.progress(count)
  if #beside > 0 then run_jobs(beside, math.min(processors, most_beside), progress) end
  if #alone > 0 or #by_turns > 0 then drive.say("measuring times, one command after the other") end
  if #alone > 0 then run_jobs(alone, 1, progress) end
  for _, jobs in ipairs(by_turns) do measure_by_turns(jobs, progress) end
  drive.say("%s; making the pages", count > 0 and "all is drawn" or "nothing is to be drawn")
end

-- One configuration's times: those measured by turns, or of one run.
local function time_jobs(element, configurations)
  local careful, left = {}, {}
  for _, args in ipairs(configurations) do
    local job = job_of(element, args .. " " .. drive.timing)
    job.key = job.key .. ", measured by turns"
    careful[#careful + 1] = job
    if not entry_of(job) and not (plan and plan.seen[job.key]) then left[#left + 1] = job end
  end
  return careful, left
end

local function time_all(element, configurations)
  local careful, left = time_jobs(element, configurations)
  local by_turns = measures and drive.units == "" and size == ""
  if by_turns and #left > 0 then
    if plan then note_all(left) else measure_by_turns(left) end
  end
  drive.each(careful, function(job)
    if size == "" and (by_turns or entry_of(job)) then return not plan and place(job, drive.out) end
    return drive.run(element, (job.args:gsub("%S+$", "1")))
  end)
end

local bench_is_quick = false

-- What is said of a measurement that is not the full one, or "".
function drive.reservation(element)
  return is_bench(element) and bench_is_quick and
    "by the quick form of make bench, with small pictures and few samples; " or ""
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
      configurations[#configurations + 1] = target .. " " .. (attributes.args or "") .. " " .. variant
    end
  end
  if options == drive.timing then return time_all(element, configurations) end
  local keep = attributes.keep
  local folder = keep and drive.scraps .. "/" .. keep
  drive.each(configurations, function(args) answer = drive.run(element, args .. " " .. options, folder) end)
  if is_bench(element) then bench_is_quick = answer:find("quick", 1, true) ~= nil end
  if keep then
    local name = drive.need(element, "table")
    local header, rows = csv.read(folder .. "/tables/" .. name .. ".csv")
    if header then csv.write(drive.out .. "/tables/" .. keep .. ".csv", header, rows) end
    drive.rough[keep] = drive.rough[name]
  end
  return answer
end

-- In a round each configuration runs three times.
drive.timing = "--timing --quiet --runs 3"

-- A driver's line of parameters without its times: those of one picture, drawn once, on a busy machine.
function drive.without_times(parameters)
  return (parameters:gsub(", built in [^,]*", ""):gsub(", rendered in [^,]*", ""))
end

-- The command that draws a picture, folded below its caption; with command=open unfolded.
function drive.command(element, args)
  local text = drive.program(element) .. " " .. args
  text = text:gsub("[&<>]", {["&"] = "&amp;", ["<"] = "&lt;", [">"] = "&gt;"})
  text = text:gsub("%-%-[%w-]+", '<span class="tied">%0</span>') -- no line ends within an option
  return pandoc.RawBlock("html",
    '<details class="command"' .. (element.attributes.command == "open" and " open" or "") ..
    "><summary>command</summary><code>" .. text .. "</code></details>")
end

-- The caption of a picture or a table: a text, and in small print its parameters, a text or inlines.
function drive.caption(blocks, small)
  local caption = {pandoc.Plain(pandoc.utils.blocks_to_inlines(blocks))}
  if small then caption[2] = pandoc.Plain({pandoc.Span(small, {class = "parameters"})}) end
  return pandoc.Div(caption, {class = "caption"})
end

return drive
