//! Files that appear whole or not at all.

use crate::error::OutputError;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempDir};

/// A file that stands under its name only after [`WholeFile::finish`].
///
/// Until then it is a hidden temporary file in the same folder, which is removed when the writer is dropped.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    temporary: BufWriter<NamedTempFile>,
}

impl WholeFile {
    /// Opens a file that will become `path`. The folder must exist.
    ///
    /// # Errors
    /// [`OutputError::IsFolder`] where `path` is a folder, [`OutputError::Create`] where nothing can be made beside it.
    pub fn create(path: &Path) -> Result<WholeFile, OutputError> {
        if path.is_dir() {
            return Err(OutputError::IsFolder { path: path.to_owned() });
        }
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".sinew-").suffix(".tmp");
        #[cfg(unix)]
        {
            // As for any new file: what the process's mask lets through, not the private mode of temporary files.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let temporary =
            builder.tempfile_in(folder).map_err(|source| OutputError::Create { path: path.to_owned(), source })?;
        Ok(WholeFile { path: path.to_owned(), temporary: BufWriter::new(temporary) })
    }

    /// The name that the file will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// [`OutputError::Write`].
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.temporary.write_all(bytes).map_err(|source| OutputError::Write { path: self.path.clone(), source })
    }

    /// Gives the file its name, replacing what had it.
    ///
    /// # Errors
    /// [`OutputError::Write`] where the last bytes or the renaming fail.
    pub fn finish(self) -> Result<(), OutputError> {
        let WholeFile { path, temporary } = self;
        let failed = |source: io::Error| OutputError::Write { path: path.clone(), source };
        let file = temporary.into_inner().map_err(|e| failed(e.into_error()))?;
        file.persist(&path).map_err(|e| failed(e.error))?;
        Ok(())
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.temporary.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.temporary.flush()
    }
}

/// The files of one run in one folder: all of them get their names with [`FileSet::keep`], or none does.
///
/// Until then they are in a hidden folder inside, so that a run that fails takes nothing away from an earlier one whose
/// files have the same names. Dropped, it removes the hidden folder and the folders that it made.
#[derive(Debug)]
pub struct FileSet {
    folder: PathBuf,
    names: Vec<String>,
    staging: Option<TempDir>,
    made: Vec<PathBuf>,
}

impl FileSet {
    /// Opens a run, and makes `folder` and its parents where they are missing. An empty path is the current folder.
    ///
    /// # Errors
    /// [`OutputError::NotAFolder`] where a file has that name, [`OutputError::Create`] where the system refuses.
    pub fn open(folder: &Path) -> Result<FileSet, OutputError> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut set = FileSet { folder: folder.to_owned(), names: Vec::new(), staging: None, made: Vec::new() };
        set.make(folder)?;
        let staging = tempfile::Builder::new().prefix(".sinew-").suffix(".tmp").tempdir_in(folder);
        set.staging = Some(staging.map_err(|source| OutputError::Create { path: folder.to_owned(), source })?);
        Ok(set)
    }

    fn make(&mut self, folder: &Path) -> Result<(), OutputError> {
        if folder.is_dir() || folder.as_os_str().is_empty() {
            return Ok(());
        }
        if folder.exists() {
            return Err(OutputError::NotAFolder { path: folder.to_owned() });
        }
        if let Some(parent) = folder.parent() {
            self.make(parent)?;
        }
        fs::create_dir(folder).map_err(|source| OutputError::Create { path: folder.to_owned(), source })?;
        self.made.push(folder.to_owned());
        Ok(())
    }

    /// Has `write` write the file that will be `name` in the folder, at a path that it is given.
    ///
    /// # Errors
    /// [`OutputError::IsFolder`] where a folder has that name, else what `write` returns, with the file's own path.
    pub fn write(
        &mut self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let path = self.folder.join(name);
        if path.is_dir() {
            return Err(OutputError::IsFolder { path });
        }
        let staged = self.staging.as_ref().map_or(path.clone(), |staging| staging.path().join(name));
        write(&staged).map_err(|error| error.at(path))?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Ends the run well: every file gets its name. Returns their paths in the order of writing.
    ///
    /// # Errors
    /// [`OutputError::Write`] where a file cannot be given its name; new names are taken back then.
    pub fn keep(mut self) -> Result<Vec<PathBuf>, OutputError> {
        let Some(staging) = self.staging.take() else { return Ok(Vec::new()) };
        let (mut paths, mut new) = (Vec::new(), Vec::new());
        for name in &self.names {
            let path = self.folder.join(name);
            let known = path.exists();
            if let Err(source) = fs::rename(staging.path().join(name), &path) {
                // What cannot be removed is left: the error at hand is the one to report.
                new.iter().for_each(|path| drop(fs::remove_file(path)));
                drop(staging);
                return Err(OutputError::Write { path, source });
            }
            if !known {
                new.push(path.clone());
            }
            paths.push(path);
        }
        self.made.clear();
        Ok(paths)
    }
}

