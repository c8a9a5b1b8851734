-- Listings of C: each line with its number in the file, and names that link to their definition's
-- listing in the book, whose head shows on pointing at them.

local store = require("store")

local listings = {}

local defined = {} -- {file, signature} of names that have a listing

function listings.define(name, file, signature)
  local is_call = signature:find("%(") and signature:find("^#") == nil
  defined[name] = {file = file, signature = signature, is_call = is_call}
end

-- A block of code from a file. `numbers` are its lines' in the file, 0 where a line separates definitions;
-- `anchors`, "code-half:3 code-twice:8", names of lines, to which links lead.
function listings.block(text, file, numbers, names, anchors)
  return pandoc.CodeBlock(text,
    {class = "c", file = file, lines = table.concat(numbers, " "), names = names, anchors = anchors})
end

-- Names of other files are links only if they are the kit's own, which are unique.
local function is_seen_from(file, definition, name)
  return definition.file == file or
    (name:find("^[rR][kK]_") and not definition.signature:find("^static"))
end

local function escape(text)
  return (text:gsub("&", "&amp;"):gsub("<", "&lt;"):gsub(">", "&gt;"):gsub('"', "&quot;"))
end

-- Links the names in a piece of HTML without tags; `before` and `behind` are the line around it.
local function linked(piece, block, before, behind)
  return (piece:gsub("()(&?[%a_][%w_]*)()", function(from, name, to)
    local definition = defined[name]
    if not definition or not is_seen_from(block.attributes.file, definition, name) then return nil end
    if (" " .. block.attributes.names .. " "):find(" " .. name .. " ", 1, true) then return nil end
    local left = (before .. piece:sub(1, from - 1)):gsub("<[^>]*>", ""):sub(-4)
    local is_member = left:find("%.$") or left:find("&gt;$") and (before .. left):find("%-&gt;")
    if is_member then return nil end
    local right = (piece:sub(to) .. behind):gsub("<[^>]*>", "")
    if definition.is_call and not right:find("^%s*[%(,%)]") then return nil end
    return string.format('<a href="#code-%s" title="%s">%s</a>', name, escape(definition.signature), name)
  end))
end

-- In comments and texts, nothing is a name.
local wordy = {co = true, st = true, ch = true, pp = true, im = true}

local function line_of(line, block)
  local parts, at, plain = {}, 1, true
  while at <= #line do
    local from, to, tag = line:find("(<[^>]*>)", at)
    local piece = line:sub(at, (from or #line + 1) - 1)
    local before, behind = line:sub(1, at - 1), line:sub(from or #line + 1)
    parts[#parts + 1] = plain and linked(piece, block, before, behind) or piece
    if not from then break end
    parts[#parts + 1] = tag
    plain = not wordy[tag:match('^<span class="(%l%l)">') or ""]
    at = to + 1
  end
  return table.concat(parts)
end

-- The names of lines, by number.
local function anchors_of(block)
  local by_line = {}
  for id, line in (block.attributes.anchors or ""):gmatch("(%S+):(%d+)") do
    by_line[line] = by_line[line] or {}
    table.insert(by_line[line], id)
  end
  return by_line
end

-- A line with its number and its names; it has one itself, others are empty elements before its text.
local function numbered(text, number, ids)
  local first = ids and 'id="' .. table.remove(ids, 1) .. '" ' or ""
  for i, id in ipairs(ids or {}) do ids[i] = '<span id="' .. id .. '"></span>' end
  local data = number ~= "0" and ' data-line="' .. number .. '"' or ""
  return string.format('<span %sclass="line"%s>%s%s</span>', first, data, table.concat(ids or {}), text)
end

-- With pandoc's colours, which were 20 of the 89 seconds that it took for the book.
local function coloured(text, class)
  return store.remember("coloured", table.concat({tostring(PANDOC_VERSION), class, text}, "\n"), function()
    return pandoc.write(pandoc.Pandoc({pandoc.CodeBlock(text, {class = class})}), "html5")
  end)
end

-- The block as HTML; can be scrolled by the keyboard.
function listings.present(block)
  local numbers, class = block.attributes.lines, block.classes[1] or "text"
  if block.text:find("\n%(gdb%)") then class = "text" end -- the debugger's language is not the shell's
  local html = coloured(block.text, class)
  local list, next_number, anchors = {}, (numbers or ""):gmatch("%d+"), anchors_of(block)
  for line in (html:match("<code[^>]*>(.*)</code>") .. "\n"):gmatch("(.-)\n") do
    local text, number = line:match("^<span id=[^>]*><a [^>]*></a>(.*)</span>$") or line, next_number() or "0"
    list[#list + 1] = numbers and numbered(line_of(text, block), number, anchors[number]) or text
  end
  return pandoc.RawBlock("html", string.format(
    '<pre class="sourceCode %s" tabindex="0"><code>%s</code></pre>',
    numbers and class .. " numbered" or class, table.concat(list, "\n")))
end

return listings
