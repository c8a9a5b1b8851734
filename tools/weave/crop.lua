-- A part of a picture, magnified: crop="left top width height", in fractions of the picture. The whole
-- picture is in the page; the part is shown by its styles alone, pixel by pixel, in print, too.

local drive = require("drive")
local pictures = require("pictures")

local function fractions(div)
  local x, y, w, h = div.attributes.crop:match("^(%S+) (%S+) (%S+) (%S+)$")
  x, y, w, h = tonumber(x), tonumber(y), tonumber(w), tonumber(h)
  if not h or x < 0 or y < 0 or w <= 0 or h <= 0 or x + w > 1.0001 or y + h > 1.0001 then
    drive.fail_at(div, 'crop="%s" is not a part of the picture; give left, top, width and height as ' ..
      'fractions, as in crop="0.5 0.2 0.25 0.25"', div.attributes.crop)
  end
  return x, y, w, h
end

-- The block that shows the picture, or its part, and the width of what it shows over its height.
return function(div, image)
  local width, height = pictures.size(image.src)
  local ratio = width / height
  if not div.attributes.crop then return pandoc.Plain({image}), ratio end
  local x, y, w, h = fractions(div)
  image.attributes.style = string.format("width: %.5g%%; margin: %.5g%% 0 0 %.5g%%",
    100 / w, -100 * y / w / ratio, -100 * x / w)
  image.attributes["data-crop"] = div.attributes.crop -- for pictures.check_row
  local shape = w * ratio / h
  return pandoc.Div({pandoc.Plain({image})},
    {class = "crop", style = string.format("aspect-ratio: %.5g", shape)}), shape
end
