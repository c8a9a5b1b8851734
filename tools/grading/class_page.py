"""What a class has learned, as one page: who has begun, where those who have are stuck, how points are
distributed, what changed since the last run, and whom to talk to. Counts verdicts; judges nothing."""

import base64
import collections
import datetime
import html
import os
import re
import statistics

from grading import results

_NOT_BEGUN, _NOTHING_RAN, _STILL_STUCK, _NOT_GRADED, _NOT_COLLECTED, _MISSING = (
    "has not begun", "nothing ran", "stuck at the same claim for two runs", "was not graded",
    "handed in what was not collected", "handed in nothing")
_PICTURE_MAX = 200_000  # bytes
_REASONS = 6  # at one claim
_EXAMPLE = re.compile(r"; you get this, for example, if (.+)")  # RK_EXAMPLE_IF of tests/test.h
_NO_PICTURE = ("did not end ", "crashed: ", "undefined behaviour: ", "goes beyond ", "used more than ",
               "printed ")

_STYLE = """
:root { color-scheme: light dark; background: Canvas; color: CanvasText; --line: #8888; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h2 { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 1rem; }
table { border-collapse: collapse; margin: 1rem 0; max-width: 100%; }
caption { text-align: left; font-weight: bold; padding: .3rem 0; }
.wide { overflow-x: auto; }
th, td { text-align: left; vertical-align: top; padding: .2rem .8rem .2rem 0; overflow-wrap: break-word;
  border-bottom: 1px solid var(--line); }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 0; } figure img { max-width: 160px; } figcaption { font-size: .9rem; max-width: 24rem; }
svg { max-width: 100%; height: auto; } svg text { fill: currentColor; font-size: 12px; }
svg rect { fill: currentColor; fill-opacity: .45; stroke: currentColor; } svg line { stroke: currentColor; }
@media print {
  body { max-width: none; margin: 0; font-size: 11pt; } tr, figure, svg { break-inside: avoid; }
  .wide { overflow: visible; }
}
"""


def _text(value):
    return html.escape(results.printable(str(value)))


def _words(claim):
    return claim.replace("_", " ")


def _breakable(name):
    return f'<code>{_text(name).replace("_", "_<wbr>")}</code>'


