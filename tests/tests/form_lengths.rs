//! None of the forms that are compared with outside references takes a user more than 40 lines of code.

use std::fs;
use std::path::Path;

/// Lines of the first forms module of a file: no blank lines, no comments.
fn lines_of_code(source: &str) -> usize {
    let module = source.lines().skip_while(|line| !line.starts_with("#[forms"));
    let module = module.take_while(|line| *line != "}").map(str::trim);
    let lines = module.filter(|line| !line.is_empty() && !line.starts_with("//")).count();
    // And the brace that ends it.
    lines + 1
}

#[test]
fn each_form_is_at_most_40_lines() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("examples");
    let gallery = fs::read_dir(examples.join("forms")).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = gallery.filter(|path| !path.ends_with("lib.rs")).collect();
    // Contact, with one form of the many that the package `forms-contact` has.
    files.push(examples.join("04_signorini.rs"));
    files.sort();
    for path in files {
        let lines = lines_of_code(&fs::read_to_string(&path).unwrap());
        println!("{:30} {lines:3} lines", path.file_name().unwrap().to_string_lossy());
        assert!((5..=40).contains(&lines), "{}: {lines} lines", path.display());
    }
}
