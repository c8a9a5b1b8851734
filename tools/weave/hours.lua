-- The instructor's hours, from the texts themselves: reading from the lines of a chapter, solving from the
-- handout.
--
--   ::: {.hours}
--   :::
-- becomes a table of all chapters.
--
--   [8]{.hours read="parallelogram_light" solve="parallelogram_light/2" between="5 10"}
-- becomes the sum of the hours of chapters to read and of assignments to solve, "/2" of half of one. Weaving
-- stops if
-- it is not between those.

local drive = require("drive")
local fail_at = drive.fail_at

local hours = {}

local lines_per_hour = 150

local function text_of(path)
  local file = assert(io.open(path))
  local text = file:read("a")
  file:close()
  return text
end

-- Of a chapter: title, anchor, number of lines, hours.
local function chapter(element, name)
  local path = drive.list(drive.source, "docs/[0-9][0-9]_" .. name .. ".md")[1]
  if not path then fail_at(element, "there is no chapter docs/NN_%s.md", name) end
  local text = text_of(path)
  local title, anchor = text:match("^# (.-) {#([%w_-]+)}")
  local _, lines = text:gsub("\n", "")
  return {number = path:match("(%d%d)_[^/]*$"), title = title, anchor = anchor, lines = lines,
    hours = math.floor(2 * lines / lines_per_hour + 0.5) / 2}
end

-- Of an assignment, from its handout; nil if the chapter has none.
local function assignment(element, name)
  local path = drive.list(drive.source, "assignments/[0-9][0-9]_" .. name .. "/handout.md")[1]
  if not path then return nil end
  local time = text_of(path):match("%*%*Time:%*%* about ([^.]*)%.")
  local found = time == "half an hour" and 0.5 or time and tonumber(time:match("^(%d+) hours$"))
  if not found then fail_at(element, "%s says nowhere \"**Time:** about ... hours.\"", path) end
  return found
end

local function sum(element, names, of)
  local total = 0
  for word in (names or ""):gmatch("%S+") do
    local name, parts = word:match("^([%w_]+)/?(%d*)$")
    if not name then fail_at(element, "\"%s\" is no name, or a part of one as in bloom/2", word) end
    local found = of(element, name)
    if not found then fail_at(element, "there is no assignment %s", name) end
    total = total + found / (tonumber(parts) or 1)
  end
  return total
end

function hours.span(span)
  local given = span.attributes
  local total = sum(span, given.read, function(element, name) return chapter(element, name).hours end) +
    sum(span, given.solve, assignment)
  local least, most = (given.between or ""):match("^(%d+) (%d+)$")
  if least and (total < tonumber(least) or total > tonumber(most)) then
    fail_at(span, "%.1f hours are not between %s and %s", total, least, most)
  end
  return pandoc.Str(string.format("%.1f", total))
end

function hours.div(div)
  local rows = {"| chapter | lines | reading, hours | assignment, hours | together |",
    "|---|--:|--:|--:|--:|"}
  for _, path in ipairs(drive.list(drive.source, "docs/[0-9][0-9]_*.md")) do
    local name = path:match("%d%d_([%w_]+)%.md$")
    local found, solving = chapter(div, name), assignment(div, name)
    local text = solving and string.format("%d `%s`", tonumber(found.number), name) or found.title
    rows[#rows + 1] = string.format("| [%s](#%s) | %d | %.1f | %s | %.1f |", text, found.anchor,
      found.lines, found.hours, solving and string.format("%.1f", solving) or "",
      found.hours + (solving or 0))
  end
  return pandoc.read(table.concat(rows, "\n") .. "\n", "commonmark_x").blocks[1]
end

return hours
