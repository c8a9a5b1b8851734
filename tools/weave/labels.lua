-- Words over a picture, with lines to what they name: label="0.62 0.31 0.8 0.2 red pane; ..." has the line's
-- end and its other end, beside which the text goes, in fractions of the picture. With two numbers there is
-- no line, and the text is centred there. Light on a dark rim, so that they show on any picture.

local drive = require("drive")

local function escape(text) return (text:gsub("&", "&amp;"):gsub("<", "&lt;")) end

local function read(div)
  local list = {}
  for part in div.attributes.label:gmatch("[^;]+") do
    local x, y, rest = part:match("^%s*([%d.]+)%s+([%d.]+)%s+(.-)%s*$")
    local tx, ty, text = (rest or ""):match("^([%d.]+)%s+([%d.]+)%s+(.+)$")
    x, y, tx, ty = tonumber(x), tonumber(y), tonumber(tx), tonumber(ty)
    if not x or not y or rest == "" then
      drive.fail_at(div, 'label: "%s" is not a place and a text; give the line\'s end, the text\'s place ' ..
        'and the text, as in label="0.6 0.3 0.8 0.2 red pane"', part)
    end
    list[#list + 1] = {x = x, y = y, tx = tx or x, ty = ty or y, line = tx ~= nil, text = text or rest}
  end
  return list
end

-- The text's place and alignment: beyond the line's outer end, in the line's direction.
local function beside(l, ratio)
  local x, y = 100 * l.tx, 100 * l.ty / ratio
  local right, down = x - 100 * l.x, y - 100 * l.y / ratio
  if not l.line then return x, y, "middle" end
  if math.abs(right) < math.abs(down) then return x, y + (down < 0 and -2.5 or 2.5), "middle" end
  return x + (right < 0 and -1 or 1), y, right < 0 and "end" or "start"
end

-- In per cent of the picture's width, because an SVG's text has one size in both directions.
local function draw(list, ratio)
  local parts = {string.format('<svg class="labels" viewBox="0 0 100 %.5g" aria-hidden="true">', 100 / ratio)}
  for _, l in ipairs(list) do
    for _, class in ipairs(l.line and {"rim", "leader"} or {}) do
      parts[#parts + 1] = string.format('<path class="%s" d="M%.4g %.4gL%.4g %.4g"/>', class,
        100 * l.x, 100 * l.y / ratio, 100 * l.tx, 100 * l.ty / ratio)
    end
    local x, y, anchor = beside(l, ratio)
    parts[#parts + 1] = string.format('<text x="%.4g" y="%.4g" dy="0.35em" text-anchor="%s">%s</text>',
      x, y, anchor, escape(l.text))
  end
  parts[#parts + 1] = "</svg>"
  return pandoc.RawBlock("html", table.concat(parts))
end

-- Puts the labels over the block that shows the picture; `ratio` is its width over its height.
local labels = {}

function labels.over(div, block, ratio)
  return pandoc.Div({block, draw(read(div), ratio)}, {class = "labelled"})
end

-- For those who do not see them.
function labels.as_text(div)
  local texts = {}
  for i, l in ipairs(div.attributes.label and read(div) or {}) do texts[i] = l.text end
  return #texts > 0 and " Labels: " .. table.concat(texts, ", ") .. "." or ""
end

return labels
