//! Installs the frei0r plug-in for this user.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run::{cargo, run};
use crate::{Result, root, target};

/// Builds the plug-in and puts it into `folder`, by default the one in which hosts look for plug-ins of this user.
///
/// # Errors
/// When it cannot be built or written.
pub(crate) fn frei0r(folder: Option<&str>) -> Result<()> {
    let home = || std::env::var_os("HOME").map(|home| Path::new(&home).join(".frei0r-1/lib"));
    let folder = folder.map(PathBuf::from).or_else(home).ok_or("HOME is not set: name a folder")?;
    run(cargo(root()).args(["build", "--locked", "--release", "-p", "polyreel-frei0r"]))?;
    let name =
        format!("{}polyreel_frei0r{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let installed = place(&target().join("release").join(name), &folder)?;
    println!("{}", installed.display());
    Ok(())
}

/// Puts the library `built` into `folder` under the name that hosts show. It is renamed into its place, so that a host
/// that has loaded the one before goes on with that.
fn place(built: &Path, folder: &Path) -> Result<PathBuf> {
    let installed = folder.join(format!("polyreel{}", std::env::consts::DLL_SUFFIX));
    let new = installed.with_extension("new");
    let failed = |error| format!("{}: {error}", installed.display());
    fs::create_dir_all(folder).map_err(failed)?;
    fs::copy(built, &new).and_then(|_| fs::rename(&new, &installed)).map_err(failed)?;
    Ok(installed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_takes_the_place_of_the_one_before() {
        let folder = std::env::temp_dir().join(format!("polyreel-install-{}", std::process::id()));
        let built = folder.join("built");
        fs::create_dir_all(&folder).expect("a folder");
        for words in ["old", "new"] {
            fs::write(&built, words).expect("a file");
            let installed = place(&built, &folder.join("lib")).expect("installed");
            assert_eq!(fs::read_to_string(&installed).expect("a file"), words);
        }
        let entries = fs::read_dir(folder.join("lib")).expect("a folder").count();
        assert_eq!(entries, 1);
        fs::remove_dir_all(&folder).expect("a folder");
    }
}
