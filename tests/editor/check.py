#!/usr/bin/env python3
"""Checks what an editor shows inside the bodies of forms, by asking rust-analyzer about the starter.

    python3 tests/editor/check.py [RUST_ANALYZER] [--seconds N]

Asks, over the language server protocol, for the definition, the hover text and completions of names in the form of
`starter/src/main.rs`. Needs rust-analyzer (default: the one in PATH) and the toolchain's server of procedural macros.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
STARTER = ROOT / "starter"
SOURCE = STARTER / "src" / "main.rs"


# What a server answers while the text that it was asked about is still changing: ask again.
SUPERSEDED = (-32801, -32802)


class Server:
    """A language server, asked one thing after the other."""

    def __init__(self, program, seconds):
        self.seconds = seconds
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.number, self.answers, self.arrived = 0, {}, threading.Condition()
        self.quiescent = False
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        while True:
            length = None
            while line := self.process.stdout.readline().strip():
                name, _, value = line.decode().partition(":")
                length = int(value) if name.lower() == "content-length" else length
            if length is None:
                return
            message = json.loads(self.process.stdout.read(length))
            with self.arrived:
                if "id" in message and "method" in message:
                    self.write({"id": message["id"], "result": None})
                elif "id" in message:
                    self.answers[message["id"]] = message
                elif message.get("method") == "experimental/serverStatus":
                    self.quiescent = message["params"]["quiescent"]
                self.arrived.notify_all()

    def write(self, message):
        text = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(text) + text)
        self.process.stdin.flush()

    def tell(self, method, parameters):
        self.write({"method": method, "params": parameters})

    def ask(self, method, parameters):
        end = time.monotonic() + self.seconds
        while True:
            self.number += 1
            number = self.number
            self.write({"id": number, "method": method, "params": parameters})
            with self.arrived:
                if not self.arrived.wait_for(lambda: number in self.answers, timeout=end - time.monotonic()):
                    sys.exit(f"no answer to {method}")
                answer = self.answers.pop(number)
            if answer.get("error", {}).get("code") not in SUPERSEDED:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']['message']}")
                return answer.get("result")

    def wait_until_quiescent(self):
        with self.arrived:
            if not self.arrived.wait_for(lambda: self.quiescent, timeout=self.seconds):
                sys.exit(f"rust-analyzer was not ready after {self.seconds} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default="rust-analyzer")
    parser.add_argument("--seconds", type=int, default=900, help="the longest time for one answer")
    options = parser.parse_args()
    text = SOURCE.read_text()
    server = Server(options.program, options.seconds)
    server.ask("initialize", {
        "processId": os.getpid(),
        "rootUri": STARTER.as_uri(),
        "capabilities": {
            "experimental": {"serverStatusNotification": True},
            "textDocument": {
                "hover": {"contentFormat": ["plaintext"]},
                "completion": {"completionItem": {"snippetSupport": False}},
            },
        },
        "initializationOptions": {"checkOnSave": False, "cachePriming": {"enable": False}},
    })
    server.tell("initialized", {})
    uri = SOURCE.as_uri()
    server.tell("textDocument/didOpen", {
        "textDocument": {"uri": uri, "languageId": "rust", "version": 1, "text": text},
    })
    start = time.monotonic()
    server.wait_until_quiescent()
    print(f"ready after {time.monotonic() - start:.0f} s")

    def place(around, word, source=text):
        offset = source.index(around) + around.index(word)
        line = source.count("\n", 0, offset)
        return {"line": line, "character": offset - (source.rfind("\n", 0, offset) + 1)}

    def at(around, word):
        return {"textDocument": {"uri": uri}, "position": place(around, word)}

    failures = []

    def check(what, found, wanted):
        good = wanted in found
        print(f"{'ok    ' if good else 'FAILED'} {what}: {found[:110]!r}")
        if not good:
            failures.append(what)

    def definition(around, word):
        found = server.ask("textDocument/definition", at(around, word)) or []
        lines = []
        for link in found if isinstance(found, list) else [found]:
            path = pathlib.Path((link.get("targetUri") or link["uri"]).removeprefix("file://"))
            line = (link.get("targetSelectionRange") or link["range"])["start"]["line"]
            lines.append(f"{path.name}: {path.read_text().splitlines()[line].strip()}")
        return "; ".join(lines)

    def hover(around, word):
        found = server.ask("textDocument/hover", at(around, word))
        return " ".join(found["contents"]["value"].split()) if found else ""

    for case in CASES:
        check(f"definition of `{case['word']}`", definition(case["around"], case["word"]), case["definition"])
        check(f"hover over `{case['word']}`", hover(case["around"], case["word"]), case["hover"])
    # A name that is being typed: all of the text is sent anew, as editors may.
    around = "conductivity(t) * dot(grad(t), grad(v))"
    for version, (before, after) in enumerate(COMPLETIONS, start=2):
        edited = text.replace(around, before + after, 1)
        server.tell("textDocument/didChange", {
            "textDocument": {"uri": uri, "version": version}, "contentChanges": [{"text": edited}],
        })
        position = place(before + after, after, edited)
        found = server.ask("textDocument/completion", {"textDocument": {"uri": uri}, "position": position})
        items = found["items"] if isinstance(found, dict) else found or []
        labels = [item["label"] for item in items if item["label"].startswith("gr")]
        for wanted in COMPLETED:
            check(f"completion of `{before}`", " ".join(labels), wanted)
    server.process.kill()
    sys.exit("\n".join(failures) if failures else 0)


# Names in the form, the text where they are declared, and their documentation.
CASES = [
    {"around": "conductivity(t) * dot(", "word": "dot", "definition": "operators.rs", "hover": "Product over the last axis"},
    {"around": "dot(grad(t), grad(v))", "word": "grad", "definition": "operators.rs", "hover": "Gradient"},
    {"around": "1 + growth * t", "word": "growth", "definition": "pub growth: Param", "hover": "growth: Scalar"},
    {"around": "-conductivity(t)", "word": "conductivity", "definition": "fn conductivity", "hover": "fn conductivity"},
    {"around": "integral(Plate,", "word": "Plate", "definition": "pub struct Plate", "hover": "Plate"},
    {"around": "- source * v)", "word": "v", "definition": "v: Test<Scalar>", "hover": "v: "},
]
# Text up to the cursor and after it: a name that nobody knows yet, none at all, the middle of another.
COMPLETIONS = [
    ("conductivity(t) * gr", " * dot(grad(t), grad(v))"),
    ("conductivity(t) * ", "dot(grad(t), grad(v))"),
    ("conductivity(t) * dot(gr", "ad(t), grad(v))"),
]
COMPLETED = ["growth", "grad"]

if __name__ == "__main__":
    main()
