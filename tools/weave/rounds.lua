-- Timings by turns. Drivers run in rounds, each configuration once per round, so that a slow phase of the
-- machine hits all configurations and not one. Tables have the medians of the rounds, the least and
-- the largest. While some time differs by more than a fifth, up to as many rounds follow as were planned.

local csv = require("csv")

local rounds = {}

rounds.tolerated = 0.2 -- (largest - least) / median

local function place_of_median(header)
  for i, column in ipairs(header) do
    if column == "median" then return i end
  end
end

-- Adds the medians of a round's tables to those measured so far, by table and by what stands before the
-- median.
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
  for _, time in ipairs({median(times), times[1], times[#times]}) do
    row[#row + 1] = string.format("%.6g", time)
  end
  row[#row + 1] = tostring(#times)
  return row
end

-- A configuration's tables, by their files' names.
local function tables_of(measured)
  local tables = {}
  for name, all in pairs(measured) do
    tables[name] = {header = all.header, rows = {}}
    for i, key in ipairs(all.keys) do tables[name].rows[i] = row_of(all, key) end
  end
  return tables
end

-- Runs each of the configurations by run(configuration, folder), in rounds with folders below `scraps`.
-- list(folder, pattern) lists files. Returns each configuration's tables.
function rounds.measure(configurations, planned, run, list, scraps)
  local measured = {}
  for _, configuration in ipairs(configurations) do measured[configuration] = {} end
  for round = 1, 2 * planned do
    local steady = true
    for i, configuration in ipairs(configurations) do
      local folder = os.tmpname()
      os.remove(folder)
      folder = scraps .. "/" .. folder:match("[^/]+$") .. "_" .. i
      run(configuration, folder)
      collect(measured[configuration], folder, list)
      steady = is_steady(measured[configuration]) and steady
    end
    if round >= planned and steady then break end
  end
  local tables = {}
  for configuration, all in pairs(measured) do tables[configuration] = tables_of(all) end
  return tables
end

return rounds