def _sentence(text):
    """A sentence of the kit's own, in which there may be code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", _text(text))


def moment_of(graded):
    """Returns when a verdict was made, as a number by which verdicts of all time zones are in order."""
    try:
        return datetime.datetime.strptime(graded, "%Y-%m-%d %H:%M:%S %z").timestamp()
    except (ValueError, OverflowError):
        return 0.0


class Work:
    """One submission to one assignment."""

    def __init__(self, verdict):
        self.name, self.points = verdict["submission"], verdict["points"]
        self.maximum, self.problem = verdict["maximum"], verdict["problem"]
        self.not_graded = verdict["not_graded"]
        self.claims = [] if self.problem else verdict["claims"]
        self.when = verdict["graded"]
        self.run = [verdict["key"] or self.when]  # the same work graded again is no other run
        failed = [claim for claim in self.claims if not claim["passed"]]
        # A claim of a step fails with the starter.
        self.begun = not verdict["is_starter"] and any(claim["passed"] and claim["step"]
                                                       for claim in self.claims)
        self.stuck_at = failed[0] if self.begun and failed else None


def _mistake_in(reason):
    """Returns what two reasons share that tell of the same mistake: what a wrong number says of it, else the
    whole text, but for the limit of a time."""
    example = _EXAMPLE.search(reason)
    if example:
        return example[1]
    if reason.startswith("did not end within "):
        return "did not end", "MB of memory" in reason
    return reason


class Assignment:
    """What all have made of one. `tests` are the rows of its points.tsv, by name; `roster` is a Roster, or
    None if nobody knows who is in the course."""

    def __init__(self, feature, tests, works, roster=None):
        self.feature, self.tests, self.roster = feature, {test.name: test for test in tests}, roster
        self.strangers, self.unjudged = roster.compare([work.name for work in works]) if roster else ([], [])
        self.works = sorted((work for work in works if not work.not_graded), key=lambda work: work.name)
        self.not_graded = {work.name: work.not_graded for work in works if work.not_graded}
        self.begun = [work for work in self.works if work.begun]
        self.stuck = collections.Counter(work.stuck_at["name"] for work in self.begun if work.stuck_at)

    def who(self, name):
        """Returns whose a submission is, as far as that is known."""
        return self.roster.name_of(name) if self.roster else name

    def steps(self):
        """Yields (step, how many have begun it, have done it, are stuck at a claim of it)."""
        for step in sorted({test.step for test in self.tests.values() if test.step}):
            begun = done = 0
            for work in self.begun:
                held = {claim["name"]: claim["passed"] for claim in work.claims if claim["step"] == step}
                # What an earlier step happens to make hold begins none.
                begun += any(passed and not (name in self.tests and self.tests[name].green_since)
                             for name, passed in held.items())
                done += bool(held) and all(held.values())
            stuck = sum(work.stuck_at["step"] == step for work in self.begun if work.stuck_at)
            yield step, begun, done, stuck

    def hardest(self):
        """Returns [(claim, how many are stuck there)], most first, then in the order of work."""
        order = list(self.tests)
        return sorted(self.stuck.items(),
                      key=lambda row: (-row[1], order.index(row[0]) if row[0] in order else len(order)))

    def reasons_at(self, claim):
        """Returns the reasons of those who are stuck at a claim, most frequent first: (text, how many have
        it, whether it says what the mistake is)."""
        groups = {}
        for work in self.begun:
            if work.stuck_at and work.stuck_at["name"] == claim:
                text = work.stuck_at["reason"].split("\n")[0]
                groups.setdefault(_mistake_in(text), []).append(text)
        found = [(texts[0], len(texts), bool(_EXAMPLE.search(texts[0])) or texts[0].startswith(_NO_PICTURE))
                 for texts in groups.values()]
        return sorted(found, key=lambda group: -group[1])


def history(assignment, last):
    """Returns {name: row}: of each submission its points, the claim at which it is stuck and in how many runs
    it was, and the points that it had before; made of the last page's rows, which stay where nothing was
    graded anew."""
    rows = {}
    for work in assignment.works:
        claim, old = work.stuck_at["name"] if work.stuck_at else "", last.get(work.name)
        if old and old["run"] == work.run:
            rows[work.name] = old
            continue
        again = old["times"] if old and old["stuck"] == claim else 0
        rows[work.name] = {"run": work.run, "points": work.points, "stuck": claim, "times": again + 1,
                           "before": old["points"] if old else None}
    return rows


# --- Parts of the page -------------------------------------------------------------------------


def _table(caption, heads, rows):
    """Cells are HTML; numbers stand to the right. The first cell of a row is its heading."""
    if not rows:
        return ""

    def cell(value):
        return f'<td class="number">{value}</td>' if isinstance(value, (int, float)) else f"<td>{value}</td>"

    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    body = "".join(f'<tr><th scope="row">{row[0]}</th>{"".join(map(cell, row[1:]))}</tr>\n' for row in rows)
    return (f'<div class="wide" role="region" tabindex="0" aria-label="{caption}"><table>\n'
            f"<caption>{caption}</caption><thead><tr>{head}</tr></thead>\n"
            f"<tbody>\n{body}</tbody></table></div>\n")


def _bins(works):
    """Returns [(label, how many)] by tenths of the maximum."""
    labels = [f"{10 * tenth} to {10 * tenth + 9}" for tenth in range(10)] + ["100"]
    counts = [0] * len(labels)
    for work in works:
        counts[min(10, max(0, 10 * work.points // work.maximum if work.maximum else 0))] += 1
    return list(zip(labels, counts))


def _chart(stem, bins):
    """The distribution of points as bars."""
    most, width, height, left, top = max(count for _, count in bins), 52, 160, 50, 20
    right = left + width * len(bins)
    parts = []
    for number, (label, count) in enumerate(bins):
        size, x = height * count / most, left + width * number
        parts.append(f'<rect x="{x + 6}" y="{top + height - size:.1f}" width="{width - 12}" '
                     f'height="{size:.1f}"/><text x="{x + width / 2}" y="{top + height - size - 4:.1f}" '
                     f'text-anchor="middle">{count}</text><text x="{x + width / 2}" y="{top + height + 16}" '
                     f'text-anchor="middle">{label.replace(" to ", "–")}</text>')
    said = ", ".join(f"{label} %: {count}" for label, count in bins)
    middle = top + height / 2
    return (f'<svg role="img" viewBox="0 0 {right + 10} {top + height + 44}" width="{right + 10}" '
            f'aria-label="{stem}: submissions by points in percent of the maximum. {said}">'
            f'<line x1="{left}" y1="{top + height}" x2="{right}" y2="{top + height}"/>'
            f'<line x1="{left}" y1="{top}" x2="{left}" y2="{top + height}"/>{"".join(parts)}'
            f'<text x="{left - 6}" y="{top + 4}" text-anchor="end">{most}</text>'
            f'<text x="{left - 6}" y="{top + height}" text-anchor="end">0</text>'
            f'<text x="{(left + right) / 2}" y="{top + height + 38}" text-anchor="middle">points, in % of '
            f'the maximum</text><text transform="translate(14 {middle}) rotate(-90)" text-anchor="middle">'
            "submissions</text></svg>\n")


def _quartiles(works):
    points = [work.points for work in works]
    low, middle, high = (statistics.quantiles(points, n=4, method="inclusive") if len(points) > 1
                         else points * 3)
    return f"{low:g}, {middle:g} and {high:g}"


def _section(assignment, claim):
    """The heading of the claim's section, and its place in the book: a link where that is woven."""
    feature, test = assignment.feature, assignment.tests.get(claim)
    if not test or not test.section:
        return ""
    page, place = feature.page(test.section), _text(feature.chapter + test.section).replace("#", "<wbr>#")
    with open(os.path.join(feature.source, feature.chapter), encoding="utf-8") as file:
        heading = re.search(rf"^#+ (.*?) *\{{{re.escape(test.section)}[ }}]", file.read(), re.MULTILINE)
    where = f'<a href="{_text(page.as_uri() + test.section)}">{place}</a>' if page else place
    return f"“{_sentence(heading[1])}” ({where})" if heading else where


