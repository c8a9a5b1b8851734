-- The files of the source tree to which a page links, each as a page of its own in the folder source beside
-- it, with numbered lines: whoever is given the folder alone can read them. With RAYKIT_SOURCES=linked, in a
-- pack for students, links lead to the files themselves, which are theirs to change.

local code = require("code")
local drive = require("drive")
local listings = require("listings")

local sources = {}

local paths, is_listed = {}, {}

local function page_of(path) return path:gsub("/", "-") .. ".html" end

-- The target of a link to a file of the source tree, at this line if one is given.
function sources.link(path, line)
  if os.getenv("RAYKIT_SOURCES") == "linked" then return os.getenv("RAYKIT_SOURCE_LINK") .. "/" .. path end
  if not is_listed[path] then is_listed[path], paths[#paths + 1] = true, path end
  return "source/" .. page_of(path) .. (line and "#line-" .. line or "")
end

local languages = {c = "c", h = "c", lua = "lua", md = "markdown", py = "python", sh = "bash"}

local function listing(path, solutions)
  local lines, wrong = code.lines(drive.source .. "/" .. path, path, solutions)
  if not lines then drive.fail("%s", wrong) end
  local texts, numbers, anchors = {}, {}, {}
  for i, line in ipairs(lines) do
    texts[i], numbers[i], anchors[i] = line.text, line.number, "line-" .. line.number .. ":" .. line.number
  end
  local block = listings.block(table.concat(texts, "\n"), path, numbers, "", table.concat(anchors, " "))
  block.classes = {languages[path:match("%.(%a+)$")] or "text"}
  return listings.present(block).text
end

local page = [[
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>%s – raykit</title>
<link rel="stylesheet" href="../%s/style.css">
</head>
<body class="%s source">
<a class="skip" href="#text">Skip to the text</a>
<header>
<p class="title"><a href="../%s/index.html">raykit</a></p>
</header>
<main id="text">
<h1><code>%s</code></h1>
%s
</main>
</body>
</html>
]]

-- Writes these pages. `pages` has the page of each name to which their own links lead, `solutions` says
-- whether students' parts are shown.
function sources.write(pages, solutions)
  for _, path in ipairs(paths) do
    local html = listing(path, solutions):gsub('href="#([^"]*)"', function(name)
      local target = pages[name] and drive.page .. "/" .. pages[name] or drive.page .. ".html"
      return string.format('href="../%s#%s"', target, name)
    end)
    drive.write_file(drive.out .. "/source/" .. page_of(path),
      string.format(page, path, drive.page, drive.page, drive.page, path, html))
  end
end

return sources
