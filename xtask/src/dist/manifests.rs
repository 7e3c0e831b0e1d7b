//! Manifests of a release for package managers: a formula for Homebrew, three files for winget.

use std::error::Error;
use std::fs;
use std::path::Path;

use super::Metadata;
use super::system::{Family, System};

/// System and the SHA-256 of its archive, in hex.
pub(super) type BuiltArchive = (System, String);

/// Version of winget's schemas.
const WINGET_SCHEMA_VERSION: &str = "1.9.0";

/// Returns the download address of an archive. The manifest of `magician-cli` gives `cargo
/// binstall` the same one.
fn url(metadata: &Metadata, system: &System) -> String {
    let (repository, version) = (&metadata.repository, &metadata.version);
    let (name, ending) = (system.archive(version), system.ending());
    format!("{repository}/releases/download/v{version}/{name}.{ending}")
}

/// Returns the Homebrew formula for macOS and Linux, `magician.rb`; `None` without archives for
/// them.
pub(super) fn formula(metadata: &Metadata, made: &[BuiltArchive]) -> Option<String> {
    let block = |triple: &str| {
        let (system, sha256) = made.iter().find(|(system, _)| system.triple == triple)?;
        let url = url(metadata, system);
        Some(format!("url \"{url}\"\n      sha256 \"{sha256}\""))
    };
    let [mac_arm, mac_intel, linux_arm, linux_intel] = [
        "aarch64-apple-darwin",
        "x86_64-apple-darwin",
        "aarch64-unknown-linux-gnu",
        "x86_64-unknown-linux-gnu",
    ]
    .map(block);
    Some(format!(
        r##"class Magician < Formula
  desc "{description}"
  homepage "{repository}"
  version "{version}"
  license any_of: ["MIT", "Apache-2.0"]

  on_macos do
    on_arm do
      {}
    end
    on_intel do
      {}
    end
  end

  on_linux do
    on_arm do
      {}
    end
    on_intel do
      {}
    end
  end

  def install
    bin.install "bin/magician"
    man1.install Dir["man/*.1"]
    bash_completion.install "completions/magician.bash" => "magician"
    zsh_completion.install "completions/_magician"
    fish_completion.install "completions/magician.fish"
    pkgshare.install "licenses", "README.txt"
    pkgshare.install "udev" if OS.linux?
    pkgshare.install "service"
  end

  test do
    assert_match version.to_s, shell_output("#{{bin}}/magician --version")
    system bin/"magician", "move", "220", "40", "30", "--port", "sim"
  end
end
"##,
        mac_arm?,
        mac_intel?,
        linux_arm?,
        linux_intel?,
        description = metadata.description,
        repository = metadata.repository,
        version = metadata.version,
    ))
}

/// Returns winget's identifier: owner and name of the repository.
fn identifier(repository: &str) -> Result<(String, String), Box<dyn Error>> {
    let mut parts = repository.trim_end_matches('/').rsplit('/');
    match (parts.next(), parts.next()) {
        (Some(name), Some(owner)) if !name.is_empty() && !owner.is_empty() => {
            Ok((owner.to_owned(), format!("{owner}.{name}")))
        }
        _ => Err(format!("no owner and name in {repository}").into()),
    }
}

/// Name and text of a file.
type NamedFile = (String, String);