def _reasons(groups):
    """The reasons of a claim, a line each."""
    of = sum(count for _, count, _ in groups)
    lines = [f"{_text(text)} ({count} of {of})" for text, count, _ in groups[:_REASONS]]
    more = [count for _, count, _ in groups[_REASONS:]]
    if more:
        lines.append(f"{len(more)} other reason{'s' * (len(more) > 1)} ({sum(more)} of {of})")
    return "<br>".join(lines)


def _picture(found, groups):
    """What a known mistake draws that fails this claim. `found` is (mistake, caption, bytes or None). It need
    not be that of those whose reason says another."""
    of, unknown = (sum(count for _, count, says in groups if not (says and some)) for some in (False, True))
    if not unknown:
        return "None is supposed: each reason says it."
    if not found:
        return "No known mistake of this claim has a picture."
    mistake, caption, data = found
    perhaps = "Perhaps" if unknown == of else f"Perhaps of the {unknown} of {of} whose reason says no mistake"
    said = f"{perhaps}: {_sentence(mistake)} One sees: {_sentence(caption)}"
    if not data or len(data) > _PICTURE_MAX or not data.startswith(b"\x89PNG\r\n\x1a\n"):
        return f"{said} (<code>make book</code> draws the picture.)"
    image = base64.b64encode(data).decode()
    return (f'<figure><img src="data:image/png;base64,{image}" alt="{_text(caption)}">'
            f"<figcaption>{said}</figcaption></figure>")


def _monday(assignments):
    """The claims at which most are stuck, a sentence each."""
    rows = sorted(((count, assignment, claim) for assignment in assignments
                   for claim, count in assignment.hardest()), key=lambda row: -row[0])[:3]
    said = []
    for count, assignment, claim in rows:
        step = assignment.tests[claim].step if claim in assignment.tests else 0
        section = _section(assignment, claim)
        begun = len(assignment.begun)
        said.append(f"<li>{count} of the {begun} who {'has' if begun == 1 else 'have'} begun "
                    f"<code>{assignment.feature.stem}</code> {'is' if count == 1 else 'are'} stuck at "
                    f"“{_text(_words(claim))}”{f', a claim of step {step}' if step else ''}"
                    f"{f': teach {section}' if section else ''}.</li>\n")
    return f"<ol>\n{''.join(said)}</ol>\n" if said else "<p>Nobody who has begun is stuck.</p>\n"


def _changes(rows):
    """What became of the points since each one's run before."""
    both = [(row["before"], row["points"]) for row in rows.values() if row["before"] is not None]
    if not both:
        return "<p>There is no earlier run to compare with.</p>\n"
    more, less = sum(new > old for old, new in both), sum(new < old for old, new in both)
    same = len(both) - more - less
    old, new = (f"{statistics.median(pair[place] for pair in both):g}" for place in (0, 1))
    return (f"<p>Since each one's previous run, {more} gained points, {less} lost points, {same} have as "
            f"many; {len(rows) - len(both)} have no previous run. The median of those with two runs went "
            f"from {old} to {new}.</p>\n")


def _not_there(assignment):
    """Those of the roster without a verdict."""
    roster, stem = assignment.roster, assignment.feature.stem
    if not roster:
        return []
    return [*((_text(who), stem, _NOT_COLLECTED, _text(why)) for who, why in roster.not_collected),
            *((_text(assignment.who(name)), stem, _NOT_GRADED, "there is no verdict in the results")
              for name in assignment.unjudged),
            *((_text(who), stem, _MISSING, "") for who in roster.missing)]