impl Drop for FileSet {
    fn drop(&mut self) {
        // What cannot be removed is left: the error that brought us here is the one to report.
        self.staging = None;
        for folder in self.made.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn stands_under_its_name_only_when_finished() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let mut file = WholeFile::create(&path).unwrap();
        file.put(b"whole").unwrap();
        assert!(!path.exists());
        file.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn dropped_leaves_nothing_and_keeps_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, b"old").unwrap();
        let mut file = WholeFile::create(&path).unwrap();
        file.put(b"half").unwrap();
        drop(file);
        assert_eq!(names(folder.path()), ["a.bin"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn refuses_folders_and_missing_folders() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(WholeFile::create(folder.path()), Err(OutputError::IsFolder { .. })));
        let lost = folder.path().join("none/a.bin");
        let error = WholeFile::create(&lost).unwrap_err();
        assert!(matches!(error, OutputError::Create { .. }));
        assert!(error.to_string().contains("none"), "{error}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_failed_set_is_removed_with_its_folders_and_a_kept_one_stays() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b");
        let write = |text: &str| {
            let mut set = FileSet::open(&folder).unwrap();
            set.write("frame_0000.obj", |path| {
                fs::write(path, text).unwrap();
                Ok(())
            })
            .unwrap();
            set
        };
        drop(write("x"));
        assert!(names(root.path()).is_empty());
        assert_eq!(write("y").keep().unwrap(), [folder.join("frame_0000.obj")]);
        assert_eq!(names(&folder), ["frame_0000.obj"]);
        assert_eq!(fs::read(folder.join("frame_0000.obj")).unwrap(), b"y");
    }

    #[test]
    fn a_failed_set_takes_nothing_from_an_earlier_one() {
        let root = tempfile::tempdir().unwrap();
        let run = |text: &str, last: &str| -> Result<Vec<PathBuf>, OutputError> {
            let mut set = FileSet::open(root.path())?;
            for name in ["0.obj", "1.obj", last] {
                set.write(name, |path| {
                    fs::write(path, text).unwrap();
                    Ok(())
                })?;
            }
            set.keep()
        };
        run("old", "2.obj").unwrap();
        fs::create_dir(root.path().join("3.obj")).unwrap();
        assert!(matches!(run("new", "3.obj"), Err(OutputError::IsFolder { path }) if path.ends_with("3.obj")));
        assert_eq!(names(root.path()), ["0.obj", "1.obj", "2.obj", "3.obj"]);
        assert_eq!(fs::read(root.path().join("0.obj")).unwrap(), b"old");
        run("new", "2.obj").unwrap();
        assert_eq!(fs::read(root.path().join("2.obj")).unwrap(), b"new");
    }

    #[test]
    fn a_set_names_the_path_that_was_asked_for() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("theirs.txt"), b"x").unwrap();
        let error = FileSet::open(&root.path().join("theirs.txt")).unwrap_err();
        assert!(matches!(error, OutputError::NotAFolder { .. }));
        let mut set = FileSet::open(root.path()).unwrap();
        let failed = |path: &Path| Err(OutputError::NotFinite { path: path.to_owned(), frame: 1, vertex: 2 });
        let line = set.write("a.obj", failed).unwrap_err().to_string();
        assert!(line.starts_with(&root.path().join("a.obj").display().to_string()), "{line}");
        drop(set);
        assert_eq!(names(root.path()), ["theirs.txt"]);
    }
}
