-- The slope of an error over the number of samples, as plots, tables and sentences state it.

local fit = {}

fit.from = 4 -- samples: before, an error need not yet follow its power

-- The slope of the straight line through the logarithms of points {x, y}, by least squares; nil of fewer than
-- two.
function fit.slope(points)
  local n, sx, sy, sxx, sxy = #points, 0, 0, 0, 0
  if n < 2 then return nil end
  for _, point in ipairs(points) do
    local x, y = math.log(point[1]), math.log(point[2])
    sx, sy, sxx, sxy = sx + x, sy + y, sxx + x * x, sxy + x * y
  end
  return (n * sxy - sx * sy) / (n * sxx - sx * sx)
end

return fit
