-- From the woven document: its contents, and beside the single file a folder with pages, whose pictures are
-- files: one per section, or where sections are shorter than a screen one for several. weave.sh makes the
-- folder and puts the stylesheet there; without the folder no such pages are written.

local drive = require("drive")
local index = require("index")
local live = require("live")
local replay = require("replay")
local search = require("search")
local sources = require("sources")

local pages = {}

local plain = index.plain
local tools = drive.source .. "/tools/weave/"

local function read(path) return drive.read_file(path) or drive.fail("%s cannot be read", path) end

local function html_of(blocks)
  return pandoc.write(pandoc.Pandoc(blocks), "html5",
    {html_math_method = PANDOC_WRITER_OPTIONS.html_math_method})
end

-- --- chapters --------------------------------------------------------------------------------

-- The document by its headings of level 1: {id, title (HTML), blocks, sections (id and title)}. What precedes
-- the first one is in the first chapter.
local function chapters_of(doc)
  local list, current, before = {}, nil, pandoc.List()
  for _, block in ipairs(doc.blocks) do
    if block.t == "Header" and block.level <= 2 then
      local title = pandoc.Plain(block.content):walk({Link = function(link) return link.content end})
      local entry = {id = block.identifier, title = (html_of({title}):gsub("%s+$", ""))}
      if block.level == 1 then
        current = {id = entry.id, title = entry.title, blocks = current and pandoc.List() or before,
          sections = {}}
        list[#list + 1] = current
      elseif current then
        table.insert(current.sections, entry)
      end
    end
    local blocks = current and current.blocks or before
    blocks:insert(block)
  end
  if not current then list[1] = {id = "", title = "", blocks = before, sections = {}} end
  return list
end

-- The contents; with `only`, the sections of this chapter alone.
local function contents_of(chapters, only)
  local lines = {"<ul>"}
  local function add(...) lines[#lines + 1] = string.format(...) end
  for _, chapter in ipairs(chapters) do
    if chapter.id == "" then break end
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

-- --- pages of a chapter ----------------------------------------------------------------------

local screen = 40 -- lines of text, on a desk

local function without_folded(html)
  while true do
    local _, to = html:find("</details>", 1, true)
    if not to then return html end
    local from = html:sub(1, to):match(".*()<details")
    html = html:sub(1, from - 1) .. html:sub(to + 1)
  end
end

-- About how many lines of text are as high as this.
local function height_of(html)
  local lines = 0
  local function add(height) return function() lines = lines + height; return "" end end
  html = without_folded(html):gsub("<script.-</script>", ""):gsub("<math.-</math>", "")
  html = html:gsub("<svg.-</svg>", add(12)):gsub("<img[^>]*>", add(14)):gsub("<tr", add(1))
  html = html:gsub("<pre.-</pre>", function(pre)
    local _, line_ends = pre:gsub("\n", "")
    lines = lines + 0.8 * line_ends + 2
    return ""
  end)
  for paragraph in html:gsub("<[^>]*>", ""):gmatch("[^\n][^\n]*") do lines = lines + #paragraph / 85 end
  return lines
end

-- Of sections that are called alike, pandoc numbers the names: such a page is called as its chapter, too.
local function file_of(chapter, id)
  local title = id ~= chapter.id and id:match("^(.*)%-%d+$")
  return (title and chapter.id .. "-" .. title or id) .. ".html"
end

-- A chapter's pages: {chapter, title, page (its file's name), html}. A page ends when it fills a screen; what
-- is left of a chapter and does not goes with the page before.
local function split(chapter)
  local list, parts = {}, {pandoc.List()}
  for _, block in ipairs(chapter.blocks) do
    if block.t == "Header" and block.level == 2 then parts[#parts + 1] = pandoc.List() end
    parts[#parts]:insert(block)
  end
  local function finish(page) page.html = table.concat(page.parts, "\n") end
  for i, blocks in ipairs(parts) do
    local page, html = list[#list], html_of(blocks)
    if not page or page.height >= screen then
      local heading = chapter.sections[i - 1] or chapter
      page = {chapter = chapter, id = heading.id, title = heading.title, page = file_of(chapter, heading.id),
        blocks = blocks, parts = {}, height = 0}
      list[#list + 1] = page
    end
    table.insert(page.parts, html)
    page.height = page.height + height_of(html)
  end
  if #list > 1 and list[#list].height < screen then
    local last = table.remove(list)
    table.move(last.parts, 1, #last.parts, #list[#list].parts + 1, list[#list].parts)
  end
  for _, page in ipairs(list) do finish(page) end
  return list
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
local function relink(html, page, page_of)
  local function target(before, link)
    local name = link:match("^#(.*)$")
    if name then
      if page.names[name] or not page_of[name] then return nil end
      return before .. page_of[name] .. link .. '"'
    elseif not link:find("^%a+:") then
      return before .. "../" .. link .. '"'
    end
  end
  return (html:gsub('(%shref=")([^"]*)"', target):gsub('(%ssrc=")([^"]*)"', target))
end

-- The values of the template that all pages have.
local function common_values(doc)
  local values = {css = "style.css", paged = "yes"}
  for name, value in pairs(PANDOC_WRITER_OPTIONS.variables) do
    if name ~= "css" and type(value) == "string" then values[name] = value end
  end
  for _, name in ipairs({"title", "subtitle", "pagetitle", "date"}) do
    local text = doc.meta[name] and pandoc.utils.stringify(doc.meta[name])
    values[name] = text and html_of({pandoc.Plain({pandoc.Str(text)})})
  end
  values.search = search.is_possible()
  values.cover = values.cover and "../" .. values.cover
  return values
end

-- Scripts that only pages with what they are for load, by what these contain.
local function scripts_of(html, live_script)
  local names = {"page.js"}
  if html:find('class="[^"]*%f[%w]compare%f[%W]') then names[#names + 1] = "compare.js" end
  if live_script ~= "" and html:find("data-program=", 1, true) then names[#names + 1] = "live.js" end
  if html:find('class="replay"', 1, true) then names[#names + 1] = "steps.js" end
  for i, name in ipairs(names) do names[i] = '<script src="' .. name .. '"></script>' end
  return table.concat(names, "\n")
end

local function step(page, relation, sign)
  if not page then return "" end
  local title = sign:gsub("_", (page.title:gsub("%%", "%%%%")))
  return string.format('<a rel="%s" href="%s">%s</a>', relation, page.page, title)
end

local function steps(list, i)
  return '<nav class="steps" aria-label="Pages">' .. step(list[i - 1], "prev", "← _") ..
    step(list[i + 1], "next", "_ →") .. "</nav>"
end

-- The first page with each name; sets each page's own.
local function find_names(list)
  local page_of = {}
  for _, page in ipairs(list) do
    page.names = {}
    for name in page.html:gmatch('%sid="([^"]*)"') do
      page.names[name] = true
      page_of[name] = page_of[name] or page.page
    end
  end
  return page_of
end

-- The beginning of a page's first paragraph, for search engines and previews of links.
local function description_of(page)
  for _, block in ipairs(page.blocks) do
    local text = block.t == "Para" and pandoc.utils.stringify(block) or ""
    if #text > 40 then
      local short = #text > 200 and text:sub(1, 200):match("^(.*)%s") .. " ..." or text
      return (html_of({pandoc.Plain({pandoc.Str(short)})}):gsub('"', "&quot;"))
    end
  end
end

-- Where each name is, for links from elsewhere (tools/grading/assignments.py), and from before a chapter was
-- split into these pages (page.js).
local function places(page_of)
  local rows = {}
  for name, page in pairs(page_of) do rows[#rows + 1] = string.format('"%s":"%s"', name, page) end
  table.sort(rows)
  return "window.raykitPlaces = {\n" .. table.concat(rows, ",\n") .. "\n};\n"
end

-- The chapter's title, above its other pages.
local function chapter_line(page)
  if page.id == page.chapter.id then return "" end
  return string.format('<h1 class="of-chapter"><a href="#%s">%s</a></h1>\n', page.chapter.id,
    page.chapter.title)
end

local function page_title(page, of_all)
  local title = plain(page.title)
  if page.id ~= page.chapter.id then title = title .. " – " .. plain(page.chapter.title) end
  return title .. " – " .. of_all
end

local function write_pages(doc, folder, chapters, list, page_of, live_script)
  local template, values = read(tools .. "template.html"), common_values(doc)
  local of_all, description = values.pagetitle, values.description
  for i, page in ipairs(list) do
    values.scripts = scripts_of(page.html, live_script)
    values.chapter = i > 1
    values.formulas = page.html:find("katex", 1, true) or page.html:find("<tspan font%-")
    values.pagetitle = i > 1 and page_title(page, of_all) or of_all
    values.description = i > 1 and description_of(page) or description
    values.contents = relink(contents_of(chapters, page.chapter), page, page_of)
    values.body = relink(chapter_line(page) .. page.html, page, page_of) .. steps(list, i)
    drive.write_file(folder .. "/" .. page.page, fill(template, values))
  end
  if live_script ~= "" then drive.write_file(folder .. "/live.js", live_script) end
  if replay.script() ~= "" then drive.write_file(folder .. "/steps.js", replay.script()) end
  drive.write_file(folder .. "/places.js", places(page_of))
end

-- Where the document asks for its index.
local function fill_index(doc)
  local chapters = chapters_of(doc)
  for _, chapter in ipairs(chapters) do chapter.html = html_of(chapter.blocks) end
  local lists = index.lists(chapters)
  return doc:walk({Div = function(div)
    local list = div.classes[1] == "index" and lists[div.classes[2]]
    if not list then return nil end
    div.content = {pandoc.RawBlock("html", list)}
    return div
  end})
end

local function pages_of(chapters)
  local list = {}
  for _, chapter in ipairs(chapters) do
    local own = split(chapter)
    table.move(own, 1, #own, #list + 1, list)
  end
  list[1].page = "index.html"
  return list
end

function pages.write(doc)
  drive.say("writing the pages")
  doc = search.name_paragraphs(fill_index(doc))
  local chapters, folder = chapters_of(doc), drive.out .. "/" .. drive.page
  local list = pages_of(chapters)
  local solutions = not doc.meta.solutions or pandoc.utils.stringify(doc.meta.solutions) == "yes"
  local live_script, page_of = live.script(solutions), find_names(list)
  local search_script = search.script(list, page_of)
  if drive.exists(folder .. "/style.css") then
    write_pages(doc, folder, chapters, list, page_of, live_script)
    if search_script then drive.write_file(folder .. "/search.js", search_script) end
    sources.write(page_of, solutions)
  end
  local scripts = "<script>\n" .. read(tools .. "page.js") .. read(tools .. "compare.js") .. live_script ..
    replay.script() .. "</script>"
  if search_script then
    scripts = '<script type="text/plain" id="search-script">' .. search_script .. "</script>\n" .. scripts
  end
  doc.meta.contents = pandoc.MetaBlocks({pandoc.RawBlock("html", contents_of(chapters))})
  doc.meta.scripts = pandoc.MetaBlocks({pandoc.RawBlock("html", scripts)})
  return doc
end

return pages
