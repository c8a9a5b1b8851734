-- Finds definitions in our C files by their names: functions, structs, enums and their constants,
-- macros, tests. Returns the block from the comment above it to its closing brace, as .clang-format
-- lays it out: top-level definitions begin and end in the first column. Of the regions that
-- tools/grading/starters.py describes, either the solutions stay or the starters; in a pack for students
-- there are only starters.

local code = {}

local becomes = {
  common = {["/* solution */"] = "solution", ["/* yours to write */"] = "yours"},
  solution = {["/* starter"] = "starter"},
  starter = {["end */"] = "common"},
  yours = {["/* end of yours */"] = "common"},
}
local is_marker = {}
for _, markers in pairs(becomes) do
  for marker in pairs(markers) do is_marker[marker] = true end
end

-- Returns the lines of a file as {number, text, kind} without markers; kind is "common", "solution",
-- "starter" or, in a pack for students, "yours". Or nil and the reason.
local function read_regions(path, label)
  local file = io.open(path)
  if not file then return nil, "there is no file " .. label end
  local lines, state, number = {}, "common", 0
  for text in file:lines() do
    number = number + 1
    local word = text:match("^%s*(.-)%s*$")
    if not is_marker[word] then
      lines[#lines + 1] = {number = number, text = text, kind = state}
    elseif becomes[state][word] then
      state = becomes[state][word]
    else
      file:close()
      return nil, string.format('%s:%d: "%s" stands where "%s" should come', label, number, word,
        (next(becomes[state])))
    end
  end
  file:close()
  if state ~= "common" then
    return nil, string.format('%s: its last region has no "%s"', label, (next(becomes[state])))
  end
  return lines
end

-- All lines of a file as {number, text}; without solutions, starters stand in their places. Or nil and the
-- reason.
function code.lines(path, label, solutions)
  local lines = {}
  if solutions then
    for text in io.lines(path) do lines[#lines + 1] = {number = #lines + 1, text = text} end
    return lines
  end
  local regions, wrong = read_regions(path, label)
  for _, line in ipairs(regions or {}) do
    if line.kind ~= "solution" then lines[#lines + 1] = line end
  end
  return regions and lines, wrong
end

-- The number of braces that a line opens minus those that it closes, outside strings and comments.
local function opened_by(text)
  text = text:gsub("\\.", ""):gsub('"[^"]*"', ""):gsub("'[^']*'", ""):gsub("/%*.-%*/", "")
  local _, opening = text:gsub("{", "")
  local _, closing = text:gsub("}", "")
  return opening - closing
end

-- The last line of the comment, macro or definition that begins in line i.
local function end_of(lines, i)
  local first, open = lines[i].text, 0
  for j = i, #lines do
    local text = lines[j].text
    if first:find("^/%*") then
      if text:find("%*/%s*$") then return j end
    elseif first:find("^#") then
      if not text:find("\\$") then return j end
    else
      open = open + opened_by(text)
      if open == 0 and (text:find(";%s*$") or text:find("^}")) then return j end
    end
  end
  return #lines
end

local function text_of(lines, first, last)
  local list = {}
  for i = first, last do list[#list + 1] = lines[i].text end
  return table.concat(list, "\n")
end

local function defines(block, name)
  local word = name:gsub("%W", "%%%0")
  local head = block:match("^[^{;=]*")
  local before, after = "%f[%w_]" .. word, word .. "%f[^%w_]"
  return head:find(before .. "%s*%(") or head:find(before .. "%s*%[") or head:find(before .. "%s*$") or
    head:find("^#define " .. after) or block:find("\n} " .. word .. ";%s*$") or
    (head:find("^enum") and block:find("%f[%w_]" .. after))
end

-- A definition's head in one line, without its body.
local function signature(lines, first, last)
  local text = text_of(lines, first, last)
  if text:find("^#") then return text:match("^[^\n]*[^\n\\]") end
  return (text:match("^[^{;=]*"):gsub("%s+", " "):gsub(" $", ""))
end

-- Returns {text, line, numbers, signature, own, later} of a definition: its text, the number of the line
-- where it begins (not its comment), the numbers of all its lines, its head, whether it shows a starter,
-- the student's to solve, and whether that is not asked for yet. Or nil and the reason.
-- solutions: whether to show these, or the starters instead.
function code.find(path, label, name, solutions)
  local all, wrong = read_regions(path, label)
  if not all then return nil, wrong end
  local lines = {}
  for _, line in ipairs(all) do
    local hidden = solutions and "starter" or "solution"
    if line.kind ~= hidden then lines[#lines + 1] = line end
  end
  local found, i, comment = {}, 1, nil
  while i <= #lines do
    local text, last = lines[i].text, end_of(lines, i)
    if text:find("^%s*$") then
      comment, last = nil, i
    elseif text:find("^/%*") then
      comment = comment or i
    else
      if defines(text_of(lines, i, last), name) then
        found[#found + 1] = {first = comment or i, begin = i, last = last}
      end
      comment = nil
    end
    i = last + 1
  end
  local best
  for _, block in ipairs(found) do -- a definition counts for more than its declaration
    if #found == 1 or text_of(lines, block.begin, block.last):find("{") then
      if best then
        return nil, string.format("%s defines %s twice, in lines %d and %d", label, name,
          lines[best.begin].number, lines[block.begin].number)
      end
      best = block
    end
  end
  if not best then return nil, string.format("%s defines no %s", label, name) end
  local own, numbers = false, {}
  for i = best.first, best.last do
    own = own or lines[i].kind == "starter" or lines[i].kind == "yours"
    numbers[#numbers + 1] = lines[i].number
  end
  return {text = text_of(lines, best.first, best.last), line = lines[best.begin].number, numbers = numbers,
    signature = signature(lines, best.begin, best.last), own = own,
    later = all[1].text:find("^/%* Left open: ") ~= nil}
end

-- Returns the names of a suite's tests in its order, or nil and the reason.
function code.tests(path, label)
  local block, wrong = code.find(path, label, "tests", true)
  if not block then return nil, wrong end
  local names = {}
  for name in block.text:gmatch("cmocka_unit_test%(([%w_]+)%)") do names[#names + 1] = name end
  return names
end

return code
