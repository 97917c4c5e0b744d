"""Circles of files: strongly connected components of the modules of each crate, by their `use` declarations.

    python3 tests/structure/circles.py                 # the circles of each crate, and their number
    python3 tests/structure/circles.py --check N       # exit code 1 above N circles; the limit may only be lowered
    python3 tests/structure/circles.py --arrows CRATE  # the `use` declarations inside the circles of one crate

A node is a file. An arrow goes from a file to the one that declares what it uses: a `pub use` is followed to the declaration and is no
arrow itself. A module and the modules inside it use each other freely: between them there are no arrows. Test code, comments and
strings are left out.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

TOKEN = re.compile(
    r"""//[^\n]*|/\*.*?\*/|b?r(\#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?'(?:\\[^']+|[^'\\])'|(?:r\#)?[A-Za-z_]\w*|\S""",
    re.S,
)
ITEM = ("fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules")


def tokens_of(text):
    """The tokens of a file that are no comments; strings and characters as `""`."""
    found = []
    for match in TOKEN.finditer(text):
        token = match.group()
        if token.startswith(("//", "/*")):
            continue
        found.append('""' if token[-1] in "\"'" and len(token) > 1 else token.removeprefix("r#"))
    return found


def closing(tokens, start):
    """The place of the bracket that closes the one at `start`."""
    depth = 0
    for place in range(start, len(tokens)):
        if tokens[place] in "([{":
            depth += 1
        elif tokens[place] in ")]}":
            depth -= 1
            if depth == 0:
                return place
    return len(tokens) - 1


def item_end(tokens, place):
    """The last token of the item that begins at `place`."""
    while place < len(tokens) and tokens[place] not in (";", "{"):
        place = closing(tokens, place) if tokens[place] in "([" else place
        place += 1
    return closing(tokens, place) if place < len(tokens) and tokens[place] == "{" else place


class Module:
    """A module with a file of its own. Inline modules belong to the file, `inside` says how deep."""

    def __init__(self, name, file):
        self.name, self.file = name, file
        self.children, self.declared, self.uses = {}, set(), []

    def __str__(self):
        return str(self.file.relative_to(ROOT))


class Use:
    """One name that is used: `path`, the name that it gets, where it was written, whether it is handed on."""

    def __init__(self, path, local, inline, public):
        self.path, self.local, self.inline, self.public = path, local, inline, public


def flat(tokens, prefix=()):
    """(path, local name) of each leaf of a `use` tree; the local name of a glob is `*`."""
    path, place = list(prefix), 0
    while place < len(tokens):
        token = tokens[place]
        if token == "{":
            part, start, depth = [], place + 1, 0
            for at in range(place + 1, closing(tokens, place) + 1):
                if tokens[at] in ",}" and depth == 0:
                    part.append(tokens[start:at])
                    start = at + 1
                depth += {"{": 1, "}": -1}.get(tokens[at], 0)
            for one in part:
                if one:
                    yield from flat(one, tuple(path))
            return
        if token == "as":
            yield tuple(path), tokens[place + 1]
            return
        if token != ":":
            path.append(token)
        place += 1
    if path and path[-1] == "self" and len(path) > 1:
        path.pop()
    yield tuple(path), path[-1] if path else ""


def read(module, directory, crate):
    """Reads a module's file, and those of its children."""
    tokens = tokens_of(module.file.read_text())
    crate[module.name] = module
    scan(module, tokens, directory, crate, ())


def scan(module, tokens, directory, crate, inline):
    place, test, path_attribute, public = 0, False, None, False
    while place < len(tokens):
        token = tokens[place]
        if token == "#":
            start = place + 1 + (place + 1 < len(tokens) and tokens[place + 1] == "!")
            end = closing(tokens, start)
            inside = tokens[start + 1 : end]
            if start == place + 1:
                test |= inside[:1] == ["cfg"] and "test" in inside and "not" not in inside
                test |= inside == ["test"]
            place = end + 1
            continue
        if token == "pub":
            public = True
            place = closing(tokens, place + 1) + 1 if tokens[place + 1] == "(" else place + 1
            continue
        if test:
            place = item_end(tokens, place) + 1
        elif token == "use":
            end = tokens.index(";", place)
            for path, local in flat(tokens[place + 1 : end]):
                module.uses.append(Use(path, local, inline, public))
            place = end + 1
        elif token == "mod" and place + 2 < len(tokens) and tokens[place + 2] in ";{":
            name = tokens[place + 1]
            if tokens[place + 2] == ";":
                child(module, name, directory, crate)
                place += 3
            else:
                end = closing(tokens, place + 2)
                module.declared.add(name)
                scan(module, tokens[place + 3 : end], directory, crate, (*inline, name))
                place = end + 1
        else:
            if token in ITEM and place + 1 < len(tokens):
                at = place + 2 if token == "macro_rules" else place + 1
                module.declared.add(tokens[at])
            place += 1
            # The attribute belongs to the item that follows; `pub`, `unsafe`, `extern` precede its name.
            if token in ("unsafe", "extern", "async", '""'):
                continue
        test, public = False, False


