-- CSV files as drivers write them: RFC 4180, without line breaks in cells.

local csv = {}

-- A line's cells, or nil if a quote is left open.
function csv.cells(line)
  local list, at = {}, 1
  while at <= #line + 1 do
    local cell
    if line:sub(at, at) == '"' then
      local stop = at + 1
      while line:sub(stop, stop) ~= '"' or line:sub(stop + 1, stop + 1) == '"' do
        stop = stop + (line:sub(stop, stop) == '"' and 2 or 1)
        if stop > #line then return nil end
      end
      cell, at = line:sub(at + 1, stop - 1):gsub('""', '"'), stop + 2
    else
      local stop = line:find(",", at, true) or #line + 1
      cell, at = line:sub(at, stop - 1), stop + 1
    end
    list[#list + 1] = cell
  end
  return list
end

-- The header and the rows, lists of cells; or nil and the reason.
function csv.read(path)
  local file = io.open(path)
  if not file then return nil, path .. " is missing: no driver wrote it" end
  local lines = {}
  for line in file:lines() do
    local cells = csv.cells(line)
    if not cells then return nil, path .. ": an unclosed quote: " .. line end
    lines[#lines + 1] = cells
  end
  file:close()
  return table.remove(lines, 1) or {}, lines
end

local function quoted(cell)
  return cell:find('[",]') and '"' .. cell:gsub('"', '""') .. '"' or cell
end

function csv.write(path, header, rows)
  local file, reason = io.open(path, "w")
  if not file then return nil, reason end
  for i = 0, #rows do
    local cells = {}
    for c, cell in ipairs(rows[i] or header) do cells[c] = quoted(cell) end
    file:write(table.concat(cells, ","), "\n")
  end
  return file:close()
end

return csv
