//! Atomic output files: complete or absent; pipes and devices are written through.
//!
//! A temporary file is locked while it is written, so that one whose lock is free was left behind by a process that
//! was killed. The next writer of the same name removes it. Process ids would not do: containers that share a
//! directory all have id 1.

use std::collections::hash_map::DefaultHasher;
use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions};
use std::hash::{Hash as _, Hasher as _};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
#[cfg(unix)]
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};

/// Ending of temporary names.
const TEMPORARY: &str = ".tmp";

/// Bytes of a file name that leave room for the temporary ending: file systems take 255.
const LONGEST_NAME: usize = 200;

/// Bytes of a longer name that its temporary name begins with.
const PREFIX: usize = 160;

/// Symbolic links followed from one to the next, as Linux does.
const MAX_LINKS: usize = 40;

/// A file written under a temporary name beside its target and renamed on [`AtomicFile::commit`].
///
/// Dropped without a commit, it removes what it wrote: a reader never sees half a file. A target that is a symbolic
/// link stays one: the file that it points to is replaced. Pipes and devices are no files that a rename could
/// replace, so that they are written as the bytes come.
#[derive(Debug)]
pub struct AtomicFile {
    writer: Option<BufWriter<File>>,
    /// Temporary name, and that of the target; none where the target is written through.
    names: Option<(PathBuf, PathBuf)>,
}

impl AtomicFile {
    /// Starts writing `target`, creating its directory if needed.
    ///
    /// # Errors
    /// If the target is a directory, or the directory or the temporary file cannot be created.
    pub fn create(target: impl Into<PathBuf>) -> io::Result<Self> {
        let (file, names) = match resolve(&target.into())? {
            Place::Through(path) => (through(&path)?, None),
            Place::File(target) => {
                if let Some(parent) = target.parent() {
                    fs::create_dir_all(parent)?;
                }
                let (temporary, file) = create_temporary(&target)?;
                (file, Some((temporary, target)))
            }
        };
        // Rows and events come in small pieces: a large buffer saves system calls.
        Ok(Self { writer: Some(BufWriter::with_capacity(1 << 18, file)), names })
    }

    /// Flushes to disk and gives the file its name.
    ///
    /// # Errors
    /// If the disk is full or the rename fails; the target is then untouched.
    pub fn commit(mut self) -> io::Result<()> {
        let writer = self.writer.take().ok_or_else(|| io::Error::other("already committed"))?;
        let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
        let Some((temporary, target)) = &self.names else { return Ok(()) };
        // The content reaches the disk first: after a power cut, a name must not lead to nothing.
        file.sync_all()?;
        #[cfg(debug_assertions)]
        abort::at_counted_write();
        fs::rename(temporary, target)?;
        // Another process may have a file of this temporary name by now: it is not ours to remove.
        self.names = None;
        Ok(())
    }

    fn writer(&mut self) -> io::Result<&mut BufWriter<File>> {
        self.writer.as_mut().ok_or_else(|| io::Error::other("already committed"))
    }
}

/// Kills of the process in tests, which no build for users has.
#[cfg(debug_assertions)]
mod abort {
    use std::sync::LazyLock;
    use std::sync::atomic::{AtomicU64, Ordering};

    /// The write, counted from 1, before whose rename the process aborts.
    const VARIABLE: &str = "EVPOSE_ABORT_AT_WRITE";

    static AT: LazyLock<Option<u64>> = LazyLock::new(|| std::env::var(VARIABLE).ok()?.parse().ok());
    static WRITES: AtomicU64 = AtomicU64::new(0);

    pub(super) fn at_counted_write() {
        // As a kill between two writes: nothing is flushed or removed.
        if *AT == Some(1 + WRITES.fetch_add(1, Ordering::Relaxed)) {
            std::process::abort();
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.as_mut().map_or(Ok(()), Write::flush)
    }
}

/// For formats whose header stores offsets of later parts: not to pipes and devices.
impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if self.names.is_none() {
            let reason = "this format goes back to its header, which a pipe or device cannot: \
                          write to a file";
            return Err(io::Error::new(ErrorKind::NotSeekable, reason));
        }
        self.writer()?.seek(to)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        let writer = self.writer.take();
        if let Some((temporary, _)) = &self.names {
            // Gone already after a commit; otherwise nothing more can be done about a failure here.
            // Before the lock is given up, with which another process would take it for abandoned.
            let _ = fs::remove_file(temporary);
        }
        // Not flushed: what is given up need not reach the disk, and a pipe's reader may be stuck.
        writer.map(BufWriter::into_parts);
    }
}

/// Destination of the bytes for a path.
enum Place {
    /// A file, that there is or that will be, behind all links.
    File(PathBuf),
    /// A pipe or device, or a file that the process has open.
    Through(PathBuf),
}

