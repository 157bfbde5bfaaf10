use super::*;

/// A folder of one test, which goes with it.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = env::temp_dir().join(format!("dualbody-cache-{}-{test}", process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }

    fn files(&self) -> Vec<PathBuf> {
        let all = fs::read_dir(&self.0).expect("the folder");
        all.map(|entry| entry.expect("an entry").path()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn write(text: &str) -> impl FnOnce(&Path) -> Result<(), FileError> {
    move |path| fs::write(path, text).map_err(FileError::at(path))
}

fn folder_of(text: &str) -> impl FnOnce(&Path) -> Result<(), FileError> {
    move |path| {
        fs::create_dir(path).map_err(FileError::at(path))?;
        write(text)(&path.join("file"))
    }
}

#[test]
fn paths_are_those_of_the_texts_and_their_order() {
    let cache = Cache::new("folder");
    let path = cache.path("f", ["ab", "c"]);
    assert_eq!(path, cache.path("f", ["ab", "c"]));
    for other in [["a", "bc"], ["c", "ab"], ["ab", "d"]] {
        assert_ne!(path, cache.path("f", other));
    }
    assert_ne!(path, cache.path("f", ["ab", "c", ""]));
    assert_ne!(path, cache.path("g", ["ab", "c"]));
    // SHA-256 of nothing, FIPS 180-4.
    let nothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
    let expected = Path::new("folder").join(format!("f-{nothing}"));
    assert_eq!(cache.path("f", []), expected);
}

#[test]
fn a_file_is_replaced_and_of_two_folders_the_first_stays() {
    let folder = Folder::new("kept");
    let cache = Cache::new(&folder.0);
    let (file, inner) = (cache.path("file", []), cache.path("folder", []));
    for text in ["first", "second"] {
        cache.keep(&file, write(text)).expect("a file");
        assert_eq!(fs::read_to_string(&file).expect("a file"), text);
        cache.keep(&inner, folder_of(text)).expect("a folder");
        assert_eq!(
            fs::read_to_string(inner.join("file")).expect("a file"),
            "first"
        );
    }
    assert_eq!(folder.files().len(), 2);
}

#[test]
fn only_the_owner_may_write_to_the_folder() {
    let folder = Folder::new("private");
    let cache = Cache::new(folder.0.join("inner"));
    cache
        .keep(&cache.path("file", []), write("text"))
        .expect("a file");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(folder.0.join("inner")).expect("the folder");
        assert_eq!(mode.permissions().mode() & 0o777, 0o700);
    }
}

#[test]
fn what_fails_leaves_nothing_and_says_where() {
    let folder = Folder::new("failed");
    let cache = Cache::new(&folder.0);
    let path = cache.path("half", []);
    let half = |path: &Path| {
        folder_of("half")(path)?;
        Err(FileError::at(path)(io::Error::other("no more")))
    };
    let error = cache.keep(&path, half).expect_err("an error");
    assert!(error.to_string().ends_with("no more"), "{error}");
    assert!(folder.files().is_empty(), "{:?}", folder.files());
    let half = |path: &Path| {
        write("half")(path)?;
        Err(FileError::at(path)(io::Error::other("no more")))
    };
    cache.keep(&path, half).expect_err("an error");
    assert!(folder.files().is_empty(), "{:?}", folder.files());

    fs::write(folder.0.join("file"), "").expect("a file");
    let none = Cache::new(folder.0.join("file"));
    let error = none
        .keep(&none.path("f", []), write("text"))
        .expect_err("no folder");
    assert_eq!(error.path, folder.0.join("file"));
}

#[test]
fn programs_that_make_the_same_at_once_read_whole_files() {
    const WRITERS: usize = 4;
    let folder = Folder::new("at_once");
    let cache = Cache::new(&folder.0);
    let path = cache.path("file", []);
    let text = "whole ".repeat(10_000);
    std::thread::scope(|scope| {
        for _ in 0..WRITERS {
            scope.spawn(|| {
                cache.keep(&path, write(&text)).expect("a file");
                assert_eq!(fs::read_to_string(&path).expect("a file"), text);
            });
        }
    });
    assert_eq!(folder.files(), [path]);
}
