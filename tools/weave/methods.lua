-- The colour and marker of each method, the same in all plots of book and report. A method that is not here
-- is a mistake. Colours are those of M. Okabe and K. Ito (2008), which people with any colour vision
-- distinguish, darkened to a contrast of 3 : 1 to white and to the dark page, where plots are inverted.

local blue, vermilion, green, purple = "#0072b2", "#d55e00", "#00875f", "#b8578e"
local sky, ochre, black, grey, violet = "#2a8fc4", "#a87400", "#000000", "#777777", "#6a3d9a"

-- gnuplot's markers: filled ones, and each one's open form is the number before.
local square, circle, up, down, diamond, pentagon = 5, 7, 9, 11, 13, 15

-- Those that share no plot may share a colour.
local methods = {
  -- samples
  ["uniform"] = {blue, circle}, ["stratified"] = {vermilion, square}, ["low discrepancy"] = {green, up},
  ["sobol"] = {purple, diamond}, ["zsobol"] = {violet, pentagon}, ["equidistant"] = {black, down},
  ["adaptive"] = {sky, pentagon},
  -- samples of the light
  ["early out"] = {grey, up}, ["pyramids"] = {sky, down}, ["solid angle"] = {ochre, pentagon},
  ["ratio"] = {violet, square}, ["pyramids, ratio"] = {black, circle},
  ["24 on the light"] = {vermilion, square}, ["16 on the light, 8 of the lobe"] = {green, up},
  -- trees
  ["median"] = {vermilion, square}, ["sah"] = {blue, circle}, ["sah 3"] = {green, up},
  ["collapsed"] = {purple, diamond}, ["wide"] = {black, pentagon},
  -- bloom
  ["exact"] = {black, square}, ["gaussian"] = {blue, circle}, ["recursive"] = {vermilion, down},
  ["pyramid"] = {green, up},
  -- cube maps
  ["nearest"] = {blue, circle}, ["bilinear"] = {vermilion, square}, ["seamless"] = {green, up},
  -- engines
  ["raykit"] = {blue, circle}, ["embree"] = {vermilion, square}, ["embree, robust"] = {ochre, diamond},
  -- what is measured, where that distinguishes the lines
  ["build"] = {vermilion, square}, ["render"] = {blue, circle}, ["time over goal"] = {blue, circle},
  ["1 thread"] = {blue, circle}, ["2 threads"] = {vermilion, square}, ["the tree"] = {green, up},
  ["the whole process"] = {purple, diamond},
}

-- The part of a name after a comma, such as a map: plain ones are dashed, with open markers.
local is_plain = {["polar"] = true, ["uniform"] = true, ["uniform map"] = true, ["its times too"] = true,
  ["concentric"] = false, ["cosine"] = false}

-- The entry's name: without the number of bins, or a slope.
local function key_of(name)
  return (name:lower():gsub("[-_]", " "):gsub(", slope .*", ""):gsub("^(%a+)%d+", "%1"))
end

-- Returns a method's colour, marker and whether it is dashed, or nil where it is not in the table. Numbers
-- are no methods: the caller has their place among the lines.
local function style_of(name, place)
  if tonumber(name) then
    local in_order = {"uniform", "stratified", "low discrepancy", "sobol", "pyramids", "equidistant",
      "adaptive", "early out", "zsobol"}
    return table.unpack(methods[in_order[place]] or {})
  end
  local key = key_of(name)
  if methods[key] then return table.unpack(methods[key]) end
  local base, variant = key:match("^(.-), (.*)$")
  if not methods[base] or is_plain[variant] == nil then return nil end
  local colour, marker = table.unpack(methods[base])
  return colour, is_plain[variant] and marker - 1 or marker, is_plain[variant]
end

return style_of
