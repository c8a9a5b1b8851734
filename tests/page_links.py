"""What pages refer to and is not there: files, and the names of places in them."""

import functools
import json
import os
import re
import urllib.parse

_REFERENCE = re.compile(r"<(?:img|script|source|link|a)\b[^>]*?\s(?:src|href)=\"([^\"]+)\"")
_NAME = re.compile(r"\sid=\"([^\"]+)\"")
_FONT = re.compile(r"\burl\((?!data:)[\"']?([^\"')]+)")
# Names that a page's script makes.
_MADE = re.compile(r"/workbench\.html#step-\d+$")


def _read(path):
    """Returns a page without its comments and its scripts' text."""
    with open(path, encoding="utf-8") as file:
        return re.sub(r"<!--.*?-->|(<script\b[^>]*>).*?(?=</script>)", lambda part: part[1] or "",
                      file.read(), flags=re.DOTALL)


@functools.lru_cache(maxsize=None)
def _names_in(path, _):
    return frozenset(_NAME.findall(_read(path)))


def is_there(folder, address):
    """Whether a link from a page of this folder leads to a file, and to a name in it if it has one."""
    place, _, name = address.partition("#")
    path = os.path.normpath(os.path.join(folder, urllib.parse.unquote(place.split("?")[0])))
    if not os.path.exists(path):
        return False
    return (not name or not path.endswith(".html") or bool(_MADE.search(f"{path}#{name}"))
            or urllib.parse.unquote(name) in _names_in(path, os.stat(path).st_mtime_ns))


def _found_by_search(path):
    """Returns the addresses to which the search of a folder of pages leads."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    decoder = json.JSONDecoder()
    sections, _ = decoder.raw_decode(text, text.index("raykitSections = ") + len("raykitSections = "))
    kept, _ = decoder.raw_decode(text, text.rindex("MiniSearch.loadJS(") + len("MiniSearch.loadJS("))
    return {f"{sections[entry['at']][0]}#{entry['name']}" for entry in kept["storedFields"].values()}


def _addresses_in(path):
    name = os.path.basename(path)
    if name.endswith(".html"):
        return {name + address if address[0] == "#" else address
                for address in _REFERENCE.findall(_read(path))}
    if name.endswith(".css"):
        return set(_FONT.findall(_read(path)))
    return _found_by_search(path) if name == "search.js" else set()


def dead_links(folder):
    """Returns the files of a folder with the addresses that they show or lead to, and that do not exist."""
    dead = []
    for room, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(room, name)
            dead += [f"{os.path.relpath(path, folder)}: {address}" for address in _addresses_in(path)
                     if not re.match(r"[a-z]+:", address) and not is_there(room, address)]
    return sorted(dead)
