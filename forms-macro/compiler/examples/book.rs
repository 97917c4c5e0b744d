//! The preprocessor of the book: `mdbook build docs` runs it.
//!
//! A line `<!-- program: path -->` of a page becomes the program's head comment, the formulas of its forms modules and its
//! text, so that the book shows the programs that run. Links to files outside the book lead to the repository where
//! `book.toml` has its address, and are text where it has none.

use std::error::Error;
use std::io::Write;
use std::path::{Component, Path, PathBuf};

use quote::ToTokens;
use serde_json::Value;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    // mdBook asks whether a format is supported: every one is.
    if std::env::args().nth(1).as_deref() == Some("supports") {
        return Ok(());
    }
    let (context, mut book): (Value, Value) = serde_json::from_reader(std::io::stdin().lock())?;
    let text = |pointer: &str| context.pointer(pointer).and_then(Value::as_str).unwrap_or_default();
    let pages = Pages {
        sources: Path::new(text("/root")).join(text("/config/book/src")),
        repository: text("/config/output/html/git-repository-url").trim_end_matches('/').to_string(),
    };
    pages.rewrite(&mut book)?;
    writeln!(std::io::stdout(), "{book}")?;
    Ok(())
}

struct Pages {
    /// The directory of the pages.
    sources: PathBuf,
    /// The repository's address, empty where there is none.
    repository: String,
}

impl Pages {
    /// Rewrites the text of each chapter below a value.
    fn rewrite(&self, value: &mut Value) -> Outcome<()> {
        if let Some(chapter) = value.get_mut("Chapter") {
            let page = chapter["path"].as_str().map(PathBuf::from);
            if let (Some(page), Some(content)) = (page, chapter["content"].as_str()) {
                let directory = page.parent().unwrap_or(Path::new("")).to_path_buf();
                let content = self.programs(content, &directory)?;
                chapter["content"] = self.links(&content, &directory).into();
            }
        }
        match value {
            Value::Array(items) => items.iter_mut().try_for_each(|item| self.rewrite(item)),
            Value::Object(members) => members.values_mut().try_for_each(|member| self.rewrite(member)),
            _ => Ok(()),
        }
    }

    fn programs(&self, content: &str, directory: &Path) -> Outcome<String> {
        let mut text = String::new();
        for line in content.lines() {
            let program = line.strip_prefix("<!-- program: ").and_then(|rest| rest.strip_suffix(" -->"));
            match program {
                Some(path) => {
                    let place = self.sources.join(directory).join(path);
                    let source = std::fs::read_to_string(&place)
                        .map_err(|error| format!("{}: {error}", place.display()))?;
                    text += &tutorial(&source).map_err(|error| format!("{}: {error}", place.display()))?;
                }
                None => text += line,
            }
            text.push('\n');
        }
        Ok(text)
    }

    /// Links that leave the book, outside code, become links into the repository, or their text.
    fn links(&self, content: &str, directory: &Path) -> String {
        let mut code = false;
        let lines = content.lines().map(|line| {
            code ^= line.trim_start().starts_with("```");
            if code { line.to_string() } else { self.links_of_line(line, directory) }
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    fn links_of_line(&self, line: &str, directory: &Path) -> String {
        let (mut text, mut rest) = (String::new(), line);
        while let Some(middle) = rest.find("](") {
            let (Some(start), Some(length)) = (rest[..middle].rfind('['), rest[middle..].find(')')) else {
                break;
            };
            let (label, target) = (&rest[start + 1..middle], &rest[middle + 2..middle + length]);
            text += &rest[..start];
            match outside(directory, target) {
                Some(path) if self.repository.is_empty() => text += &format!("{label} (`{path}`)"),
                Some(path) => text += &format!("[{label}]({}/blob/main/{path})", self.repository),
                // mdBook calls a directory's first page so, and links to it by its name here.
                None => text += &rest[start..=middle + length].replace("README.md", "index.html"),
            }
            rest = &rest[middle + length + 1..];
        }
        text + rest
    }
}

/// The path from the repository's root of a link that leaves the book's directory, which is one below the root.
fn outside(directory: &Path, target: &str) -> Option<String> {
    let file = target.split('#').next().unwrap_or_default();
    if file.is_empty() || file.contains("://") {
        return None;
    }
    let mut parts: Vec<&str> = directory.iter().filter_map(|part| part.to_str()).collect();
    let mut left = false;
    for component in Path::new(file).components() {
        match component {
            Component::ParentDir => left |= parts.pop().is_none(),
            Component::Normal(part) => parts.push(part.to_str()?),
            _ => (),
        }
    }
    left.then(|| parts.join("/"))
}

/// The page of a program.
fn tutorial(source: &str) -> Outcome<String> {
    let head: Vec<&str> = source.lines().map_while(|line| line.strip_prefix("//!")).collect();
    let prose: Vec<&str> = head.iter().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
    let mut page = prose.join("\n");
    for item in syn::parse_file(source)?.items {
        let syn::Item::Mod(mut module) = item else {
            continue;
        };
        let Some(place) = module.attrs.iter().position(|attribute| attribute.path().is_ident("forms")) else {
            continue;
        };
        let attribute = match module.attrs.remove(place).meta {
            syn::Meta::List(list) => list.tokens,
            _ => Default::default(),
        };
        page += &format!("\n\n## The forms of `{}`\n", module.ident);
        for (name, formula) in forms_compiler::mathml(attribute, module.to_token_stream())? {
            page += &format!(
                "\n**`{name}`**\n\n<div style=\"overflow: auto hidden; padding: 0.5em 0\">\n{formula}\n</div>\n"
            );
        }
    }
    let program = source.lines().skip(head.len()).collect::<Vec<_>>().join("\n");
    Ok(format!("{page}\n\n## The program\n\n```rust,ignore\n{}\n```\n", program.trim()))
}
