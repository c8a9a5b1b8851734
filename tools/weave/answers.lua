-- The instructor's edition (make book ANSWERS=yes): answers to a chapter's exercises, folded below each.
-- make_book has pandoc read docs/answers/NN_x.md after the chapter:
--
--   # Answers {.answers}
--
--   ## 1
--
--   **Hint.** For exercise 1.
--
--   **Answer.** To the next heading.
--
-- An easy or medium exercise has an answer, and each but the research ones a hint; else weaving stops.

local drive = require("drive")
local fail_at, place = drive.fail_at, drive.place

local answers = {}

local answered = {easy = true, medium = true}
local levels = {easy = true, medium = true, hard = true, research = true}
local kinds = {["Hint."] = "hint", ["Answer."] = "answer"}

-- pandoc records a block's place on a division around it.
local function inner(block)
  while block.t == "Div" and block.identifier == "" and #block.classes == 0 and #block.content == 1 do
    block = block.content[1]
  end
  return block
end

local function text_of(block) return pandoc.utils.stringify(block) end

-- --- the texts -------------------------------------------------------------------------------

-- "Hint." or "Answer." at a block's beginning, which is removed, or nil.
local function take_kind(block)
  local inlines = inner(block).t == "Para" and inner(block).content or {}
  local first = inlines[1]
  while first and first.t == "Span" and #first.content > 0 do first = first.content[1] end
  local kind = first and first.t == "Strong" and kinds[text_of(first)]
  if kind then
    inlines:remove(1)
    if inlines[1] and text_of(inlines[1]):match("^%s*$") then inlines:remove(1) end
  end
  return kind
end

-- Adds a block to the hint or the answer of an exercise.
local function add(exercise, block)
  local kind = take_kind(block)
  if kind then
    if exercise[kind] then
      fail_at(exercise.heading, "exercise %d has two of **%s**", exercise.number, kind)
    end
    exercise[kind], exercise.last = pandoc.List(), kind
  elseif not exercise.last then
    fail_at(exercise.heading, "the text of exercise %d begins with **Hint.** or **Answer.**", exercise.number)
  end
  exercise[exercise.last]:insert(block)
end

-- Takes the text with answers from position i on out of the blocks. Returns them by number, and the position
-- of
-- the block behind.
local function read(blocks, i)
  local texts, exercise = {heading = inner(blocks[i])}, nil
  i = i + 1
  while blocks[i] do
    local block = inner(blocks[i])
    if block.t == "Header" and block.level == 1 then break end
    if block.t == "Header" then
      local number = tonumber(text_of(block):match("^%d+$"))
      if not number then fail_at(block, '"%s" is not the number of an exercise', text_of(block)) end
      if texts[number] then
        fail_at(block, "exercise %d is in %s already", number, place(texts[number].heading))
      end
      exercise = {heading = block, number = number}
      texts[number] = exercise
    elseif exercise then
      add(exercise, blocks[i])
    else
      fail_at(texts.heading, "the first text below needs the number of an exercise above it, such as ## 1")
    end
    i = i + 1
  end
  return texts, i
end

-- --- the exercises ---------------------------------------------------------------------------

local function fold(kind, title, blocks)
  local list = pandoc.List({pandoc.RawBlock("html",
    '<details class="told"><summary>' .. title .. "</summary>")})
  list:extend(blocks[kind] or {})
  list:insert(pandoc.RawBlock("html", "</details>"))
  return blocks[kind] and list or {}
end

-- The list's exercises with their texts below them.
local function tell(list, texts, where)
  for number, item in ipairs(list.content) do
    local level = text_of(pandoc.Div(item)):match("^%((%w+)%)")
    if not levels[level] then
      fail_at(where, "exercise %d begins with (easy), (medium), (hard) or (research)", number)
    end
    local exercise = texts[number] or {}
    if answered[level] and not exercise.answer then
      fail_at(where, "exercise %d is %s and has no answer", number, level)
    end
    if level ~= "research" and not exercise.hint then fail_at(where, "exercise %d has no hint", number) end
    item:extend(fold("hint", "Hint", exercise))
    item:extend(fold("answer", "Answer", exercise))
    exercise.told = true
  end
  for number, exercise in pairs(texts) do
    if number ~= "heading" and not exercise.told then
      fail_at(exercise.heading, "there is no exercise %d: %s has %d", number, place(where), #list.content)
    end
  end
end

-- Position of the last heading "Exercises" before i, below which the list stands.
local function exercises_before(blocks, i)
  while i > 0 and not (inner(blocks[i]).t == "Header" and text_of(inner(blocks[i])) == "Exercises") do
    i = i - 1
  end
  local list = i > 0 and inner(blocks[i + 1])
  return list and list.t == "OrderedList" and list, i > 0 and inner(blocks[i])
end

-- All texts with answers leave the page for their exercises.
function answers.weave(page)
  local kept, i = pandoc.List(), 1
  while page.blocks[i] do
    local block = inner(page.blocks[i])
    if block.t == "Header" and block.classes:includes("answers") then
      local texts, behind = read(page.blocks, i)
      local list, where = exercises_before(kept, #kept)
      if not list then fail_at(block, "there is no list of exercises before it") end
      tell(list, texts, where)
      i = behind
    else
      kept:insert(page.blocks[i])
      i = i + 1
    end
  end
  page.blocks = kept
  return page
end

return answers
