//! The calls between `Problem::solve` and the kernel of a point, counted from a stack that a form's own function in Rust writes.
//!
//! `CARGO_PROFILE_DEV_DEBUG=line-tables-only cargo test -p forms-tests calls_of_an_entry -- --nocapture` prints them with their files,
//! those that are inlined as well. Without tables of lines a stack has no inlined calls, and modules take the place of files.

use std::backtrace::Backtrace;
use std::collections::BTreeSet;
use std::sync::Mutex;

use forms_fem::prelude::*;

/// The stacks of all calls of `stiffening`, each once.
static STACKS: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// 1 + s², which leaves the stack from which it is called.
pub fn stiffening<R: Real>(s: R) -> R {
    STACKS.lock().unwrap().insert(Backtrace::force_capture().to_string());
    s * s + 1.0
}

#[forms(dimension = 2)]
mod conduction {
    extern "Rust" {
        fn stiffening(s: Scalar) -> Scalar;
    }
    #[cells]
    pub struct Omega;
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, stiffening(u) * dot(grad(u), grad(v)) - v)
    }
}

/// A call: the function, and its file, or without tables of lines its module.
struct Call {
    function: String,
    file: String,
}

/// The calls of a stack within the library, the innermost first, up to `Problem::solve`. Closures count as their function.
fn calls(stack: &str) -> Vec<Call> {
    let root = std::fs::canonicalize(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).unwrap();
    let root = format!("{}/", root.display());
    let mut found: Vec<Call> = vec![];
    let mut lines = stack.lines().peekable();
    while let Some(line) = lines.next() {
        let Some((_, name)) = line.trim().split_once(": ") else { continue };
        let place = lines.next_if(|next| next.trim_start().starts_with("at "));
        let file = match place.map(|place| place.trim().trim_start_matches("at ")) {
            Some(place) => match place.strip_prefix(&root) {
                Some(own) => own.split(':').next().unwrap_or_default().to_owned(),
                None => continue,
            },
            None => name.rsplit_once("::").map_or("", |(module, _)| module).to_owned(),
        };
        let of_library = file.contains("forms_problem") || file.starts_with("fem/");
        if of_library && !name.contains("closure") {
            found.push(Call { function: name.to_owned(), file });
        }
        let is_last = found.last().is_some_and(|Call { function, file }| {
            let name = function.rsplit("::").next().unwrap_or_default();
            name.starts_with("solve") && file.contains("problem") && file.contains("solution")
        });
        if is_last {
            break;
        }
    }
    found
}

/// Numbers of calls, inlined ones included, and of files: limits to be lowered when a call or a file falls.
const MOST: usize = 18;
const MOST_FILES: usize = 9;

#[test]
fn calls_of_an_entry() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let model = conduction::Model::default();
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", |_| 0.0)?;
    Problem::new(&model.balance(), &space).constrained(&constraints).threads(Threads::new(1)).solve()?;
    let stacks = STACKS.lock().unwrap();
    let of_tangents = stacks.iter().filter(|stack| stack.contains("write_tangent"));
    let longest = of_tangents.map(|stack| calls(stack)).max_by_key(Vec::len).ok_or("no tangent")?;
    for Call { function, file } in &longest {
        println!("{file:70} {function}");
    }
    let files: BTreeSet<&str> = longest.iter().map(|call| call.file.as_str()).collect();
    println!("{} calls in {} files", longest.len(), files.len());
    assert!(longest.len() > 8 && longest.len() <= MOST, "{} calls", longest.len());
    let has_files = files.iter().all(|file| file.ends_with(".rs"));
    assert!(!has_files || files.len() <= MOST_FILES, "{} files", files.len());
    Ok(())
}
