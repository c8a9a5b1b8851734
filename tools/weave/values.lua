-- Sentences about numbers, checked against the tables of the same page: values get names, and sentences
-- and numbers are expressions of these.
--
--   ``` {.values driver=bloom args="--errors --runs 5" table=bloom_errors}
--   exact = milliseconds where method=exact radius=15
--   pyramid = milliseconds where method=pyramid radius=15
--   ```
-- names cells of tables/bloom_errors.csv: a column, and what the cell's row must have in others, with _ for a
-- space. "largest milliseconds where ..." and "least ..." choose from several rows, "slope of rmse over
-- samples where ..." is that of a straight line through their logarithms, from 4 samples on. where=... holds
-- for all lines of the block. A driver runs as for .table, with timings=yes as for .timings. Nothing of the
-- block is shown. With optional=yes rows may be missing, of an instruction set that the machine lacks for
-- instance; their sentences are not judged.
--
--   [At this radius the pyramid is slower]{.check that="pyramid > exact"}
-- stays as it is. If the numbers say otherwise the page marks it, with the numbers, and making the page fails
-- (weave.sh), though the page is there: another machine may measure otherwise. Of times that were measured
-- once (without MEASURED=1) the page only says so. Quick trials (a quick make bench,
-- too) and students' units are not judged, but the expression must have a value.
--
--   [1.5]{.value is="pyramid / exact" digits=2}
-- becomes the number, with that many significant digits (2).
--
-- A number of .measured has the name that it gets by name=...
--
--   [1 + 2 + 4 is 7]{.worked that="1 + 2 + 4 == 7"}
-- is the arithmetic of an example worked by hand, without names. It stays as it is, and is always judged.
--
--   [In a shadow, it is `occluded`]{.printed driver=shading args="--shadows" runs="--pixel 3,4; --pixel 5,6"
--     prints="occluded; hit triangle 9" lacks="no hit"}
-- is a sentence about what the driver prints, by args and each of the runs: all of prints, nothing of lacks,
-- whatever the spaces. It stays as it is, and is always judged, except with a student's units.
--
-- Expressions are Lua's, with the names, and min, max, abs and sqrt. Lua's numbers are C's: 2^53 is a double,
-- and ~ between whole numbers is xor.

local drive = require("drive")
local fit = require("fit")
local tables = require("tables")
local fail_at, need = drive.fail_at, drive.need

local values = {}

local rough = {} -- names whose values are from a quick make bench, or times that were measured once
local named = {} -- numbers, or false where there is none
local named_at = {} -- places, by name

-- A cell's number, without its interval: 4.05 of "4.05 ± 0.21".
local function number(block, row, column)
  return tonumber((row[column] or ""):match("^(%S+) ±") or row[column]) or
    drive.fail_by_driver(block, "%s is not a number: %s", column, row[column])
end

local function extreme(choose)
  return function(block, rows, column)
    local found = number(block, rows[1], column)
    for _, row in ipairs(rows) do found = choose(found, number(block, row, column)) end
    return found
  end
end