/// Opens a pipe or device. Of what the process has open, such as standard output in a file, another opening would
/// have a position of its own, and what is printed later would lie over what was written.
fn through(path: &Path) -> io::Result<File> {
    // Appending does not truncate a file that the shell has opened for the process.
    let opened = OpenOptions::new().append(true).open(path)?;
    #[cfg(unix)]
    for stream in [io::stdout().as_fd(), io::stderr().as_fd()] {
        let own = File::from(stream.try_clone_to_owned()?);
        if is_same(&own.metadata()?, path, &opened.metadata()?, path) {
            return Ok(own);
        }
    }
    Ok(opened)
}

/// Follows the links of `path`; a directory is an error.
fn resolve(path: &Path) -> io::Result<Place> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        // `/dev/stdout` leads here: its file is open, and a rename would part it from the shell's.
        if path.starts_with("/proc") || path.starts_with("/dev/fd") {
            return Ok(Place::Through(path));
        }
        match fs::symlink_metadata(&path) {
            Ok(found) if found.is_symlink() => {
                let to = fs::read_link(&path)?;
                path = path.parent().unwrap_or(Path::new("")).join(to);
            }
            Ok(found) if found.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => return Ok(Place::Through(path)),
            Ok(_) => return Ok(Place::File(path)),
            // Also below what is no directory: creating it then says so.
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Place::File(path)),
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// Whether two paths lead to one file, which need not be there yet: by device and inode, so through links and under
/// two names; elsewhere than on Unix by the canonical path. Devices such as `/dev/null` do not count: they hold
/// nothing that could be lost or mixed.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a_is), Ok(b_is)) => !is_device(&a_is) && is_same(&a_is, a, &b_is, b),
        (Err(_), Err(_)) => canonical(a).zip(canonical(b)).is_some_and(|(a, b)| a == b),
        _ => false,
    }
}

#[cfg(unix)]
fn is_device(metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    metadata.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    false
}

#[cfg(unix)]
fn is_same(a: &Metadata, _: &Path, b: &Metadata, _: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_same(_: &Metadata, a: &Path, _: &Metadata, b: &Path) -> bool {
    fs::canonicalize(a).ok().zip(fs::canonicalize(b).ok()).is_some_and(|(a, b)| a == b)
}

/// The place of a file that is not there yet, behind links. Folders that are not there yet stay as they are written.
fn canonical(path: &Path) -> Option<PathBuf> {
    let Place::File(path) = resolve(path).ok()? else { return None };
    let absolute = std::path::absolute(path).ok()?;
    let folder = absolute
        .ancestors()
        // The path itself is not there yet; the nearest folder that is has the links to follow.
        .skip(1)
        .find_map(|folder| fs::canonicalize(folder).ok().map(|canonical| (folder, canonical)));
    let (folder, canonical) = folder?;
    Some(canonical.join(absolute.strip_prefix(folder).ok()?))
}

/// Creates a file beside `target` under a name not in use, and locks it.
fn create_temporary(target: &Path) -> io::Result<(PathBuf, File)> {
    let stem = short_name(target);
    let named = |attempt: u32| {
        let mut name = stem.clone();
        name.push(format!(".0-{attempt}{TEMPORARY}"));
        target.with_file_name(name)
    };
    let mut attempt = 0;
    loop {
        let temporary = named(attempt);
        match File::create_new(&temporary) {
            // Before it had its lock, another writer may have taken it for abandoned, and begun its own under this
            // name. File systems that know no locks keep what was left behind.
            Ok(file) => match file.try_lock() {
                Err(fs::TryLockError::WouldBlock) => attempt += 1,
                _ if !is_still(&temporary, &file) => {}
                _ => {
                    // Two writers may have been killed at once,
                    // and the second one had the next name.
                    remove_abandoned(&named(attempt + 1));
                    return Ok((temporary, file));
                }
            },
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                if !remove_abandoned(&temporary) {
                    attempt += 1;
                }
            }
            Err(error) => return Err(error),
        }
    }
}

/// Removes a temporary file that nobody writes any more. Returns whether it did.
fn remove_abandoned(temporary: &Path) -> bool {
    // Not a link or a pipe that somebody else put there: those are neither opened nor removed.
    let is_file = |metadata: &Metadata| metadata.is_file();
    if !fs::symlink_metadata(temporary).as_ref().is_ok_and(is_file) {
        return false;
    }
    let Ok(file) = OpenOptions::new().write(true).open(temporary) else { return false };
    if file.try_lock().is_err() {
        return false;
    }
    // Between opening and locking, another process may have removed this one and begun its own.
    is_still(temporary, &file) && fs::remove_file(temporary).is_ok()
}