/// Returns the three files of winget.
pub(super) fn winget(
    metadata: &Metadata,
    made: &[BuiltArchive],
) -> Result<Option<[NamedFile; 3]>, Box<dyn Error>> {
    let Some((system, sha256)) = made
        .iter()
        .find(|(system, _)| system.family == Family::Windows)
    else {
        return Ok(None);
    };
    let (publisher, id) = identifier(&metadata.repository)?;
    let (version, repository) = (&metadata.version, &metadata.repository);
    let file = |kind: &str, body: &str| {
        let schema = format!(
            "# yaml-language-server: $schema=https://aka.ms/winget-manifest.{kind}.{WINGET_SCHEMA_VERSION}.schema.json"
        );
        format!(
            "{schema}\n\nPackageIdentifier: {id}\nPackageVersion: {version}\n{body}ManifestType: {kind}\nManifestVersion: {WINGET_SCHEMA_VERSION}\n"
        )
    };
    let installer = format!(
        "InstallerType: zip\nNestedInstallerType: portable\nNestedInstallerFiles:\n\
         - RelativeFilePath: {}\\bin\\magician.exe\n  PortableCommandAlias: magician\n\
         Installers:\n- Architecture: x64\n  InstallerUrl: {}\n  InstallerSha256: {}\n",
        system.archive(version),
        url(metadata, system),
        sha256.to_uppercase(),
    );
    let locale = format!(
        "PackageLocale: en-US\nPublisher: {publisher}\nPackageName: magician\nPackageUrl: {repository}\n\
         License: {}\nShortDescription: \"{}\"\nTags:\n- dobot\n- magician\n- robot\n",
        metadata.licence, metadata.description,
    );
    Ok(Some([
        (
            format!("{id}.yaml"),
            file("version", "DefaultLocale: en-US\n"),
        ),
        (
            format!("{id}.installer.yaml"),
            file("installer", &installer),
        ),
        (
            format!("{id}.locale.en-US.yaml"),
            file("defaultLocale", &locale),
        ),
    ]))
}

/// Writes the manifests whose archives were built. Returns the names of the files.
pub(super) fn write(
    metadata: &Metadata,
    made: &[BuiltArchive],
    folder: &Path,
) -> Result<Vec<String>, Box<dyn Error>> {
    let mut written = Vec::new();
    if let Some(text) = formula(metadata, made) {
        fs::write(folder.join("magician.rb"), text)?;
        written.push("magician.rb".to_owned());
    }
    if let Some(files) = winget(metadata, made)? {
        let home = folder.join("winget");
        fs::create_dir_all(&home)?;
        for (name, text) in files {
            fs::write(home.join(&name), text)?;
            written.push(format!("winget/{name}"));
        }
    }
    Ok(written)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::dist::system::SYSTEMS;

    pub(in crate::dist) fn metadata() -> Metadata {
        Metadata {
            target_directory: "target".into(),
            host: "x86_64-unknown-linux-gnu".to_owned(),
            version: "1.2.3".to_owned(),
            repository: "https://forge.test/somebody/magician".to_owned(),
            description: "The magician command".to_owned(),
            licence: "MIT OR Apache-2.0".to_owned(),
        }
    }

    fn built_archives() -> Vec<BuiltArchive> {
        let sums = (0..).map(|number| format!("{number:064x}"));
        SYSTEMS.into_iter().zip(sums).collect()
    }

    #[test]
    fn formula_lists_four_archives_with_their_checksums() {
        let made = built_archives();
        let text = formula(&metadata(), &made).expect("all are there");
        for (system, sha256) in &made {
            let entry = format!(
                "url \"https://forge.test/somebody/magician/releases/download/v1.2.3/magician-1.2.3-{}.tar.gz\"\n      sha256 \"{sha256}\"",
                system.triple
            );
            assert_eq!(
                text.matches(&entry).count(),
                usize::from(system.ending() != "zip")
            );
        }
        assert_eq!(formula(&metadata(), &made[1..]), None);
    }

    #[test]
    fn winget_manifest_has_the_repository_owner_and_the_program_in_the_zip() {
        let [version, installer, locale] = winget(&metadata(), &built_archives())
            .expect("an identifier")
            .expect("the archive is there");
        assert_eq!(version.0, "somebody.magician.yaml");
        assert_eq!(installer.0, "somebody.magician.installer.yaml");
        let path = r"magician-1.2.3-x86_64-pc-windows-gnu\bin\magician.exe";
        assert!(installer.1.contains(path), "{}", installer.1);
        assert!(locale.1.contains("Publisher: somebody\n"), "{}", locale.1);
        for (_, text) in [version, installer, locale] {
            assert!(
                text.contains("\nPackageIdentifier: somebody.magician\nPackageVersion: 1.2.3\n")
            );
        }
    }

    #[test]
    fn a_repository_without_an_owner_has_no_identifier() {
        assert!(identifier("magician").is_err());
    }
}
