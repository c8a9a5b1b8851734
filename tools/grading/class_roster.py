"""Who is in the course, for the page of what a class has learned: the tables of make collect."""

from grading.assignments import ToolError
from grading.collect_write import NOT_COLLECTED, read_collected


def _shown(row):
    return f"{row['name'] or 'without a name'} ({row['id']})"


class Roster:
    """The rows of a table of one assignment: how many `students`, those `missing`, and pairs of a student and
    the reason of those whose work was `not_collected`."""

    def __init__(self, rows):
        self.students, self.missing, self.not_collected, self._teams = len(rows), [], [], {}
        for row in rows:
            remarks = row.get("remarks", "")
            if row["submission"]:
                self._teams.setdefault(row["submission"], []).append(_shown(row))
            elif NOT_COLLECTED in remarks:
                self.not_collected.append((_shown(row), remarks.removeprefix(NOT_COLLECTED)))
            else:
                self.missing.append(_shown(row))

    def name_of(self, submission):
        """Returns the names of those whose submission it is, or its own."""
        return ", ".join(self._teams.get(submission, [submission]))

    def compare(self, submissions):
        """Returns the names of these submissions that are nobody's, and of those that lack here."""
        return ([name for name in submissions if name not in self._teams],
                [name for name in self._teams if name not in set(submissions)])


def read_rosters(paths, stems):
    """Returns a dictionary from stems to Rosters. Raises ToolError if a table says nothing of these, or two
    are of the same."""
    tables, places = {}, {}
    for path in paths:
        try:
            rows = read_collected(path)
        except ToolError as error:
            raise ToolError(f"ROSTER: {error}") from error
        said = {stem for row in rows for stem in row.get("assignments", "").split()} or set(stems)
        if not said & set(stems):
            raise ToolError(f"ROSTER: {path} is of {', '.join(sorted(said))}, and the results are of "
                            f"{', '.join(stems)}; give the table of that assignment")
        for stem in sorted(said & set(stems)):
            if stem in places:
                raise ToolError(f"ROSTER: {places[stem]} and {path} are both of {stem}; leave one out")
            places[stem], tables[stem] = path, Roster(rows)
    return tables
