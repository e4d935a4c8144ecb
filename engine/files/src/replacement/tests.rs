use super::*;
use std::sync::atomic::AtomicU32;

/// A folder of its own for a test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let name = format!("petzval-files-{}-{}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, text).unwrap();
        path
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn put(place: &Path, text: &str) -> io::Result<()> {
    write(place, |file| file.write_all(text.as_bytes()))
}

#[test]
fn a_file_is_replaced_by_a_complete_one() {
    let folder = Folder::new();
    let place = folder.0.join("picture.exr");
    put(&place, "first").unwrap();
    let replacement = Replacement::new(&place).unwrap();
    fs::write(replacement.part(), "second").unwrap();
    assert_eq!(fs::read_to_string(&place).unwrap(), "first");
    replacement.commit().unwrap();
    assert_eq!(fs::read_to_string(&place).unwrap(), "second");
    assert_eq!(folder.names(), ["picture.exr"]);
}

#[test]
fn an_error_leaves_the_old_file_and_nothing_else() {
    let folder = Folder::new();
    let place = folder.file("old", "old");
    let failed = write(&place, |file| {
        file.write_all(b"half")?;
        Err(io::Error::from(ErrorKind::StorageFull))
    });
    assert_eq!(failed.unwrap_err().kind(), ErrorKind::StorageFull);
    drop(Replacement::new(&place).unwrap());
    assert_eq!(fs::read_to_string(&place).unwrap(), "old");
    assert_eq!(folder.names(), ["old"]);
}

#[test]
fn leftovers_of_killed_processes_go_and_those_at_work_stay() {
    let folder = Folder::new();
    folder.file(".petzval-1-0.part", "half");
    folder.file(".petzval-notes.txt", "not ours");
    let at_work = Replacement::new(&folder.0.join("a")).unwrap();
    put(&folder.0.join("b"), "b").unwrap();
    assert!(at_work.part().exists());
    let own = at_work.part().file_name().unwrap().to_str().unwrap().to_owned();
    assert_eq!(folder.names(), [own, ".petzval-notes.txt".into(), "b".into()]);
}

#[test]
fn what_is_no_file_is_refused() {
    let folder = Folder::new();
    assert_eq!(check_place(&folder.0).unwrap_err().kind(), ErrorKind::IsADirectory);
    assert_eq!(put(&folder.0.join("none/a"), "").unwrap_err().kind(), ErrorKind::NotFound);
    let long = "n".repeat(300);
    assert!(check_place(&folder.0.join(long)).is_err());
    check_place(&folder.0.join("new")).unwrap();
    assert!(folder.names().is_empty());
}

#[test]
fn a_check_makes_no_file_and_removes_none() {
    use std::sync::atomic::AtomicBool;
    let folder = Folder::new();
    let place = folder.0.join("a new one: 1*.exr");
    let is_over = AtomicBool::new(false);
    let was_seen = std::thread::scope(|threads| {
        let watcher = threads.spawn(|| {
            let mut was_seen = false;
            while !is_over.load(Ordering::Relaxed) {
                was_seen |= place.exists();
            }
            was_seen
        });
        for _ in 0..2000 {
            // A Windows file system refuses the name.
            assert_eq!(check_place(&place).is_ok(), cfg!(unix));
        }
        is_over.store(true, Ordering::Relaxed);
        watcher.join().unwrap()
    });
    assert!(!was_seen);
    assert!(folder.names().is_empty());
}

#[test]
fn odd_characters_of_a_name_are_tried_once_each() {
    assert_eq!(signs_of(Path::new("folder?/what: a \"name\"? größe.exr")), " \".:?ßö");
    assert_eq!(signs_of(Path::new("plain1")), "");
    assert!(signs_of(Path::new(&"äöüßàáâãåæçèéêëìíîïð".repeat(3))).len() <= 64);
}

#[cfg(unix)]
#[test]
fn devices_are_refused_links_followed_and_permissions_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    assert!(check_place(Path::new("/dev/null")).is_err());
    let target = folder.file("target", "old");
    fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.0.join("link");
    std::os::unix::fs::symlink(&target, &link).unwrap();
    put(&link, "new").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&target).unwrap(), "new");
    assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o640);
}

#[cfg(windows)]
#[test]
fn a_file_that_another_program_holds_stays_as_it_is() {
    use std::os::windows::fs::OpenOptionsExt;
    let folder = Folder::new();
    let place = folder.file("größe 1.lens", "old");
    assert!(place.to_str().unwrap().contains(":\\"), "a path with its drive");
    let held = OpenOptions::new().read(true).share_mode(0).open(&place).unwrap();
    assert!(put(&place, "new").is_err());
    drop(held);
    assert_eq!(fs::read_to_string(&place).unwrap(), "old");
    assert_eq!(folder.names(), ["größe 1.lens"]);
    put(&place, "new").unwrap();
    assert_eq!(fs::read_to_string(&place).unwrap(), "new");
}

#[cfg(windows)]
#[test]
fn one_file_has_many_spellings() {
    let folder = Folder::new();
    folder.file("Picture.exr", "old");
    let spelled = format!("{}/PICTURE.EXR", folder.0.display());
    put(Path::new(&spelled), "new").unwrap();
    assert_eq!(folder.names().len(), 1);
    assert_eq!(fs::read_to_string(folder.0.join("picture.exr")).unwrap(), "new");
}

#[test]
fn another_identity_after_each_replacement() {
    let folder = Folder::new();
    let place = folder.file("a", "1");
    let first = crate::Identity::of(&place).unwrap();
    assert_eq!(first, crate::Identity::of(&place).unwrap());
    put(&place, "1").unwrap();
    assert_ne!(first, crate::Identity::of(&place).unwrap());
}

#[test]
fn files_are_read_up_to_a_bound() {
    let folder = Folder::new();
    let file = folder.file("text", "12345");
    assert_eq!(crate::read_bounded(&file, 5).unwrap(), b"12345");
    assert_eq!(crate::read_bounded(&file, 4).unwrap_err().kind(), ErrorKind::FileTooLarge);
    assert!(crate::read_bounded(Path::new("/dev/zero"), 100).is_err());
    fs::write(&file, [0xff, 0xfe]).unwrap();
    assert_eq!(crate::read_text_bounded(&file, 9).unwrap_err().kind(), ErrorKind::InvalidData);
}
