-- What can be seen wrong in a picture without knowing its text.

local drive = require("drive")
local fail_at = drive.fail_at

local pictures = {}

-- A PNG file's pixels, equal for equal pictures, and its texts by their keys.
local function read_png(path)
  local file = io.open(drive.out .. "/" .. path, "rb")
  local png, parts, texts, at = file:read("a"), {}, {}, 9
  file:close()
  while at < #png do
    local length, kind = string.unpack(">I4c4", png, at)
    local data = png:sub(at + 8, at + 7 + length)
    if kind == "IHDR" or kind == "IDAT" then parts[#parts + 1] = data end
    if kind == "tEXt" then texts[data:match("^[^\0]*")] = data:match("%z(.*)$") end
    at = at + 12 + length
  end
  return table.concat(parts), texts
end

-- Width and height in pixels from a PNG's or an SVG's first lines, or nil.
function pictures.size(path)
  local file = path:find("^figures/") and io.open(drive.out .. "/" .. path, "rb")
  if not file then return nil end
  local head = file:read(1000) or ""
  file:close()
  if head:sub(13, 16) == "IHDR" then
    local width, height = string.unpack(">I4I4", head, 17)
    return width, height
  end
  return head:match('<svg.-%swidth="([%d.]+)"'), head:match('<svg.-%sheight="([%d.]+)"')
end

-- The bar of a picture with false colours, by what the driver says of them (rk_driver_scale), or nil.
function pictures.scale(path)
  local _, texts = read_png(path)
  local marks, colours, unit = (texts["raykit:scale"] or ""):match("^([^#]*) (#[#%x ]-) ([^#]*)$")
  if not marks then return nil end
  local values = {}
  for value, place in marks:gmatch("(%S+)@(%S+)") do
    values[#values + 1] = pandoc.Span(value:gsub("^-", "−"):gsub("%+$", " and more"),
      {class = "tick", style = "--place: " .. place})
  end
  local ramp = "background: linear-gradient(to right, " .. colours:gsub(" ", ", ") .. ")"
  return pandoc.Div({pandoc.Plain({
    pandoc.Span("", {class = "ramp", style = ramp}),
    pandoc.Span(values, {class = "ticks"}), pandoc.Span(unit, {class = "unit"}),
  })}, {class = "scale"})
end

local most_black, least_frame = 0.7, 0.4
local users_most_black, users_least_frame = 0.97, 0.02
local dark = 0 -- pictures
local drawn = {} -- figures with their paths and pixels
local is_users = {} -- by the paths of pictures

-- Most of a picture is there to be seen; dark=yes says that this one has to be dark.
function pictures.check_subject(div, path)
  if drive.units ~= "" then return end -- a student's unit may draw anything, and differently each time
  local pixels, texts = read_png(path)
  drawn[#drawn + 1] = {div = div, path = path, pixels = pixels}
  local black, frame = tonumber(texts["raykit:black"]), tonumber(texts["raykit:frame"])
  if div.attributes.dark or not black then return end
  if black > most_black or frame < least_frame then
    dark = dark + 1
    drive.say("%s: %s: %.0f %% is black, and all that can be seen is in %.0f %% of the frame",
      drive.place(div), path, 100 * black, 100 * frame)
  end
end

-- What is said where little can be seen in a picture of a user's mesh, or nil.
local function note_subject(path, mesh)
  local _, texts = read_png(path)
  local black, frame = tonumber(texts["raykit:black"]), tonumber(texts["raykit:frame"])
  if not black or (black <= users_most_black and frame >= users_least_frame) then return nil end
  local seen = black == 1 and "all of it is black" or
    string.format("%.1f %% of it is black, and the rest is in %.1f %% of the frame", 100 * black, 100 * frame)
  drive.say("%s: little can be seen in %s: %s", mesh, path, seen)
  return "Little can be seen here: " .. seen .. "."
end

local noted = {} -- what drivers have said of meshes, by both

-- A picture of a user's own mesh is not judged. Returns what is said below it: what the driver said of the
-- mesh, once in a page, and where little of it can be seen.
function pictures.notes(path, mesh, said)
  is_users[path] = true
  local notes, name = {note_subject(path, mesh)}, mesh:gsub(".*/", "")
  drive.tell(said)
  for line in said:gmatch("[^\n]+") do
    local sentence = line:gsub("^[%w_]+: ", ""):gsub(mesh:gsub("%W", "%%%0"), (name:gsub("%%", "%%%%")))
    if not noted[mesh .. sentence] then notes[#notes + 1] = sentence .. "." end
    noted[mesh .. sentence] = true
  end
  return notes
end

-- All of them at once, because drawing them takes minutes.
function pictures.finish()
  for _, figure in ipairs(drawn) do
    if read_png(figure.path) ~= figure.pixels then
      fail_at(figure.div, "a later run, for a table or a plot, has drawn over %s; " ..
        "keep=NAME gives that run a folder of its own", figure.path)
    end
  end
  if dark == 0 then return end
  drive.fail("%d pictures show too little (above): come closer, give them a sky, " ..
    "or say dark=yes where it has to be so", dark)
end

local least_visible = 1e-3 -- part of the pixels

-- Which part of two pictures' pixels differ visibly, as they are shown, or nil if they are no pair.
local function visible_difference(one, other)
  local crop = one.attributes["data-crop"]
  local program = os.getenv("RAYKIT_PAIR") or ""
  if program == "" or crop ~= other.attributes["data-crop"] then return nil end
  local said = drive.answer_of(table.concat({drive.quote(program), drive.quote(drive.out .. "/" .. one.src),
    drive.quote(drive.out .. "/" .. other.src), crop or ""}, " "))
  if not said then drive.fail("%s and %s cannot be compared (the reason is above)", one.src, other.src) end
  return tonumber(said)
end

-- Pictures of a row are there to be compared: no two are equal, and if there are only two, their difference
-- can be seen. A student's unit may not make a difference yet, and users' meshes may be equal.
function pictures.check_row(div)
  if drive.units ~= "" then return end
  local seen, shown = {}, {}
  div:walk({Image = function(image)
    if not image.src:find("^figures/.*%.png$") or is_users[image.src] then return end
    local pixels = read_png(image.src) .. (image.attributes["data-crop"] or "")
    if seen[pixels] then
      fail_at(div, "%s and %s are equal, pixel for pixel; show something in which they differ",
        seen[pixels], image.src)
    end
    seen[pixels] = image.src
    shown[#shown + 1] = image
  end})
  local part = #shown == 2 and visible_difference(shown[1], shown[2])
  if part and part < least_visible then
    fail_at(div, "%s and %s look alike: %.3f %% of their pixels differ by more than 4 of 255, at least " ..
      "%g %% should; show something in which they differ, or crop=... where they do",
      shown[1].src, shown[2].src, 100 * part, 100 * least_visible)
  end
end

return pictures
