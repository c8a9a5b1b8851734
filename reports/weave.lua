-- Weaves the report: a pandoc filter. Its directives are explained in tools/weave/weave.lua.

local weave = dofile(os.getenv("RAYKIT_SOURCE") .. "/tools/weave/weave.lua")

return {weave.directives({}), weave.without_places}
