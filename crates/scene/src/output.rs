//! Files that are whole or not there: written beside their place, and moved to it when nothing is missing.
//!
//! On Linux a file that is being written has no name in its folder until it is complete, so that a run that is killed leaves
//! nothing behind; where the file system has no such files, it has a name of its own, `.NAME.` and random digits, that only a kill
//! leaves there. Runs into one file do not meet: the file of the last one to end stays. A file that is replaced hands on its permissions,
//! a link stays a link, a device is written through, and pipes and folders are refused.

#[cfg(target_os = "linux")]
mod unnamed;

use std::fs::{self, File, OpenOptions, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("`{}` cannot be written: {reason}", file.display())]
pub struct Unwritten {
    file: PathBuf,
    reason: String,
}

/// Where a file goes.
enum Place {
    /// The file itself, links followed, and its permissions if it is there.
    File(PathBuf, Option<fs::Permissions>),
    /// A device.
    Device,
}

/// Bytes that there must be room for before a run begins.
const ROOM: usize = 1 << 20;

/// Whether a file can be written: its folder takes one and has room, and the file in its place may be replaced.
///
/// # Errors
///
/// [`Unwritten`] with the reason.
pub fn check(file: &Path) -> Result<(), Unwritten> {
    let checked = match place_of(file) {
        Ok(Place::File(file, _)) => PendingFile::new(&file).and_then(|mut part| {
            let written = part.file.write_all(&vec![0; ROOM]);
            part.leave();
            written
        }),
        Ok(Place::Device) => open_device(file).map(drop),
        Err(error) => Err(error),
    };
    checked.map_err(|error| Unwritten { file: file.to_owned(), reason: error.to_string() })
}

/// Writes a file by way of another one in the same folder. Whatever fails, the file is as it was before.
///
/// ```
/// use std::io::Write;
///
/// let file = std::env::temp_dir().join(format!("radgrad-{}.csv", std::process::id()));
/// radgrad_scene::output::write_whole(&file, |out| writeln!(out, "from,to,factor"))?;
/// assert_eq!(std::fs::read_to_string(&file)?, "from,to,factor\n");
/// # std::fs::remove_file(&file)?;
/// # Ok::<_, Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`Unwritten`] with the reason: the system's message, or the error of `content`.
pub fn write_whole<E: ToString>(
    file: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<(), Unwritten> {
    write(file, false, content).map(drop).map_err(|reason| Unwritten { file: file.to_owned(), reason })
}

/// A file that one run alone replaces, again and again, while it lasts. Where files cannot be locked, a second run is not noticed.
#[derive(Debug)]
pub struct Held {
    file: PathBuf,
    /// That in its place, and those before: who opened one of these meanwhile finds it locked.
    locked: Vec<File>,
}

impl Held {
    /// Takes a file, which is empty if there was none.
    ///
    /// # Errors
    /// [`Unwritten`] if another run holds it, or it cannot be opened.
    pub fn take(file: &Path) -> Result<Self, Unwritten> {
        let refused = |reason: String| Unwritten { file: file.to_owned(), reason };
        let mut locked = Vec::new();
        // Elsewhere a lock keeps the file from being read and replaced too.
        if cfg!(unix) {
            let opened = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(file);
            let opened = opened.map_err(|error| refused(error.to_string()))?;
            if let Err(TryLockError::WouldBlock) = opened.try_lock() {
                return Err(refused("another run holds it".to_owned()));
            }
            locked.push(opened);
        }
        Ok(Self { file: file.to_owned(), locked })
    }

    /// Replaces it, as [`write_whole`] does.
    ///
    /// # Errors
    /// As [`write_whole`].
    pub fn write<E: ToString>(&mut self, content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>) -> Result<(), Unwritten> {
        let written = write(&self.file, cfg!(unix), content);
        let written = written.map_err(|reason| Unwritten { file: self.file.clone(), reason })?;
        self.locked.extend(written);
        Ok(())
    }
}

/// The file that was written, unless it is a device; locked if asked for, before it is in its place.
fn write<E: ToString>(
    file: &Path,
    locked: bool,
    content: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
) -> Result<Option<File>, String> {
    let io = |error: io::Error| error.to_string();
    let fill = |out: File| -> Result<File, String> {
        let mut out = BufWriter::new(out);
        content(&mut out).map_err(|error| error.to_string())?;
        out.into_inner().map_err(|error| io(error.into_error()))
    };
    let (file, permissions) = match place_of(file).map_err(io)? {
        Place::File(file, permissions) => (file, permissions),
        Place::Device => return fill(open_device(file).map_err(io)?).map(|_| None),
    };
    let part = PendingFile::new(&file).map_err(io)?;
    let written = part.file.try_clone().map_err(io).and_then(fill).and_then(|out| {
        if let Some(permissions) = permissions {
            out.set_permissions(permissions).map_err(io)?;
        }
        out.sync_all().map_err(io)?;
        if locked {
            // It is new: nobody else has it.
            let _ = out.try_lock();
        }
        Ok(out)
    });
    match written {
        Ok(out) => part.publish(&file).map_err(io).map(|()| Some(out)),
        Err(reason) => {
            part.leave();
            Err(reason)
        }
    }
}

/// Follows links, also to where nothing is yet.
fn place_of(file: &Path) -> io::Result<Place> {
    const MOST_LINKS: usize = 40;
    let refused = |rule: &str| Err(io::Error::new(io::ErrorKind::InvalidInput, rule));
    let mut place = file.to_owned();
    let mut links = 0;
    while let Ok(target) = fs::read_link(&place) {
        links += 1;
        if links > MOST_LINKS {
            return refused("its links lead nowhere");
        }
        place = place.parent().unwrap_or(Path::new("")).join(target);
    }
    let metadata = match fs::metadata(&place) {
        Ok(metadata) => metadata,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Place::File(place, None)),
        Err(error) => return Err(error),
    };
    if metadata.is_file() {
        return match metadata.permissions().readonly() {
            true => refused("it is there and write-protected"),
            false => Ok(Place::File(place, Some(metadata.permissions()))),
        };
    }
    if metadata.is_dir() {
        return refused("it is a folder");
    }
    if is_device(&metadata) { Ok(Place::Device) } else { refused("it is a pipe or a disk: name a file") }
}