/// Removes the temporary files of a folder that nobody writes any more: those of processes that were killed. Elsewhere the
/// next writer of the same name does so, which a shorter set of files may not have.
///
/// # Errors
/// If the folder cannot be listed.
pub fn remove_abandoned_files(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_name().to_str().and_then(temporary_target).is_some() {
            remove_abandoned(&entry.path());
        }
    }
    Ok(())
}

/// Whether a path still leads to a file that was opened by it.
fn is_still(path: &Path, file: &File) -> bool {
    let (opened, found) = (file.metadata(), fs::symlink_metadata(path));
    opened.ok().zip(found.ok()).is_some_and(|(a, b)| is_same(&a, path, &b, path))
}

/// The name of a file, of a long one its beginning and a hash.
fn short_name(target: &Path) -> OsString {
    let name = target.file_name().unwrap_or_default();
    if name.len() <= LONGEST_NAME {
        return name.to_owned();
    }
    // The hash distinguishes long names that begin alike.
    let mut hasher = DefaultHasher::new();
    name.hash(&mut hasher);
    let text = name.to_string_lossy();
    let end = text.floor_char_boundary(PREFIX);
    format!("{}~{:016x}", &text[..end], hasher.finish()).into()
}

/// The target's name of a temporary file of [`AtomicFile`], of a long name its beginning; none for other names.
/// Identifies the files that a killed process leaves behind.
pub fn temporary_target(name: &str) -> Option<&str> {
    // Split from the end, since the name of the target may contain dots.
    let (target, tag) = name.strip_suffix(TEMPORARY)?.rsplit_once('.')?;
    let (before, attempt) = tag.split_once('-')?;
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    (number(before) && number(attempt) && !target.is_empty()).then_some(target)
}

