-- Finds definitions in our C files by their names: functions, structs, enums and their constants,
-- macros, tests. Returns the block from the comment above it to its closing brace, as .clang-format
-- lays it out: top-level definitions begin and end in the first column. Of the regions that
-- tools/grading/starters.py describes, either the solutions stay or the starters; if both are the same,
-- in a pack for students, there is only a starter.

local code = {}

local follows = {common = "/* solution */", solution = "/* starter", starter = "end */"}
local becomes = {["/* solution */"] = "solution", ["/* starter"] = "starter", ["end */"] = "common"}

-- Removes the solution from a region, from lines[first] on, whose two halves are equal; the other half
-- gets the kind "handed out".
local function merge_halves(lines, first)
  local half = (#lines - first + 1) // 2
  for i = first, first + half - 1 do
    local other = lines[i + half]
    if lines[i].kind ~= "solution" or other.kind ~= "starter" or lines[i].text ~= other.text then return end
  end
  if first + 2 * half <= #lines then return end
  for i = first, first + half - 1 do
    lines[i].kind, lines[#lines] = "handed out", nil
  end
end

-- Returns the lines of a file as {number, text, kind} without markers; kind is "common", "solution",
-- "starter" or "handed out". Or nil and the reason.
local function read_regions(path, label)
  local file = io.open(path)
  if not file then return nil, "there is no file " .. label end
  local lines, state, number, first = {}, "common", 0, 1
  for text in file:lines() do
    number = number + 1
    local marker = becomes[text:match("^%s*(.-)%s*$")] and text:match("^%s*(.-)%s*$")
    if not marker then
      lines[#lines + 1] = {number = number, text = text, kind = state}
    elseif marker == follows[state] then
      if state == "common" then first = #lines + 1 end
      state = becomes[marker]
      if state == "common" then merge_halves(lines, first) end
    else
      file:close()
      return nil, string.format('%s:%d: "%s" stands where "%s" should come', label, number, marker,
        follows[state])
    end
  end
  file:close()
  if state ~= "common" then
    return nil, string.format('%s: its last region has no "%s"', label, follows[state])
  end
  return lines
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

-- Returns {text, line, own} of a definition: its text, the number of the line where it begins (not
-- its comment), and whether it shows a starter, the student's to solve. Or nil and the reason.
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
  local own = false
  for i = best.first, best.last do own = own or lines[i].kind == "starter" or lines[i].kind == "handed out" end
  return {text = text_of(lines, best.first, best.last), line = lines[best.begin].number, own = own}
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