#[cfg(unix)]
fn is_device(metadata: &fs::Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&metadata.file_type())
}

#[cfg(not(unix))]
fn is_device(_: &fs::Metadata) -> bool {
    false
}

fn open_device(file: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(file)
}

/// A file that is not yet in its place.
struct PendingFile {
    file: File,
    /// Where it is meanwhile, if it has a name.
    name: Option<PathBuf>,
}

impl PendingFile {
    /// In the folder of a file.
    fn new(file: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(file) = unnamed::create(folder_of(file)) {
            return Ok(Self { file, name: None });
        }
        let (file, name) = named(file, |name| File::create_new(name))?;
        Ok(Self { file, name: Some(name) })
    }

    /// Moves it to its place.
    fn publish(self, file: &Path) -> io::Result<()> {
        let name = match self.name {
            Some(name) => name,
            #[cfg(target_os = "linux")]
            None if unnamed::link(&self.file, file).is_ok() => return Ok(()),
            // A file in that place is replaced in one step, which takes a name: who is killed just then leaves the whole file there.
            #[cfg(target_os = "linux")]
            None => named(file, |name| unnamed::link(&self.file, name))?.1,
            #[cfg(not(target_os = "linux"))]
            None => return Err(io::Error::other("it has no name")),
        };
        fs::rename(&name, file).inspect_err(|_| remove(&name))
    }

    /// Leaves nothing of it.
    fn leave(self) {
        self.name.iter().for_each(|name| remove(name));
    }
}

/// A failure to remove it is passed over: the first error is reported already.
fn remove(part: &Path) {
    let _ = fs::remove_file(part);
}

fn folder_of(file: &Path) -> &Path {
    let folder = file.parent().unwrap_or(Path::new(""));
    if folder == Path::new("") { Path::new(".") } else { folder }
}

/// The result of `make` under a random name beside a file, and that name.
fn named<T>(file: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(T, PathBuf)> {
    let Some(name) = file.file_name() else { return Err(io::Error::new(io::ErrorKind::InvalidInput, "it has no file name")) };
    loop {
        let mut random = RandomState::new().build_hasher();
        random.write_u32(std::process::id());
        let mut part = std::ffi::OsString::from(".");
        // The name with the digits must not be too long for a file system that takes the name.
        part.push(name.to_string_lossy().chars().take(50).collect::<String>());
        part.push(format!(".{:016x}", random.finish()));
        let part = folder_of(file).join(part);
        match make(&part) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            made => return made.map(|made| (made, part)),
        }
    }
}

