-- A driver's default, from what it says about its options: [sobol]{.default driver=depth_of_field
-- option=lens-sampling}.

local drive = require("drive")

local helps = {} -- by driver

-- The default of an option in the text of --help, or nil. An option's words go on until the next one's
-- dashes.
local function default_in(help, option)
  local words = ("\n" .. help):match("\n  %-%-" .. option:gsub("%W", "%%%0") .. "%f[%s](.-)\n  %-%-") or ""
  return (words:gsub("%s+", " "):match("default ([^%s();]+)%)"))
end

return function(span)
  local driver, option = drive.need(span, "driver"), drive.need(span, "option")
  helps[driver] = helps[driver] or drive.help(span) .. "\n  --"
  return pandoc.Str(default_in(helps[driver], option) or
    drive.fail_by_driver(span, "%s --help names no default of --%s", driver, option))
end
