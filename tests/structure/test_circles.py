"""The circles of small crates, written here."""

import tempfile
import unittest
from pathlib import Path

import circles


def names(files):
    """The circles of a crate of these files, as lists of module paths."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        root, crate = Path(folder, "lib.rs"), {}
        circles.read(circles.Module((), root), root.parent, crate)
        found = circles.components(list(crate), circles.arrows_of(crate))
    return [["::".join(module) for module in one] for one in found]


class Circles(unittest.TestCase):
    def test_two_files_use_each_other(self):
        files = {"lib.rs": "mod a; mod b;", "a.rs": "use crate::b::B;\npub struct A;", "b.rs": "use super::a::A; pub struct B;"}
        self.assertEqual(names(files), [["a", "b"]])

    def test_one_way_is_none(self):
        files = {"lib.rs": "mod a; mod b;", "a.rs": "use crate::b::{self, B};", "b.rs": "pub struct B;"}
        self.assertEqual(names(files), [])

    def test_what_is_handed_on_belongs_to_where_it_is_declared(self):
        files = {
            "lib.rs": "mod room; mod a;",
            "room/mod.rs": "mod b; mod c; pub use b::B; pub use self::c::*;",
            "room/b.rs": "pub struct B;",
            "room/c.rs": "use crate::a::A; pub struct C;",
            "a.rs": "use crate::room::B; pub struct A;",
        }
        self.assertEqual(names(files), [])
        files["a.rs"] = "use crate::room::{B, C}; pub struct A;"
        self.assertEqual(names(files), [["a", "room::c"]])

    def test_a_module_and_its_own_are_no_circle(self):
        files = {"lib.rs": "mod a;", "a.rs": "mod b; use b::B; pub struct A;", "a/b.rs": "use super::A; pub struct B;"}
        self.assertEqual(names(files), [])

    def test_tests_comments_and_strings_do_not_count(self):
        files = {
            "lib.rs": "mod a; mod b;",
            "a.rs": 'use crate::b::B; pub struct A; const C: (char, &str) = (\'"\', "use crate::b;");',
            "b.rs": "// use crate::a::A;\npub struct B;\n#[cfg(test)]\nuse crate::a::A;\n#[cfg(test)]\nmod tests { use crate::a::A; }",
        }
        self.assertEqual(names(files), [])

    def test_modules_inside_a_file(self):
        files = {
            "lib.rs": "mod a; mod b;",
            "a.rs": "pub mod inner { pub use super::super::b::B; use super::C; } struct C;",
            "b.rs": "pub struct B; fn f() { use crate::a::inner; }",
        }
        self.assertEqual(names(files), [["a", "b"]])

    def test_a_longer_circle_is_one(self):
        files = {"lib.rs": "mod a; mod b; mod c; mod d;"}
        for name, other in ["ab", "bc", "ca", "da"]:
            files[f"{name}.rs"] = f"use super::{other}::X as Y; pub enum X {{}}"
        self.assertEqual(names(files), [["a", "b", "c"]])


if __name__ == "__main__":
    unittest.main()
