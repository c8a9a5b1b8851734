-- The code of the steps that explain a pixel: the functions and lines of src/driver/pixel_code.c, as texts
-- that a live figure shows. A line that its function no longer has stops the weaver.

local code = require("code")
local drive = require("drive")

local steps = {}

local function quote(text)
  return '"' .. text:gsub('[\\"]', "\\%0"):gsub("\n", "\\n"):gsub("</", "<\\/") .. '"'
end

-- The index of the only line with this part; a starter need not have it.
local function line_with(part, text, place, solutions)
  local found, count = nil, 0
  for line in (text .. "\n"):gmatch("(.-)\n") do
    count = count + 1
    if line:find(part, 1, true) then
      if found then drive.fail("src/driver/pixel_code.c: %s has '%s' twice", place, part) end
      found = count
    end
  end
  if not found and solutions then drive.fail("src/driver/pixel_code.c: %s has no '%s'", place, part) end
  return found or 1
end

-- {"FILE, FUNCTION: LINE": {text, numbers, now}}: the function's lines, their numbers in the file, and which
-- it is.
function steps.script(solutions)
  local table_text, parts = drive.read_file(drive.source .. "/src/driver/pixel_code.c"), {}
  for name, place, part in table_text:gmatch('{"(src/[^"]*)", "([^"]*)", "([^"]*)"}') do
    local found, wrong = code.find(drive.source .. "/" .. name, name, place, solutions)
    if not found then drive.fail("src/driver/pixel_code.c: %s", wrong) end
    local title = name .. ", " .. place
    parts[#parts + 1] = string.format('%s: {text: %s, numbers: [%s], now: %d}',
      quote(title .. ": " .. part), quote(found.text), table.concat(found.numbers, ","),
      line_with(part, found.text, title, solutions) - 1)
  end
  return "{" .. table.concat(parts, ",\n") .. "}"
end

return steps
