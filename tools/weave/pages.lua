-- From the woven document: its contents, names and texts to search, and beside the single file a folder
-- with a page per chapter (of the report: one page), whose pictures are files. weave.sh makes the folder
-- and puts the stylesheet there; without the folder no such pages are written.

local drive = require("drive")
local index = require("index")
local live = require("live")
local sources = require("sources")

local pages = {}

local tools = drive.source .. "/tools/weave/"

local function read(path) return drive.read_file(path) or drive.fail("%s cannot be read", path) end

local function html_of(blocks)
  return pandoc.write(pandoc.Pandoc(blocks), "html5",
    {html_math_method = PANDOC_WRITER_OPTIONS.html_math_method})
end

-- --- chapters --------------------------------------------------------------------------------

-- The document by its headings of level 1: {id, title (HTML), blocks, sections (id and title)}.
local function chapters_of(doc)
  local list, current = {}, nil
  for _, block in ipairs(doc.blocks) do
    if block.t == "Header" and block.level <= 2 then
      local title = pandoc.Plain(block.content):walk({Link = function(link) return link.content end})
      local entry = {id = block.identifier, title = (html_of({title}):gsub("%s+$", ""))}
      if block.level == 1 then
        current = {id = entry.id, title = entry.title, blocks = pandoc.List(), sections = {}}
        list[#list + 1] = current
      elseif current then
        table.insert(current.sections, entry)
      end
    end
    if current then current.blocks:insert(block) end
  end
  return list
end

-- The contents; with `only`, the sections of this chapter alone.
local function contents_of(chapters, only)
  chapters = chapters[1] and chapters[1].all or chapters -- a page that holds several
  local lines = {"<ul>"}
  local function add(...) lines[#lines + 1] = string.format(...) end
  for _, chapter in ipairs(chapters) do
    add('<li%s><a href="#%s">%s</a>', chapter == only and ' class="current"' or "", chapter.id, chapter.title)
    if #chapter.sections > 0 and (not only or chapter == only) then
      add("<ul>")
      for _, section in ipairs(chapter.sections) do
        add('<li><a href="#%s">%s</a></li>', section.id, section.title)
      end
      add("</ul>")
    end
    add("</li>")
  end
  add("</ul>")
  return table.concat(lines, "\n")
end

-- --- the search ------------------------------------------------------------------------------

local function quote(text)
  return '"' .. text:gsub('[%c"\\<]', function(c) return string.format("\\u%04x", c:byte()) end) .. '"'
end

local plain = index.plain

-- What can be searched for, as JSON: title, kind, name of the anchor and page of headings, functions,
-- tests and terms.
local function index_of(chapters)
  local entries = {}
  for _, chapter in ipairs(chapters) do
    for _, entry in ipairs(index.entries(chapter)) do
      local row = {quote(entry.title), quote(entry.kind), quote(entry.id), quote(chapter.page)}
      entries[#entries + 1] = "[" .. table.concat(row, ",") .. "]"
    end
  end
  return "[" .. table.concat(entries, ",\n") .. "]"
end

-- A section's paragraphs, cells and captions; without formulas, which are HTML by now, and listings.
local function text_of(blocks)
  local texts = {}
  local function add(block) texts[#texts + 1] = pandoc.utils.stringify(block) end
  local function leave_out(span) return span.classes:includes("parameters") and {} or nil end
  local function no_picture() return {} end
  pandoc.Div(blocks):walk({Image = no_picture, Span = leave_out, Para = add, Plain = add})
  return (table.concat(texts, " "):gsub("%s+", " "))
end

-- What is written in the sections, as JSON: page, name of the anchor, title and text.
local function texts_of(chapters)
  local rows = {}
  for _, chapter in ipairs(chapters) do
    local section, blocks
    local function finish()
      if not section then return end
      local title = plain(html_of({pandoc.Plain(section.content)}))
      rows[#rows + 1] = "[" .. table.concat({quote(chapter.page), quote(section.identifier), quote(title),
        quote(text_of(blocks))}, ",") .. "]"
    end
    for _, block in ipairs(chapter.blocks) do
      if block.t == "Header" then
        finish()
        section, blocks = block, pandoc.List()
      elseif section then
        blocks:insert(block)
      end
    end
    finish()
  end
  return "window.raykitText = [" .. table.concat(rows, ",\n") .. "];\n"
end

-- --- pages -----------------------------------------------------------------------------------

-- Fills template.html as pandoc does for the single file; of "for", one value.
local function fill(template, values)
  local at = 1
  local function part()
    local out = {}
    while true do
      local from, to, token = template:find("%$([%w_()]+)%$", at)
      out[#out + 1] = template:sub(at, (from or #template + 1) - 1)
      at = (to or #template) + 1
      local name = token and (token:match("^if%((.*)%)$") or token:match("^for%((.*)%)$"))
      if name then
        local yes, ending = part()
        local no = ending == "else" and part() or ""
        out[#out + 1] = values[name] and yes or no
      elseif not token or token == "else" or token:find("^end") then
        return table.concat(out), token
      else
        out[#out + 1] = values[token] or ""
      end
    end
  end
  return (part())
end

-- Links from a page in the folder: to names in other pages, and to files beside the folder.
local function relink(html, chapter, page_of)
  local function target(before, link)
    local name = link:match("^#(.*)$")
    if name then
      if chapter.names[name] or not page_of[name] then return nil end
      return before .. page_of[name] .. link .. '"'
    elseif not link:find("^%a+:") then
      return before .. "../" .. link .. '"'
    end
  end
  return (html:gsub('(%shref=")([^"]*)"', target):gsub('(%ssrc=")([^"]*)"', target))
end

-- The values of the template that all pages have.
local function common_values(doc)
  local values = {css = "style.css", paged = drive.page == "book"}
  for name, value in pairs(PANDOC_WRITER_OPTIONS.variables) do
    if name ~= "css" and type(value) == "string" then values[name] = value end
  end
  for _, name in ipairs({"title", "subtitle", "pagetitle", "date"}) do
    local text = doc.meta[name] and pandoc.utils.stringify(doc.meta[name])
    values[name] = text and html_of({pandoc.Plain({pandoc.Str(text)})})
  end
  values.cover = values.cover and "../" .. values.cover
  values.scripts = '<script src="index.js"></script>\n<script src="page.js"></script>\n' ..
    '<script src="compare.js"></script>'
  return values
end

local function step(chapter, relation, sign)
  if not chapter then return "" end
  local title = sign:gsub("_", (chapter.title:gsub("%%", "%%%%")))
  return string.format('<a rel="%s" href="%s">%s</a>', relation, chapter.page, title)
end

local function steps(chapters, i)
  return '<nav class="steps" aria-label="Chapters">' .. step(chapters[i - 1], "prev", "← _") ..
    step(chapters[i + 1], "next", "_ →") .. "</nav>"
end

-- The first page with each name; sets each chapter's own.
local function find_names(chapters)
  local page_of = {}
  for _, chapter in ipairs(chapters) do
    chapter.names = {}
    for name in chapter.html:gmatch('%sid="([^"]*)"') do
      chapter.names[name] = true
      page_of[name] = page_of[name] or chapter.page
    end
  end
  return page_of
end

-- The beginning of a chapter's first paragraph, for search engines and previews of links.
local function description_of(chapter)
  for _, block in ipairs(chapter.blocks) do
    local text = block.t == "Para" and pandoc.utils.stringify(block) or ""
    if #text > 40 then
      local short = #text > 200 and text:sub(1, 200):match("^(.*)%s") .. " ..." or text
      return (html_of({pandoc.Plain({pandoc.Str(short)})}):gsub('"', "&quot;"))
    end
  end
end

-- Live figures share a script, which only pages with some of them load.
local function write_pages(doc, folder, chapters, page_of, live_script, texts)
  local template, values = read(tools .. "template.html"), common_values(doc)
  local book_title, description = values.pagetitle, values.description
  local scripts = values.scripts
  for i, chapter in ipairs(chapters) do
    local is_live = live_script ~= "" and chapter.html:find("data-program=", 1, true)
    values.scripts = scripts .. (is_live and '\n<script src="live.js"></script>' or "")
    values.chapter = i > 1
    values.pagetitle = i > 1 and plain(chapter.title) .. " – " .. book_title or book_title
    values.description = i > 1 and description_of(chapter) or description
    values.contents = relink(contents_of(chapters, #chapters > 1 and chapter), chapter, page_of)
    values.body = relink(chapter.html, chapter, page_of) .. (#chapters > 1 and steps(chapters, i) or "")
    drive.write_file(folder .. "/" .. chapter.page, fill(template, values))
  end
  if live_script ~= "" then drive.write_file(folder .. "/live.js", live_script) end
  drive.write_file(folder .. "/index.js", "window.raykitIndex = " .. index_of(chapters) .. ";\n")
  drive.write_file(folder .. "/text.js", texts)
end

-- Where the document asks for its index.
local function fill_index(doc, chapters)
  local lists = index.lists(chapters)
  for _, chapter in ipairs(chapters) do
    chapter.html = chapter.html:gsub('(<div class="index (%l+)">)%s*(</div>)', function(head, of, tail)
      return lists[of] and head .. "\n" .. lists[of] .. "\n" .. tail
    end)
  end
  return doc:walk({Div = function(div)
    local list = div.classes[1] == "index" and lists[div.classes[2]]
    if not list then return nil end
    div.content = {pandoc.RawBlock("html", list)}
    return div
  end})
end

function pages.write(doc)
  drive.say("writing the pages")
  local chapters, folder = chapters_of(doc), drive.out .. "/" .. drive.page
  if drive.page == "report" then
    chapters = {{id = "", title = "", blocks = doc.blocks, sections = {}, all = chapters}}
  end
  for i, chapter in ipairs(chapters) do
    chapter.page = i == 1 and "index.html" or chapter.id .. ".html"
    chapter.html = html_of(chapter.blocks)
  end
  doc = fill_index(doc, chapters)
  local solutions = not doc.meta.solutions or pandoc.utils.stringify(doc.meta.solutions) == "yes"
  local live_script, page_of = live.script(solutions), find_names(chapters)
  local texts = texts_of(chapters)
  if drive.exists(folder .. "/style.css") then
    write_pages(doc, folder, chapters, page_of, live_script, texts)
    sources.write(page_of, solutions)
  end
  local scripts = "<script>window.raykitIndex = " .. index_of(chapters) .. ";\n" .. texts ..
    "</script>\n<script>\n" .. read(tools .. "page.js") .. read(tools .. "compare.js") .. live_script ..
    "</script>"
  doc.meta.contents = pandoc.MetaBlocks({pandoc.RawBlock("html", contents_of(chapters))})
  doc.meta.scripts = pandoc.MetaBlocks({pandoc.RawBlock("html", scripts)})
  return doc
end

return pages