/// The extension of a file's name, in lower case.
#[must_use]
pub fn extension(file: &Path) -> String {
    file.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("radgrad-output-{name}-{}", std::process::id()));
            fs::create_dir_all(&folder).unwrap();
            Self(folder)
        }

        fn entries(&self) -> usize {
            fs::read_dir(&self.0).unwrap().count()
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn what_fails_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = Folder::new("half");
        let file = folder.0.join("matrix.csv");
        check(&file).unwrap();
        assert_eq!(folder.entries(), 0, "a check leaves nothing");
        write_whole(&file, |out| out.write_all(b"old")).unwrap();
        let failed = write_whole(&file, |out| out.write_all(b"new").and_then(|()| Err(io::Error::other("enough"))));
        assert_eq!(failed.unwrap_err().to_string(), format!("`{}` cannot be written: enough", file.display()));
        assert_eq!((fs::read(&file).unwrap(), folder.entries()), (b"old".to_vec(), 1));
        write_whole(&file, |out| out.write_all(b"new")).unwrap();
        assert_eq!((fs::read(&file).unwrap(), folder.entries()), (b"new".to_vec(), 1));
        let nowhere = folder.0.join("none/matrix.csv");
        assert!(check(&nowhere).is_err() && check(&folder.0).unwrap_err().to_string().ends_with("it is a folder"));
    }

    #[test]
    fn a_named_part_is_moved_or_removed() {
        let folder = Folder::new("named");
        let file = folder.0.join("a.csv");
        let part = || {
            let (file, name) = named(&file, |name| File::create_new(name)).unwrap();
            PendingFile { file, name: Some(name) }
        };
        part().leave();
        assert_eq!(folder.entries(), 0);
        part().publish(&file).unwrap();
        part().publish(&file).unwrap();
        assert_eq!(folder.entries(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_permissions_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};

        let folder = Folder::new("links");
        let [file, link, onward, device] = ["a.csv", "b.csv", "c.csv", "d.csv"].map(|name| folder.0.join(name));
        symlink("a.csv", &link).unwrap();
        symlink(&link, &onward).unwrap();
        symlink("/dev/null", &device).unwrap();
        write_whole(&onward, |out| out.write_all(b"through two links")).unwrap();
        assert!(link.is_symlink() && onward.is_symlink() && !file.is_symlink());
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        write_whole(&link, |out| out.write_all(b"again")).unwrap();
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(fs::read(&file).unwrap(), b"again");
        check(&device).unwrap();
        write_whole(&device, |out| out.write_all(b"nothing")).unwrap();
        assert!(device.is_symlink());
        fs::set_permissions(&file, fs::Permissions::from_mode(0o440)).unwrap();
        assert!(check(&link).unwrap_err().to_string().contains("write-protected"));
        symlink("e.csv", folder.0.join("e.csv")).unwrap();
        assert!(check(&folder.0.join("e.csv")).is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_reported() {
        let error = write_whole(Path::new("/dev/full"), |out| out.write_all(b"x")).unwrap_err().to_string();
        assert!(error.starts_with("`/dev/full` cannot be written: "), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_held_is_not_taken_again_even_after_it_was_replaced() {
        let folder = Folder::new("held");
        let file = folder.0.join("a.json");
        let mut held = Held::take(&file).unwrap();
        for text in ["", "one", "two"] {
            if !text.is_empty() {
                held.write(|out| out.write_all(text.as_bytes())).unwrap();
            }
            assert_eq!((fs::read_to_string(&file).unwrap(), folder.entries()), (text.to_owned(), 1));
            assert!(Held::take(&file).unwrap_err().to_string().ends_with("another run holds it"));
        }
        drop(held);
        let mut next = Held::take(&file).unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "two", "taking it changes nothing");
        next.write(|out| out.write_all(b"three")).unwrap();
    }

    #[test]
    fn runs_into_one_file_leave_one_of_them_whole() {
        let folder = Folder::new("many");
        let file = folder.0.join("a.csv");
        let text = |run: usize| run.to_string().repeat(10_000);
        std::thread::scope(|scope| {
            for run in 0..8 {
                let file = &file;
                scope.spawn(move || (0..20).for_each(|_| write_whole(file, |out| out.write_all(text(run).as_bytes())).unwrap()));
            }
        });
        let read = fs::read_to_string(&file).unwrap();
        assert!((0..8).any(|run| read == text(run)));
        assert_eq!(folder.entries(), 1);
    }
}
