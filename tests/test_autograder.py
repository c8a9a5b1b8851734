#!/usr/bin/env python3
"""The zip that Gradescope takes, unpacked and run as its manual says, in a folder in the place of
/autograder. Speaks TAP, for make check-autograder; runs in a build folder."""

import json
import os
import shutil
import sys
import tempfile
import zipfile

SOURCE = os.path.abspath(os.environ.get("srcdir", "."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(SOURCE, "tools"))

from tap import check, finish, read, run, start  # noqa: E402

MAKE = os.environ.get("MAKE", "make")


def submit(place, text):
    """Runs the autograder on a submission; returns what it wrote."""
    folder = os.path.join(place, "submission")
    shutil.rmtree(folder, ignore_errors=True)
    os.mkdir(folder)
    if text:
        with open(os.path.join(folder, "normals.c"), "w", encoding="utf-8") as file:
            file.write(text)
    status, said = run(place, "env", f"AUTOGRADER={place}", os.path.join(place, "source", "run_autograder"))
    try:
        results = json.loads(read(place, "results", "results.json"))
    except (OSError, ValueError) as error:
        results = {"output": str(error)}
    check(status == 0 and "score" in results and results.get("output_format") == "text",
          "results.json is written, and the status is 0", [said, str(results)])
    return results


def refusals(work):
    for arguments, said_of_it in (((), "name the assignments"), (("ASSIGNMENTS=fog",), "fog"),
                                  (("ASSIGNMENTS=normals", "OUT=a.tar"), "should end in .zip")):
        status, said = run(".", MAKE, "-s", "autograder", *arguments)
        check(status != 0 and said_of_it in said, f"make autograder {' '.join(arguments)} is refused", said)
    write_protected = os.path.join(work, "there.zip")
    with open(write_protected, "w", encoding="utf-8"):
        pass
    status, said = run(".", MAKE, "-s", "autograder", "ASSIGNMENTS=normals", f"OUT={write_protected}")
    check(status != 0 and "exists" in said, "a file that is there is kept", said)


def main():
    with tempfile.TemporaryDirectory(dir=".") as work:
        work = os.path.abspath(work)
        refusals(work)
        out, place = os.path.join(work, "autograder.zip"), os.path.join(work, "autograder")
        status, said = run(".", MAKE, "-s", "autograder", "ASSIGNMENTS=normals", f"OUT={out}")
        check(status == 0 and "Gradescope only" in said, "make autograder writes a zip", said)
        with zipfile.ZipFile(out) as archive:
            names = archive.namelist()
            archive.extractall(os.path.join(place, "source"))
        check(sorted(names) == ["assignments", "kit.tar.gz", "run_autograder", "setup.sh"],
              "with its two scripts at the top", names)
        for name in ("setup.sh", "run_autograder"):
            os.chmod(os.path.join(place, "source", name), 0o755)
        os.mkdir(os.path.join(place, "results"))

        results = submit(place, "int x;\n")
        check(results["score"] == 0 and "could not be graded" in results["output"],
              "where it was not set up, the reason is told", results["output"])
        status, said = run(place, "env", f"AUTOGRADER={place}", os.path.join(place, "source", "setup.sh"),
                           "--no-install")
        check(status == 0, "setup.sh builds what grading needs", said)

        right = read(SOURCE, "src", "features", "normals.c")
        results = submit(place, right)
        check(results["score"] == 100, "right work has 100 points", results["output"])
        check("SANDBOX=container" in results["output"], "and it is said that there was no other sandbox",
              results["output"])
        results = submit(place, right.replace("return", "retrun", 1))
        check(results["score"] == 0 and results["tests"], "what does not compile has none, and the reason",
              results["output"])
        results = submit(place, "")
        check(results["score"] == 0, "nor has nothing", results["output"])
    return finish()


start(main)