def _need_a_word(assignments, histories):
    rows = []
    for assignment in assignments:
        stem = assignment.feature.stem
        rows += [(_text(assignment.who(name)), stem, _NOT_GRADED, _text(why))
                 for name, why in assignment.not_graded.items()]
        rows += _not_there(assignment)
        for work in assignment.works:
            row = histories[stem][work.name]
            why = ((_NOTHING_RAN, work.problem.split("\n")[0]) if work.problem else
                   (_NOT_BEGUN, "") if not work.begun else
                   (_STILL_STUCK, _words(row["stuck"])) if row["stuck"] and row["times"] > 1 else None)
            if why:
                rows.append((_text(assignment.who(work.name)), stem, why[0], _text(why[1])))
    order = [_NOT_COLLECTED, _NOT_GRADED, _NOTHING_RAN, _STILL_STUCK, _NOT_BEGUN, _MISSING]
    rows.sort(key=lambda row: (order.index(row[2]), row[1], row[0]))
    whose = "student" if any(assignment.roster for assignment in assignments) else "submission"
    return _table("Whom to talk to", [whose, "assignment", "why", "more"], rows) or (
        "<p>Nobody.</p>\n")


def _attendance(assignment, has_rosters):
    """Says who is missing, if that is known."""
    roster = assignment.roster
    if not roster:
        told = f"no roster of {assignment.feature.stem} was given"
        return f"<p>Who is missing here is not known: {told}.</p>\n" if has_rosters else ""
    not_collected = len(roster.not_collected)
    lost = f", and the work of {not_collected} was not collected" if not_collected else ""
    strangers = ", ".join(map(_text, assignment.strangers))
    return (f"<p>Of {roster.students} students on the roster, {len(roster.missing)} handed in nothing{lost}."
            "</p>\n" + (f"<p>Not on the roster: {strangers}.</p>\n" if strangers else ""))


def _part(assignment, rows, picture_of, has_rosters):
    stem, works, begun = assignment.feature.stem, assignment.works, assignment.begun
    steps = [[f"step {step}", *counts] for step, *counts in assignment.steps()]
    stuck = []
    for claim, count in assignment.hardest():
        groups = assignment.reasons_at(claim)
        stuck.append([_breakable(claim), count, _reasons(groups), _section(assignment, claim),
                      _picture(picture_of(assignment.feature, claim), groups)])
    bins, head = _bins(works), f'<h2 id="{stem}">{stem}</h2>\n{_attendance(assignment, has_rosters)}'
    if not works:
        return head + "<p>Nobody's work was graded.</p>\n"
    return (f'{head}<p>{len(begun)} of {len(works)} have begun; '
            f"{sum(not work.stuck_at for work in begun)} of these have all claims.</p>\n"
            + _table(f"Steps of {stem}", ["step", "have begun it", "have done it", "are stuck in it"], steps)
            + _table(f"Where those who have begun {stem} are stuck",
                     ["first claim that fails", "submissions", "reasons", "section",
                      "known mistake"], stuck)
            + _chart(stem, bins)
            + f"<p>Quartiles of the points: {_quartiles(works)}; the one in the middle is the median, "
            f"the maximum is {max(work.maximum for work in works):g}.</p>\n"
            + _changes(rows))


def page(assignments, histories, unread, picture_of):
    """Returns the page. `histories` has what history returns, by stem; `unread`
    names files that are no verdicts, picture_of(feature, claim) returns what _picture takes."""
    runs = sorted((work.when for assignment in assignments for work in assignment.works), key=moment_of)
    when = f"<p>Graded {_text(' to '.join(dict.fromkeys([runs[0], runs[-1]])))}.</p>\n" if runs else ""
    has_rosters = any(assignment.roster for assignment in assignments)
    lost = f"<p>Could not be read: {_text(', '.join(unread))}.</p>\n" if unread else ""
    parts = "".join(_part(one, histories[one.feature.stem], picture_of, has_rosters) for one in assignments)
    contents = "".join(f'<li><a href="#{assignment.feature.stem}">{assignment.feature.stem}</a></li>'
                       for assignment in assignments) + '<li><a href="#word">Whom to talk to</a></li>'
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width"><link rel="icon" href="data:,">'
            "<title>What the class learned</title>"
            f"<style>{_STYLE}</style></head><body><main>\n<h1>What the class learned</h1>\n{when}{lost}"
            f'<h2 id="monday">What to teach on Monday</h2>\n{_monday(assignments)}'
            f"<nav aria-label=\"Assignments\"><ul>{contents}</ul></nav>\n"
            f"{parts}"
            f'<h2 id="word">Whom to talk to</h2>\n{_need_a_word(assignments, histories)}'
            "</main></body></html>\n")
