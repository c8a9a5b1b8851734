-- Timings by turns. Drivers run in rounds, each configuration once per round, so that a slow phase of the
-- machine hits all configurations and not one. The page's tables get the medians of the rounds, the least and
-- the largest. While some time differs by more than a fifth, up to as many rounds follow as were planned.

local csv = require("csv")

local rounds = {}

rounds.tolerated = 0.2 -- (largest - least) / median

local function place_of_median(header)
  for i, column in ipairs(header) do
    if column == "median" then return i end
  end
end

-- Adds the medians of a round's tables to those measured so far, by table and by what stands before the median.
local function collect(measured, folder, list)
  for _, path in ipairs(list(folder, "tables/*.csv")) do
    local name, header, rows = path:match("[^/]+$"), csv.read(path)
    local at = header and place_of_median(header)
    if at then
      measured[name] = measured[name] or {header = header, at = at, keys = {}, times = {}}
      local all = measured[name]
      for _, row in ipairs(rows) do
        local key = table.concat(row, "\0", 1, at - 1)
        if not all.times[key] then
          all.times[key], all.keys[#all.keys + 1] = {}, key
        end
        table.insert(all.times[key], tonumber(row[at]))
      end
    end
  end
end

local function median(times)
  local n = #times
  return (times[(n + 1) // 2] + times[n // 2 + 1]) / 2
end

local function is_steady(measured)
  for _, all in pairs(measured) do
    for _, times in pairs(all.times) do
      table.sort(times)
      if times[#times] - times[1] > rounds.tolerated * median(times) then return false end
    end
  end
  return true
end

local function row_of(all, key)
  local row, times = {}, all.times[key]
  for cell in (key .. "\0"):gmatch("(.-)%z") do row[#row + 1] = cell end
  table.sort(times)
  for _, time in ipairs({median(times), times[1], times[#times]}) do row[#row + 1] = string.format("%.6g", time) end
  row[#row + 1] = tostring(#times)
  return row
end

-- Puts the rows into the page's table, in the place of older ones of the same key.
local function put(all, path)
  local header, rows = csv.read(path)
  header, rows = header or all.header, header and rows or {}
  local place = {}
  for i, row in ipairs(rows) do place[table.concat(row, "\0", 1, all.at - 1)] = i end
  for _, key in ipairs(all.keys) do rows[place[key] or #rows + 1] = row_of(all, key) end
  return csv.write(path, header, rows)
end

-- Runs each of the configurations by run(args, folder), in rounds with folders below `scraps`, and puts the
-- times into the tables in `out`. list(folder, pattern) lists files. Returns false and a reason if a table cannot be written.
function rounds.measure(configurations, planned, run, list, scraps, out)
  local measured = {}
  for round = 1, 2 * planned do
    local folder = os.tmpname()
    os.remove(folder)
    folder = scraps .. "/" .. folder:match("[^/]+$")
    for _, args in ipairs(configurations) do run(args, folder) end
    collect(measured, folder, list)
    if round >= planned and is_steady(measured) then break end
  end
  for name, all in pairs(measured) do
    local done, reason = put(all, out .. "/tables/" .. name)
    if not done then return false, reason end
  end
  return true
end

return rounds