local function slope(block, rows, column, over)
  local points = {}
  for _, row in ipairs(rows) do
    local x = number(block, row, over)
    if over ~= "samples" or x >= fit.from then points[#points + 1] = {x, number(block, row, column)} end
  end
  return fit.slope(points) or
    drive.fail_by_driver(block, "slope of %s over %s: %d rows are selected in place of two or more", column,
      over, #points)
end

local function cell(block, rows, column)
  if #rows ~= 1 then
    drive.fail_by_driver(block, "%s: %d rows are selected in place of one", column, #rows)
  end
  return number(block, rows[1], column)
end

-- Kinds of values, by the pattern of what stands before "where".
local kinds = {
  {"^([%w_]+)$", cell},
  {"^largest ([%w_]+)$", extreme(math.max)},
  {"^least ([%w_]+)$", extreme(math.min)},
  {"^slope of ([%w_]+) over ([%w_]+)$", slope},
}

local function value_of(block, kind, column, over, where)
  local rows, columns = tables.read(block, (block.attributes.where or "") .. " " .. where)
  column, over = tables.column(block, columns, column), over and tables.column(block, columns, over)
  if #rows == 0 and block.attributes.optional then return false end
  if #rows == 0 then
    drive.fail_by_driver(block, "tables/%s.csv has no row where %s", tables.name(block), where)
  end
  return kind(block, rows, column, over), tables.has_rough(block, rows, {column, over})
end

local function claim(element, name, is_rough)
  if named_at[name] then fail_at(element, "the value %s is named in %s already", name, named_at[name]) end
  named_at[name], named[name], rough[name] = drive.place(element), false, is_rough
end

tables.on_name = function(span, name, number, is_rough)
  claim(span, name, is_rough)
  named[name] = number
end

local function define_line(block, line, is_rough)
  local name, what = line:match("^([%a_][%w_]*) = (.+)$")
  local where = what and what:match(" where (.+)$") or ""
  what = what and what:gsub(" where .+$", "")
  for _, kind in ipairs(what and kinds or {}) do
    local column, over = what:match(kind[1])
    if column then
      claim(block, name, is_rough)
      local is_time
      named[name], is_time = value_of(block, kind[2], column, over, where)
      rough[name] = rough[name] or is_time
      return
    end
  end
  fail_at(block, "this line is not name = column where ...: %s", line)
end

local function define_lines(block)
  local attributes = block.attributes
  if attributes.driver then drive.measure(block, attributes.timings and drive.timing or "--quiet") end
  local is_rough = drive.reservation(block) ~= ""
  for line in block.text:gmatch("[^\n]+") do define_line(block, line, is_rough) end
  return {}
end

local function define(block)
  if block.classes[1] ~= "values" then return nil end
  return drive.forgiving(define_lines, block) or {}
end

function values.note(block)
  if block.classes[1] == "values" and block.attributes.driver then drive.note(define_lines, block) end
end

-- Names of an expression and what they stand for, "exact = 1.31, pyramid = 2.4".
local function list(used)
  local parts = {}
  for name in pairs(used) do parts[#parts + 1] = string.format("%s = %.4g", name, named[name]) end
  table.sort(parts)
  return table.concat(parts, ", ")
end

local functions = {min = math.min, max = math.max, abs = math.abs, sqrt = math.sqrt}

-- An expression's result; other names than these functions' are looked up.
local function run(span, expression, look_up)
  local names = setmetatable({}, {__index = function(_, name) return functions[name] or look_up(name) end})
  local chunk, wrong = load("return " .. expression, "expression", "t", names)
  if not chunk then fail_at(span, "this is not an expression: %s (%s)", expression, wrong) end
  local done, result = pcall(chunk)
  if not done then fail_at(span, "%s: %s", expression, result) end
  return result
end

-- An expression's result, and the names that it uses; nil if one of these has no value.
local function evaluate(span, expression)
  local used, missing = {}, false
  local result = run(span, expression, function(name)
    if not named_at[name] then fail_at(span, "no value is called %s", name) end
    if not named[name] then missing = true else used[name] = true end
    return named[name] or 0
  end)
  if next(used) == nil and not missing then fail_at(span, "%s has no value in it", expression) end
  if missing then return nil end
  return result, used
end

local function is_rough(used)
  for name in pairs(used) do
    if rough[name] then return true end
  end
  return false
end

local verdicts, sections = {}, pandoc.List() -- by text, in their order

-- Counts a sentence, and notes what is wrong with it.
local function judge(span, verdict, reason)
  local file = drive.place(span):match("^[^:]*")
  if not verdicts[file] then
    verdicts[file] = {holds = 0, waits = 0, wrong = pandoc.List()}
    sections:insert(file)
  end
  if reason then verdicts[file].wrong:insert(drive.place(span) .. ": " .. reason)
  else verdicts[file][verdict] = verdicts[file][verdict] + 1 end
end

-- A line for each section; the wrong sentences at the end of theirs. weave.sh prints it last, and fails if
-- there are any.
local function write_verdict()
  local lines, wrong = pandoc.List(), 0
  for _, file in ipairs(sections) do
    local of, parts = verdicts[file], pandoc.List()
    if of.holds > 0 then
      parts:insert(of.holds .. (of.holds == 1 and " sentence holds" or " sentences hold"))
    end
    if of.waits > 0 then parts:insert(of.waits .. " not judged, because their times were measured once") end
    if #of.wrong > 0 then parts:insert(#of.wrong .. (#of.wrong == 1 and " FAILS:" or " FAIL:")) end
    lines:insert(file .. ": " .. table.concat(parts, ", "))
    lines:extend(of.wrong)
    wrong = wrong + #of.wrong
  end
  if #lines > 0 then drive.write_file(drive.scraps .. "/verdict", table.concat(lines, "\n") .. "\n") end
  if wrong > 0 then drive.write_file(drive.scraps .. "/wrong", wrong .. "\n") end
end

-- A sentence that the numbers contradict: marked, and if it is judged, a reason to fail.
local function contradicted(span, title, numbers, is_judged)
  local note = is_judged and " (not here: " or " (measured once here, and not so: "
  local content = span.content .. {pandoc.Span(note .. numbers .. ")", {class = "parameters"})}
  return pandoc.Span(content, {class = is_judged and "checked wrong" or "checked", title = title})
end

local function check(span)
  local that = need(span, "that")
  local holds, used = evaluate(span, that)
  if drive.units ~= "" or holds == nil then return span.content end
  if type(holds) ~= "boolean" then fail_at(span, "%s is neither true nor false", that) end
  local is_trial, is_judged, numbers = drive.runs == "1", not is_rough(used), list(used)
  local title = that .. ": " .. numbers .. (is_judged and "" or "; measured once")
  if not is_trial then
    judge(span, is_judged and "holds" or "waits", is_judged and not holds and
      string.format('the numbers say otherwise: "%s" needs %s, but %s',
        pandoc.utils.stringify(span.content), that, numbers) or nil)
  end
  if holds or is_trial then
    return pandoc.Span(span.content, {class = "checked", title = title, tabindex = "0"})
  end
  return contradicted(span, title, numbers, is_judged)
end

-- An example worked by hand, which depends on no measurement.
local function worked(span)
  local that = need(span, "that")
  local result = run(span, that, function(name) fail_at(span, "%s: a worked example has no names", name) end)
  if type(result) ~= "boolean" then fail_at(span, "%s is neither true nor false", that) end
  judge(span, "holds", not result and
    string.format('"%s" needs %s', pandoc.utils.stringify(span.content), that) or nil)
  return result and span.content or contradicted(span, that, that, true)
end

-- What lies between semicolons; one empty text where there is nothing.
local function list_of(text)
  local parts = pandoc.List()
  for part in ((text or "") .. ";"):gmatch("%s*(.-)%s*;") do parts:insert(part) end
  return parts
end

-- Why a run's output contradicts a sentence, or nil.
local function contradiction(span, text, command)
  for attribute, no in pairs({prints = "", lacks = "no "}) do
    for _, part in ipairs(span.attributes[attribute] and list_of(span.attributes[attribute]) or {}) do
      if (text:find(part, 1, true) == nil) == (no == "") then
        return string.format('needs %s"%s" in the output of: %s', no, part, command)
      end
    end
  end
end

function values.printed(span)
  local a, wrong = span.attributes, nil
  if not a.prints and not a.lacks then fail_at(span, '.printed needs prints="..." or lacks="..."') end
  if drive.units ~= "" then return span.content end
  drive.each(list_of(a.runs), function(run)
    local args = ((a.args or "") .. " " .. run):gsub("%s+$", "")
    local text = drive.run(span, args .. " --quiet", drive.scraps):gsub("%s+", " ")
    wrong = wrong or contradiction(span, text, a.driver .. " " .. args)
  end)
  judge(span, "holds", wrong and string.format('"%s" %s', pandoc.utils.stringify(span.content), wrong) or nil)
  if wrong then return contradicted(span, wrong, wrong, true) end
  return pandoc.Span(span.content, {class = "checked", title = "printed by " .. a.driver, tabindex = "0"})
end

local function value(span)
  local result, used = evaluate(span, need(span, "is"))
  if not result then return pandoc.Emph("not measured here") end
  if type(result) ~= "number" then fail_at(span, "%s is not a number", span.attributes.is) end
  return tables.roughly(drive.runs ~= "1" and is_rough(used),
    tables.show(result, tonumber(span.attributes.digits or 2)))
end

-- Classes that other filters leave alone.
values.spans = {check = check, value = value, worked = worked}

-- To be run after the directives, by which tables are made.
values.filters = {
  {CodeBlock = define},
  {Span = function(span)
    local directive = values.spans[span.classes[1]]
    return directive and directive(span)
  end},
  {Pandoc = write_verdict},
}

return values