def child(module, name, directory, crate):
    here = directory if module.file.name in ("mod.rs", "lib.rs", "main.rs") or module.name == () else directory / module.file.stem
    for file, inner in ((here / f"{name}.rs", here), (here / name / "mod.rs", here / name)):
        if file.is_file():
            one = Module((*module.name, name), file)
            module.children[name] = one
            read(one, inner, crate)


def target(crate, module, path, inline, seen=()):
    """The module that declares what a path leads to; none for another crate's."""
    if not path:
        return module
    first, rest = path[0], path[1:]
    if first == "crate":
        return follow(crate, crate[()], rest, seen)
    if first == "self":
        return target_inside(crate, module, rest, inline, seen)
    if first == "super":
        if inline:
            return target(crate, module, ("self", *rest) if rest[:1] != ("super",) else rest, inline[:-1], seen)
        return follow_up(crate, crate[module.name[:-1]], rest, seen)
    if first in module.children or first in module.declared:
        return follow(crate, module, path, seen)
    return None


def target_inside(crate, module, path, inline, seen):
    return module if inline else follow(crate, module, path, seen)


def follow_up(crate, module, path, seen):
    if path[:1] == ("super",):
        return follow_up(crate, crate[module.name[:-1]], path[1:], seen)
    return follow(crate, module, path, seen)


def follow(crate, module, path, seen):
    """Down from a module, through what it hands on."""
    for place, name in enumerate(path):
        if name == "*":
            return module
        if name in module.children:
            module = module.children[name]
            continue
        if name in module.declared:
            return module
        key = (module.name, name)
        if key in seen:
            return None
        seen = (*seen, key)
        found = [use for use in module.uses if use.local == name and not use.inline]
        globs = [use for use in module.uses if use.local == "*" and use.public and not use.inline]
        for use in found + globs:
            path_of = use.path if use.local != "*" else (*use.path[:-1], name)
            to = target(crate, module, (*path_of, *path[place + 1 :]), (), seen)
            if to is not None:
                return to
        return None if found or globs else module
    return module


def within(inner, outer):
    """Is the module the other one, or inside it?"""
    return inner[: len(outer)] == outer


def arrows_of(crate):
    """From each module to those that declare what it uses, with the paths."""
    arrows = {}
    for module in crate.values():
        for use in module.uses:
            if use.public and not use.inline:
                continue
            to = target(crate, module, use.path, use.inline)
            if to is not None and not within(to.name, module.name) and not within(module.name, to.name):
                arrows.setdefault((module.name, to.name), []).append("::".join(use.path))
    return arrows


def components(nodes, arrows):
    """Strongly connected components with more than one node, by Tarjan's algorithm without recursion."""
    after = {node: [] for node in nodes}
    for start, end in arrows:
        after[start].append(end)
    index, low, stack, on, found = {}, {}, [], set(), []
    for root in nodes:
        if root in index:
            continue
        work = [(root, iter(after[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        on.add(root)
        while work:
            node, rest = work[-1]
            for other in rest:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on.add(other)
                    work.append((other, iter(after[other])))
                    break
                if other in on:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    one = []
                    while not one or one[-1] != node:
                        one.append(stack.pop())
                        on.discard(one[-1])
                    if len(one) > 1:
                        found.append(sorted(one))
    return sorted(found, key=len, reverse=True)


def crates():
    """Name and root file of each library and program of the workspace."""
    told = subprocess.run(
        ["cargo", "metadata", "--no-deps", "--offline", "--format-version", "1"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )
    for package in sorted(json.loads(told.stdout)["packages"], key=lambda one: one["name"]):
        for one in package["targets"]:
            if {"lib", "rlib", "cdylib", "staticlib", "proc-macro", "bin"} & set(one["kind"]):
                yield package["name"], Path(one["src_path"])


def circles():
    """(crate, circle as its modules, arrows inside) of the workspace; a file that two targets share counts once."""
    seen = set()
    for name, root in crates():
        crate = {}
        read(Module((), root), root.parent, crate)
        arrows = arrows_of(crate)
        for one in components(list(crate), arrows):
            files = frozenset(crate[module].file for module in one)
            if files not in seen:
                seen.add(files)
                inside = {pair: uses for pair, uses in arrows.items() if set(pair) <= set(one)}
                yield name, [crate[module] for module in one], inside


def main(arguments):
    found = list(circles())
    if arguments[:1] == ["--arrows"]:
        for name, one, inside in found:
            if name == arguments[1]:
                print(f"{len(one)} files")
                for (start, end), uses in sorted(inside.items()):
                    print(f"    {'::'.join(start) or 'crate'} → {'::'.join(end) or 'crate'}: {', '.join(sorted(set(uses)))}")
        return 0
    counts = {}
    for name, one, _ in found:
        counts[name] = counts.get(name, 0) + 1
        print(f"{name}: {len(one)} files: {', '.join(map(str, one))}")
    for name, count in sorted(counts.items()):
        print(f"{count:4} {name}")
    print(f"{len(found):4} circles of files")
    if arguments[:1] == ["--check"] and len(found) > int(arguments[1]):
        print(f"at most {arguments[1]} are allowed: move what both sides need to a file below them", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
