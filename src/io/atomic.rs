//! Files that appear whole or not at all.

use crate::error::OutputError;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

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

/// The files of one run: removed again, with the folders made for them, unless [`FileSet::keep`] is reached.
#[derive(Debug, Default)]
pub struct FileSet {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl FileSet {
    /// A run that has written nothing yet.
    pub fn new() -> FileSet {
        FileSet::default()
    }

    /// Makes `folder` and its parents where they are missing.
    ///
    /// # Errors
    /// [`OutputError::NotAFolder`] where a file has that name, [`OutputError::Create`] where the system refuses.
    pub fn folder(&mut self, folder: &Path) -> Result<(), OutputError> {
        if folder.is_dir() || folder.as_os_str().is_empty() {
            return Ok(());
        }
        if folder.exists() {
            return Err(OutputError::NotAFolder { path: folder.to_owned() });
        }
        if let Some(parent) = folder.parent() {
            self.folder(parent)?;
        }
        fs::create_dir(folder).map_err(|source| OutputError::Create { path: folder.to_owned(), source })?;
        self.folders.push(folder.to_owned());
        Ok(())
    }

    /// Notes a whole file that this run has written.
    pub fn wrote(&mut self, path: &Path) {
        self.files.push(path.to_owned());
    }

    /// Files written so far.
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Ends the run well: everything stays. Returns the files in the order of writing.
    pub fn keep(mut self) -> Vec<PathBuf> {
        self.folders.clear();
        std::mem::take(&mut self.files)
    }
}

impl Drop for FileSet {
    fn drop(&mut self) {
        // What cannot be removed is left: the error that brought us here is the one to report.
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        for folder in self.folders.iter().rev() {
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
        let write = |set: &mut FileSet| {
            set.folder(&folder).unwrap();
            let path = folder.join("frame_0000.obj");
            fs::write(&path, b"x").unwrap();
            set.wrote(&path);
        };
        let mut failed = FileSet::new();
        write(&mut failed);
        drop(failed);
        assert!(names(root.path()).is_empty());
        let mut good = FileSet::new();
        write(&mut good);
        assert_eq!(good.keep().len(), 1);
        assert_eq!(names(&folder), ["frame_0000.obj"]);
    }

    #[test]
    fn a_set_spares_files_it_did_not_write() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("theirs.txt"), b"x").unwrap();
        let mut set = FileSet::new();
        set.folder(root.path()).unwrap();
        drop(set);
        assert_eq!(names(root.path()), ["theirs.txt"]);
        let mut set = FileSet::new();
        let error = set.folder(&root.path().join("theirs.txt")).unwrap_err();
        assert!(matches!(error, OutputError::NotAFolder { .. }));
    }
}
