-- Weaves the report: a pandoc filter with the directives of tools/weave/weave.lua and no others.
package.path = os.getenv("RAYKIT_SOURCE") .. "/tools/weave/?.lua;" .. package.path
return require("weave").filters({})
