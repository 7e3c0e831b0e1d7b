//! Publishes the crates to the registry in order of their dependencies, unless something is not
//! ready.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::{Metadata, cargo, run};
use crate::studio::modules;

/// `publish [--dry-run]`: `cargo publish --workspace`.
///
/// # Errors
/// Returns an error while the workspace has no repository address, or the changelog has no entry
/// for the version. Cargo itself refuses uncommitted changes.
pub(crate) fn publish(words: &[String], root: &Path) -> Result<(), Box<dyn Error>> {
    let mut publish = Command::new(cargo());
    publish.current_dir(root);
    publish.args(["publish", "--workspace", "--locked"]);
    match words {
        [] => {}
        [word] if word == "--dry-run" => drop(publish.arg(word)),
        _ => return Err("publish [--dry-run]".into()),
    }
    let metadata = Metadata::read(&cargo(), root)?;
    let changelog = fs::read_to_string(root.join("CHANGELOG.md"))?;
    match refusal(&metadata, &changelog) {
        Some(reason) => Err(format!("not published: {reason}").into()),
        None => {
            modules::write(root)?;
            run(&mut publish)
        }
    }
}

/// Returns the reason why nothing may be published yet; `None` if all is ready.
fn refusal(metadata: &Metadata, changelog: &str) -> Option<String> {
    if metadata.unpublished() {
        return Some("fill in `repository` under [workspace.package] in Cargo.toml".to_owned());
    }
    let heading = format!("## {}", metadata.version);
    let known = changelog.lines().any(|line| {
        line.strip_prefix(&heading)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
    });
    (!known).then(|| format!("CHANGELOG.md has no heading `{heading}`"))
}

#[cfg(test)]
mod tests {
    use super::super::manifests::tests::metadata;
    use super::refusal;

    #[test]
    fn publishing_needs_a_repository_and_a_changelog_chapter() {
        let mut metadata = metadata();
        assert_eq!(refusal(&metadata, "## 1.2.3\n"), None);
        assert_eq!(refusal(&metadata, "## 1.2.3 (2030-01-01)\n"), None);
        let reason = refusal(&metadata, "## Unreleased\n## 1.2.30\n");
        assert_eq!(
            reason.as_deref(),
            Some("CHANGELOG.md has no heading `## 1.2.3`")
        );
        metadata.repository = "https://example.invalid/owner/magician".to_owned();
        let reason = refusal(&metadata, "## 1.2.3\n").expect("a reason");
        assert!(reason.contains("repository"), "{reason}");
    }
}
