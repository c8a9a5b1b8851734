-- Weaves the report: a pandoc filter with the directives of tools/weave/weave.lua and no others.
-- Not by package.path, which takes no folder whose name holds ";" or "?".
table.insert(package.searchers, 2, function(name)
  return loadfile(os.getenv("RAYKIT_SOURCE") .. "/tools/weave/" .. name .. ".lua")
end)
return require("weave").filters({})
