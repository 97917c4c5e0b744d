//! Code blocks of the pages for users. They are compiled here, each next to what its page takes for granted.

// Pages borrow what is borrowed here already. What they show is compiled, and not run.
#![allow(dead_code, clippy::needless_borrow, clippy::redundant_closure, clippy::needless_borrows_for_generic_args, clippy::let_and_return)]

mod adaptivity;
mod bounds;
mod branches;
mod contact;
mod cut;
mod dynamics;
mod gap_pressures;
mod histories;
mod language;
mod mean_gaps;
mod mortar;
mod rubber;
mod sliding_histories;
mod smooth;
// The law of `docs/new_contact_law.md` is a crate of its own.
#[path = "../../contact_law/src/tresca.rs"]
mod tresca;

/// The pages with blocks in Rust, and what compiles them elsewhere.
const PAGES: [(&str, Option<&str>); 23] = [
    ("adaptivity", None),
    ("bounds", None),
    ("coming_from", Some("the documentation tests of this crate")),
    ("contact_between_bodies", None),
    ("contact_with_adjoint", Some("the program of that name")),
    ("continuation", None),
    ("cut_domains", None),
    ("eigenproblems", None),
    ("friction", None),
    ("gap_pressures", None),
    ("inverse_problems", None),
    ("language", None),
    ("level_set_descent", None),
    ("mean_gaps", None),
    ("mesh_parts", Some("the documentation test of `MeshPart`")),
    ("mortar", None),
    ("nearly_incompressible", None),
    ("new_contact_law", None),
    ("points_segments_means", None),
    ("python", Some("the example of the bindings")),
    ("sliding_histories", None),
    ("smooth_formulations", None),
    ("time", None),
];

/// Code without comments, white space and commas at the end of a list.
fn bare(code: &str) -> String {
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    let code: String = lines.flat_map(str::chars).filter(|c| !c.is_whitespace()).collect();
    code.replace(",)", ")").replace(",}", "}")
}

/// The blocks in Rust of a page.
fn blocks(page: &str) -> Vec<&str> {
    let pieces = page.split("```").skip(1).step_by(2);
    pieces.filter(|block| block.starts_with("rust")).filter_map(|block| Some(block.split_once('\n')?.1)).collect()
}

#[test]
fn every_block_of_a_page_is_compiled() {
    let compiled = [
        include_str!("adaptivity.rs"),
        include_str!("bounds.rs"),
        include_str!("branches.rs"),
        include_str!("contact.rs"),
        include_str!("cut.rs"),
        include_str!("dynamics.rs"),
        include_str!("gap_pressures.rs"),
        include_str!("histories.rs"),
        include_str!("language.rs"),
        include_str!("mean_gaps.rs"),
        include_str!("mortar.rs"),
        include_str!("rubber.rs"),
        include_str!("sliding_histories.rs"),
        include_str!("smooth.rs"),
        include_str!("../../contact_law/src/tresca.rs"),
    ];
    let compiled = bare(&compiled.concat());
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs");
    let mut found = vec![];
    for entry in std::fs::read_dir(directory).expect("the pages are there") {
        let path = entry.expect("it can be read").path();
        let name = path.file_stem().expect("it has a name").to_string_lossy().into_owned();
        let Ok(page) = std::fs::read_to_string(&path) else { continue };
        let blocks = if path.extension().is_some_and(|end| end == "md") { blocks(&page) } else { vec![] };
        if blocks.is_empty() {
            continue;
        }
        let listed = PAGES.iter().find(|(page, _)| *page == name);
        let (_, elsewhere) = listed.unwrap_or_else(|| panic!("docs/{name}.md is not in the list of pages"));
        // What a block has between empty lines may be in two places, as a module and the code that uses it; a module may have more functions.
        let pieces = blocks.iter().filter(|_| elsewhere.is_none()).flat_map(|block| block.split("\n\n"));
        for piece in pieces {
            assert!(compiled.contains(bare(piece).trim_end_matches('}')), "docs/{name}.md has code that is compiled nowhere:\n{piece}");
        }
        found.push(name);
    }
    assert_eq!(found.len(), PAGES.len(), "pages with code: {found:?}");
}
