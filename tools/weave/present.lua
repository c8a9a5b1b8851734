-- The last step before HTML: pictures and tables become figures with captions, pictures know their
-- sizes, and whoever cannot see or point gets short texts and a place for the keyboard.

local drive = require("drive")
local numbering = require("numbering")
local pictures = require("pictures")

local present = {}

-- --- texts for who cannot see ----------------------------------------------------------------

local symbols = {cdot = "·", times = "×", le = "≤", leq = "≤", ge = "≥", geq = "≥", ne = "≠", approx = "≈",
  infty = "∞", sum = "sum of", int = "integral of", prod = "product of", sqrt = "√", pm = "±", to = "→",
  ldots = "…", dots = "…", alpha = "α", beta = "β", gamma = "γ", delta = "δ", epsilon = "ε",
  varepsilon = "ε", eta = "η", theta = "θ", lambda = "λ", mu = "μ", pi = "π", rho = "ρ", sigma = "σ",
  tau = "τ", phi = "φ", varphi = "φ", psi = "ψ", xi = "ξ", ell = "ℓ", oplus = "⊕",
  omega = "ω", Omega = "Ω", Delta = "Δ"}

-- A formula as it could be read aloud, not set.
local function text_of_formula(tex)
  tex = tex:gsub("\\[dt]?frac%s*(%b{})%s*(%b{})", "%1 / %2"):gsub("\\[,;:! ]", " ")
  tex = tex:gsub("\\(%a+)", function(name) return symbols[name] or (#name <= 3 and name or "") end)
  return (tex:gsub("\\\\", "; "):gsub("[{}&\\]", ""):gsub("%s+", " "):gsub("^ ", ""):gsub(" $", ""))
end

local function text_of(inlines)
  local texts = pandoc.Plain(inlines):walk({Math = function(math)
    return pandoc.Str(text_of_formula(math.text))
  end})
  return pandoc.utils.stringify(texts)
end

-- The alternative text: the figure's own, or the first sentence of its caption.
local function alternative(div, caption)
  if div.attributes.alt then return div.attributes.alt end
  if not caption or not caption.content[1] then return "" end
  local inlines = pandoc.List(caption.content[1].content):filter(function(inline)
    return not (inline.t == "Link" and inline.classes:includes("number"))
  end)
  local text = text_of(inlines):gsub("^%s+", "")
  return text:match("^(.-[.:;!?])%s+%u") or text
end

-- --- pictures --------------------------------------------------------------------------------

function present.size(image)
  local width, height = pictures.size(image.src)
  if not width then return nil end
  image.attributes.width, image.attributes.height = tostring(width), tostring(height)
  image.attributes.loading, image.attributes.decoding = "lazy", "async"
  return image
end

local function html(text) return pandoc.RawBlock("html", text) end

local function figure(div)
  local list, caption = pandoc.List(div.content), nil
  local last = list[#list]
  if last and last.t == "Div" and last.classes:includes("caption") then caption = list:remove(#list) end
  list:insert(1, html(string.format('<figure class="%s"%s>', table.concat(div.classes, " "),
    div.identifier ~= "" and ' id="' .. div.identifier .. '"' or "")))
  if caption then
    list:insert(html('<figcaption class="caption">'))
    list:extend(caption.content)
    list:insert(html("</figcaption>"))
  end
  list:insert(html("</figure>"))
  return list
end

-- --- tables ----------------------------------------------------------------------------------

function present.term_id(term) return "term-" .. term:lower():gsub("[^%w]+", "-"):gsub("%-$", "") end

-- The glossary's terms have names, by which the search finds them.
local function name_terms(simple)
  for _, row in ipairs(simple.rows) do
    local term = row[1][1]
    term.content = {pandoc.Span(term.content, {id = present.term_id(pandoc.utils.stringify(term.content))})}
  end
  return pandoc.utils.from_simple_table(simple)
end

local function arranged(tabular)
  local simple = pandoc.utils.to_simple_table(tabular)
  local first = simple.headers[1] and pandoc.utils.stringify(simple.headers[1])
  return first == "term" and name_terms(simple) or tabular
end

-- A column that is called by a formula alone: its name is said in words, as not all readers of screens take a
-- formula for text.
local function say_formula(cell)
  local function said(formula)
    local tex = formula.t == "Math" and formula.text or
      formula.text:match('class="katex".-application/x%-tex">(.-)</annotation>')
    if not tex then return nil end
    tex = tex:gsub("&lt;", "<"):gsub("&gt;", ">"):gsub("&amp;", "&")
    return {pandoc.Span(text_of_formula(tex), {class = "said"}),
      pandoc.Span({formula}, {["aria-hidden"] = "true"})}
  end
  if text_of(pandoc.utils.blocks_to_inlines(cell.contents)) == "" then
    cell.contents = cell.contents:walk({Math = said, RawInline = said})
  end
end

-- A group, because regions are landmarks, and a page has too many tables for that.
local function scrollable(label)
  return {class = "wide", tabindex = "0", role = "group", ["aria-label"] = label}
end

function present.table(tabular)
  local columns = pandoc.List()
  for _, cell in ipairs(pandoc.utils.to_simple_table(tabular).headers) do
    local title = text_of(pandoc.utils.blocks_to_inlines(cell))
    if title ~= "" then columns:insert(title) end
  end
  for _, row in ipairs(tabular.head.rows) do
    for _, cell in ipairs(row.cells) do say_formula(cell) end
  end
  local label = "Table" .. (#columns > 0 and " of " .. table.concat(columns, ", ") or "")
  return pandoc.Div({arranged(tabular)}, scrollable(label))
end

-- --- formulas --------------------------------------------------------------------------------

-- A displayed formula, which may be wider than the page.
function present.formula(span)
  if not span.classes:includes("equation") then return nil end
  span.content[1] = pandoc.Span({span.content[1]}, {class = "formula", tabindex = "0", role = "math",
    ["aria-label"] = text_of_formula(span.content[1].text)})
  return span
end

-- A short formula stays in one line with the punctuation beside it: to the browser, it is a box with room to
-- break around it.
function present.tie(inlines)
  for i = #inlines, 1, -1 do
    local formula, before, behind = inlines[i], inlines[i - 1], inlines[i + 1]
    local is_formula = formula.t == "RawInline" and formula.text:find('class="katex"', 1, true)
    local _, places = (is_formula and formula.text or ""):gsub('class="base"', "")
    if is_formula and places <= 1 then
      local tied = pandoc.List({formula})
      if behind and behind.t == "Str" and behind.text:find("^[,.;:!?)]") then
        tied:insert(inlines:remove(i + 1))
      end
      if before and before.t == "Str" and before.text:find("%($") then
        i = i - 1
        tied:insert(1, inlines:remove(i))
      end
      if #tied > 1 then inlines[i] = pandoc.Span(tied, {class = "tied"}) end
    end
  end
  return inlines
end

-- --- filters ---------------------------------------------------------------------------------

-- While formulas are still what the text has.
function present.describe(div)
  if not div.classes:includes("picture") then return nil end
  local alt = (div.classes:includes("plot") and "Plot: " or "") .. alternative(div, div.content[#div.content])
  div.attributes.alt = nil
  return div:walk({Image = function(image)
    image.caption = {pandoc.Str(alt .. (pandoc.utils.stringify(image.caption):match(" Labels: .*$") or ""))}
    return image
  end})
end

-- Two pictures that become one with a slider have to fit one upon the other.
function present.check_comparison(div)
  if not div.classes:includes("compare") or drive.units ~= "" then return end
  if drive.runs == "1" then return end -- quick pictures are smaller
  local sizes = {}
  div:walk({Image = function(image) sizes[#sizes + 1] = table.concat({pictures.size(image.src)}, " x ") end})
  if #sizes ~= 2 or sizes[1] ~= sizes[2] then
    drive.fail_at(div, ".compare needs two pictures of equal size; there are: %s", table.concat(sizes, ", "))
  end
end

function present.division(div)
  if div.classes:includes("wide") then return div.content end -- the table has one of its own
  if div.classes:includes("picture") then return figure(div) end
  if not div.classes:includes("numbers") then return nil end
  local label = numbering.label[div.identifier]
  for _, block in ipairs(div.content) do
    if label and block.attributes["aria-label"] then block.attributes["aria-label"] = label end
  end
  return figure(div)
end

return present