/// Writes `bytes` to `target` through a temporary name.
///
/// # Errors
/// As [`AtomicFile`].
pub fn atomic_write(target: impl AsRef<Path>, bytes: &[u8]) -> io::Result<()> {
    let mut file = AtomicFile::create(target.as_ref())?;
    file.write_all(bytes)?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn temporary(file: &AtomicFile) -> &Path {
        &file.names.as_ref().unwrap().0
    }

    #[test]
    fn two_writers_of_one_target_do_not_share_a_temporary_file() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("0007.evc");
        let mut writers = [(); 2].map(|()| AtomicFile::create(&target).unwrap());
        for (writer, text) in writers.iter_mut().zip(["first", "second"]) {
            writer.write_all(text.as_bytes()).unwrap();
        }
        let [first, second] = writers;
        second.commit().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "second");
        first.commit().unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "first");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "no temporary file stays");
    }

    #[test]
    fn a_file_appears_whole_when_it_is_committed_and_not_before() {
        let directory = tempfile::tempdir().unwrap();
        let target = directory.path().join("new/0007.evc");
        let entries = || fs::read_dir(target.parent().unwrap()).unwrap().count();
        let mut file = AtomicFile::create(&target).unwrap();
        file.write_all(b"size of what follows").unwrap();
        file.seek(SeekFrom::Start(0)).unwrap();
        file.write_all(b"four").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read(temporary(&file)).unwrap(), b"four of what follows");
        assert!(!target.exists() && entries() == 1);
        file.commit().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"four of what follows");
        drop(AtomicFile::create(&target).unwrap());
        assert_eq!(entries(), 1, "given up, it leaves what was there");
        atomic_write(&target, b"other").unwrap();
        assert_eq!((fs::read(&target).unwrap(), entries()), (b"other".to_vec(), 1));
    }

    #[test]
    fn a_file_that_cannot_be_created_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        assert!(AtomicFile::create(directory.path().join("x".repeat(256))).is_err());
        let file = directory.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(AtomicFile::create(file.join("below")).is_err());
    }

    #[test]
    fn a_temporary_name_contains_its_target_and_other_names_do_not() {
        let directory = tempfile::tempdir().unwrap();
        let writer = AtomicFile::create(directory.path().join("a.b.evc")).unwrap();
        let name = temporary(&writer).file_name().unwrap().to_str().unwrap();
        assert_eq!(temporary_target(name), Some("a.b.evc"));
        for name in ["a.b.evc", "notes.tmp", "notes.1.tmp", ".1-0.tmp", "x.1-a.tmp", "x.-.tmp"] {
            assert_eq!(temporary_target(name), None, "{name}");
        }
    }

    #[test]
    fn the_next_writer_removes_what_a_killed_one_left_and_not_what_is_being_written() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        let count = || fs::read_dir(directory.path()).unwrap().count();
        // Two writers were killed at once.
        for left in ["x.csv.0-0.tmp", "x.csv.0-1.tmp", "y.csv.0-0.tmp"] {
            fs::write(at(left), "half").unwrap();
        }
        let first = AtomicFile::create(at("x.csv")).unwrap();
        assert_eq!(temporary(&first), at("x.csv.0-0.tmp"));
        assert_eq!(fs::metadata(temporary(&first)).unwrap().len(), 0);
        assert_eq!(count(), 2, "that of another name stays");
        let second = AtomicFile::create(at("x.csv")).unwrap();
        assert_eq!(temporary(&second), at("x.csv.0-1.tmp"), "the first is still written");
        drop(first);
        second.commit().unwrap();
        assert_eq!(count(), 2);
    }

    #[test]
    fn long_names_have_a_temporary_one_that_fits() {
        let directory = tempfile::tempdir().unwrap();
        for name in ["x".repeat(255), "ü".repeat(120), "x".repeat(200)] {
            let target = directory.path().join(&name);
            atomic_write(&target, b"whole").unwrap();
            assert_eq!(fs::read(&target).unwrap(), b"whole");
            let file = AtomicFile::create(&target).unwrap();
            let temporary = temporary(&file).file_name().unwrap().to_str().unwrap();
            assert!(name.starts_with(&temporary_target(temporary).unwrap()[..100]), "{temporary}");
        }
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 3);
        // Two long names that begin alike do not share one.
        let names = ["a", "b"].map(|end| short_name(Path::new(&("x".repeat(240) + end))));
        assert_ne!(names[0], names[1]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_pipes_are_written_through() {
        use std::io::Read as _;
        use std::os::unix::fs::{FileTypeExt as _, symlink};
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::create_dir(at("below")).unwrap();
        symlink("below/new.csv", at("to-new")).unwrap();
        symlink("to-new", at("link")).unwrap();
        for text in ["not there yet", "there"] {
            atomic_write(at("link"), text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(at("below/new.csv")).unwrap(), text);
        }
        assert!(fs::symlink_metadata(at("link")).unwrap().is_symlink());
        assert_eq!(atomic_write(at("below"), b"").unwrap_err().kind(), ErrorKind::IsADirectory);
        symlink("loop", at("loop")).unwrap();
        assert!(atomic_write(at("loop"), b"").is_err());

        let made = std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap();
        assert!(made.success());
        symlink("pipe", at("to-pipe")).unwrap();
        let (end, path) = (std::sync::mpsc::channel(), at("pipe"));
        let reader = std::thread::spawn(move || {
            let mut text = String::new();
            let mut pipe = File::open(path).unwrap();
            let mut first = [0; 5];
            pipe.read_exact(&mut first).unwrap();
            end.0.send(first).unwrap();
            pipe.read_to_string(&mut text).unwrap();
            text
        });
        let mut file = AtomicFile::create(at("to-pipe")).unwrap();
        file.write_all(b"first").unwrap();
        file.flush().unwrap();
        // Its reader has them before the end.
        assert_eq!(&end.1.recv().unwrap(), b"first");
        assert_eq!(file.seek(SeekFrom::Start(0)).unwrap_err().kind(), ErrorKind::NotSeekable);
        file.write_all(b"then").unwrap();
        file.commit().unwrap();
        assert_eq!(reader.join().unwrap(), "then");
        assert!(fs::symlink_metadata(at("pipe")).unwrap().file_type().is_fifo());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_is_the_same_by_any_of_its_names() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::create_dir(at("below")).unwrap();
        fs::write(at("a"), "").unwrap();
        fs::write(at("b"), "").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        std::os::unix::fs::symlink(at("a"), at("soft")).unwrap();
        std::os::unix::fs::symlink("below", at("folder")).unwrap();
        std::os::unix::fs::symlink("below/new", at("dangling")).unwrap();
        let same = [
            ("a", "a"),
            ("a", "below/../a"),
            ("a", "hard"),
            ("hard", "soft"),
            ("below/new", "folder/new"),
            ("below/new", "dangling"),
            ("below/deep/new", "folder/deep/new"),
        ];
        for (one, other) in same {
            assert!(is_same_file(&at(one), &at(other)), "{one} {other}");
        }
        for (one, other) in [("a", "b"), ("a", "new"), ("new", "below/new")] {
            assert!(!is_same_file(&at(one), &at(other)), "{one} {other}");
        }
        assert!(!is_same_file(Path::new("/dev/null"), Path::new("/dev/null")));
    }

    #[test]
    fn files_of_killed_processes_are_removed_and_those_in_use_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["0001.png.0-0.tmp", "notes.tmp", "0002.png"] {
            fs::write(at(name), "x").unwrap();
        }
        let file = AtomicFile::create(at("0003.png")).unwrap();
        remove_abandoned_files(folder.path()).unwrap();
        assert!(!at("0001.png.0-0.tmp").exists() && at("notes.tmp").exists());
        assert!(at("0002.png").exists() && temporary(&file).exists());
    }
}
