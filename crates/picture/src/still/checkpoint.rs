//! What is done of a still, in memory for a while and in a file, so that it can go on after whatever ended the program.

use super::Strip;
use super::identity::{Part, SampleShare, SumsHeader};
use super::sums_file::{Found, SUM_BYTES, SumsError, SumsFile, header_of};
use eosphor_scene::SceneData;
use std::collections::VecDeque;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Sums of strips that are done but not in the file yet take at most so much memory.
const MAX_WAITING_BYTES: usize = 128 << 20;

/// The file of what is done of the picture at `path`: `out.png.part`.
pub fn checkpoint_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// The file of some samples of the picture at `path`: `out.png.0-64.sums`.
pub fn sample_share_path(path: &Path, samples: &Range<u32>) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}-{}.sums", samples.start, samples.end));
    name.into()
}

/// Records of the strip in work.
#[derive(Clone, Debug, Default)]
struct InWork {
    rows: Range<u32>,
    offsets: Vec<u64>,
    newest: usize,
}

/// What is done of a still, in memory for a while and in a file, which is made when there is something to be kept.
pub struct Checkpoint {
    path: PathBuf,
    /// Without, nothing is kept.
    keeps: bool,
    scene: Arc<SceneData>,
    part: Part,
    share: Option<SampleShare>,
    /// Hashing a large scene takes a while, and many stills are done before it is needed.
    header: OnceLock<SumsHeader>,
    interval: Duration,
    /// Bytes of sums that may wait.
    max_waiting_bytes: usize,
    /// When all was written last, or it began: what was done since then may be lost where the program is killed.
    written: Instant,
    file: Option<SumsFile>,
    /// There is a file of an earlier render, which is not gone on with.
    has_other: bool,
    in_work: InWork,
    /// Strips that are whole and not in the file.
    waiting: VecDeque<Strip>,
    /// Why writing has failed.
    failed: Option<SumsError>,
}

impl Checkpoint {
    /// For a picture, or a part of it, or a share of its samples, kept at `path` and written every `interval` at most. To
    /// `resume`, with what is in the file, if there is one.
    ///
    /// # Errors
    ///
    /// [`SumsError::Stale`] where the file is of something else, or has more samples of a pixel than the scene;
    /// [`SumsError::InUse`] where another process has it, also where nothing is to be resumed.
    pub fn open(
        path: &Path,
        (scene, part): (Arc<SceneData>, Part),
        share: Option<SampleShare>,
        interval: Duration,
        resume: bool,
    ) -> Result<Checkpoint, SumsError> {
        let mut checkpoint = Checkpoint {
            path: path.to_owned(),
            keeps: true,
            part,
            share,
            interval,
            ..Checkpoint::nowhere(scene)
        };
        match SumsFile::open(path) {
            Ok(Found::Nothing) => {}
            Ok(Found::Sums(file)) if resume => checkpoint.go_on(*file)?,
            Ok(_) => checkpoint.has_other = !resume,
            Err(SumsError::Malformed { .. }) if !resume => checkpoint.has_other = true,
            Err(error) => return Err(error),
        }
        Ok(checkpoint)
    }

    /// A checkpoint that keeps nothing: no file is written.
    pub fn nowhere(scene: Arc<SceneData>) -> Checkpoint {
        Checkpoint {
            path: PathBuf::new(),
            keeps: false,
            scene,
            part: Part::default(),
            share: None,
            header: OnceLock::new(),
            interval: Duration::MAX,
            max_waiting_bytes: MAX_WAITING_BYTES,
            written: Instant::now(),
            file: None,
            has_other: false,
            in_work: InWork::default(),
            waiting: VecDeque::new(),
            failed: None,
        }
    }

    fn go_on(&mut self, mut file: SumsFile) -> Result<(), SumsError> {
        let stale = |what| Err(SumsError::Stale { path: self.path.clone(), what });
        if let Some(what) = self.header().difference(file.header()) {
            return stale(what);
        }
        let (most, wanted) = (file.most_samples(), self.samples());
        if most > wanted.len() as u32 {
            return stale(format!(
                "with {most} samples a pixel, more than the {} that are asked for",
                wanted.len()
            ));
        }
        file.go_on()?;
        self.file = Some(file);
        Ok(())
    }

    /// The samples of each pixel that are to be done.
    pub fn samples(&self) -> Range<u32> {
        self.share.as_ref().map_or(0..self.scene.settings.samples, |share| share.samples.clone())
    }

    /// Whether the checkpoint's file has samples to resume from.
    pub fn is_kept(&self) -> bool {
        self.file.as_ref().is_some_and(|file| !file.is_empty())
    }

    /// Whether there is a file from which this render does not resume. It is replaced when there is something to be kept.
    pub fn has_other(&self) -> bool {
        self.has_other
    }

    /// The file; of a picture of which nothing is kept it has no name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The rows from this one on that the file has, or else the next row that it has.
    pub fn rows_from(&self, row: u32) -> Result<Range<u32>, Option<u32>> {
        self.file.as_ref().map_or(Err(None), |file| file.rows_from(row))
    }

    /// All samples, of all pixels together.
    pub fn samples_total(&self) -> u64 {
        let (width, height) = self.part.size(&self.scene);
        u64::from(width) * u64::from(height) * self.samples().len() as u64
    }

    /// What the file has of samples, of all pixels together.
    pub fn samples_done(&self) -> u64 {
        self.file.as_ref().map_or(0, SumsFile::samples)
    }

    /// What the file has of these rows, which it names ([`Checkpoint::rows_from`]).
    ///
    /// # Errors
    ///
    /// [`SumsError::File`].
    pub fn strip(&mut self, rows: Range<u32>) -> Result<Strip, SumsError> {
        match &mut self.file {
            Some(file) => file.strip(rows),
            None => Ok(Strip::new(self.part.size(&self.scene).0, rows)),
        }
    }

    /// Whether it is time to write the checkpoint, if the next piece of work takes `next`.
    pub fn is_due(&self, next: Duration) -> bool {
        self.keeps && self.written.elapsed() + next >= self.interval
    }

    /// Takes a strip that is whole, to be written with the next ones: when it is time, or when there is no more memory for them.
    /// Only where that fails ([`Checkpoint::failure`]), and there is no memory for them, they are given up.
    pub fn take(&mut self, strip: Strip) {
        if !self.keeps || self.file.as_ref().is_some_and(|file| file.has(&strip.rows, strip.samples)) {
            return;
        }
        self.waiting.push_back(strip);
        if self.bytes_waiting() > self.max_waiting_bytes {
            // Whoever kills the program does not take it from the system, so it need not be on the disk before the next strip.
            let written = self.write_waiting();
            self.note(written);
            if self.bytes_waiting() > self.max_waiting_bytes {
                self.waiting.clear();
            }
        }
    }

    fn bytes_waiting(&self) -> usize {
        self.waiting.iter().map(|strip| strip.pixels() * SUM_BYTES).sum::<u64>() as usize
    }

    fn note(&mut self, written: Result<(), SumsError>) {
        self.failed = self.failed.take().or(written.err());
    }

    /// Writes what is not in the file, with what is done of the strip in work, and waits until it is on the disk. Where that
    /// fails, [`Checkpoint::failure`] has the reason.
    pub fn write(&mut self, in_work: Option<&Strip>) {
        let in_work = in_work.filter(|strip| strip.samples > 0);
        if self.keeps {
            let written = self.write_waiting().and_then(|()| match in_work {
                Some(strip) => self.write_in_work(strip),
                None => Ok(()),
            });
            let on_disk = self.file.as_mut().map_or(Ok(()), SumsFile::sync);
            self.note(written.and(on_disk));
        }
        self.written = Instant::now();
    }

    /// Why writing has failed, told once; after that it is tried again.
    pub fn failure(&mut self) -> Option<SumsError> {
        self.failed.take()
    }

    /// Writes the rest of a share, which is whole then.
    ///
    /// # Errors
    ///
    /// Why that failed, also where it was earlier.
    pub fn complete(mut self) -> Result<(), SumsError> {
        self.write(None);
        match self.failed {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// The picture is whole: the file goes, also one of an earlier render of the same. Whether there was one.
    pub fn remove(self) -> bool {
        let is_same =
            || header_of(&self.path).is_some_and(|header| self.header().difference(&header).is_none());
        // Nothing depends on it any more.
        (self.file.is_some() || (self.has_other && is_same())) && fs::remove_file(&self.path).is_ok()
    }

    fn header(&self) -> &SumsHeader {
        self.header.get_or_init(|| SumsHeader::of(&self.scene, self.part, self.share.clone()))
    }

    /// The file, which is made where there is none.
    fn file(&mut self) -> Result<&mut SumsFile, SumsError> {
        let file = match self.file.take() {
            Some(file) => file,
            None => SumsFile::create(&self.path, self.header().clone())?,
        };
        self.has_other = false;
        Ok(self.file.insert(file))
    }

    /// Writes the strips that wait; those that cannot be written wait for the next time.
    fn write_waiting(&mut self) -> Result<(), SumsError> {
        while let Some(strip) = self.waiting.pop_front() {
            if let Err(error) = self.file().and_then(|file| file.append(&strip)) {
                self.waiting.push_front(strip);
                return Err(error);
            }
        }
        Ok(())
    }

    fn write_in_work(&mut self, strip: &Strip) -> Result<(), SumsError> {
        if self.in_work.rows != strip.rows {
            self.in_work = InWork { rows: strip.rows.clone(), ..InWork::default() };
        }
        let InWork { offsets, newest, .. } = self.in_work.clone();
        if offsets.len() < 2 {
            let offset = self.file()?.append(strip)?;
            self.in_work.offsets.push(offset);
            self.in_work.newest = offsets.len();
        } else {
            // The older of the two.
            self.file()?.overwrite(offsets[1 - newest], strip)?;
            self.in_work.newest = 1 - newest;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eosphor_scene::{LoadOptions, load};

    const WIDTH: u32 = 5;
    const HEIGHT: u32 = 9;

    fn scene(samples: u32, seed: u32) -> Arc<SceneData> {
        let mut scene = load("builtin:cornell", &LoadOptions::default()).unwrap().scene;
        (scene.settings.size, scene.settings.samples, scene.settings.seed) = ([WIDTH, HEIGHT], samples, seed);
        Arc::new(SceneData::flatten(&scene).unwrap().0)
    }

    fn open(path: &Path, samples: u32, resume: bool) -> Result<Checkpoint, SumsError> {
        Checkpoint::open(path, (scene(samples, 1), Part::default()), None, Duration::ZERO, resume)
    }

    /// Sums that say which rows and samples they are of.
    fn strip(rows: Range<u32>, samples: u32) -> Strip {
        let mut strip = Strip::new(WIDTH, rows.clone());
        strip.samples = samples;
        for (number, sum) in strip.sums.sums.iter_mut().enumerate() {
            sum.units = [rows.start.into(), u64::from(samples) << 40, number as u64];
        }
        strip
    }

    fn all(checkpoint: &mut Checkpoint) -> Vec<Strip> {
        let (mut all, mut row) = (Vec::new(), 0);
        while row < HEIGHT {
            match checkpoint.rows_from(row) {
                Ok(rows) => {
                    row = rows.end;
                    all.push(checkpoint.strip(rows).unwrap());
                }
                Err(next) => row = next.unwrap_or(HEIGHT),
            }
        }
        all
    }

    #[test]
    fn what_was_kept_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert!(!checkpoint.is_kept() && checkpoint.rows_from(0) == Err(None));
        checkpoint.write(None);
        assert!(!path.exists(), "nothing to be kept");
        checkpoint.take(strip(0..3, 64));
        for samples in [1, 5, 9, 12] {
            checkpoint.write(Some(&strip(3..5, samples)));
        }
        assert!(checkpoint.failure().is_none());
        drop(checkpoint);
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert!(checkpoint.is_kept());
        assert_eq!(all(&mut checkpoint), [strip(0..3, 64), strip(3..5, 12)]);
        assert_eq!((checkpoint.rows_from(0), checkpoint.rows_from(1)), (Ok(0..3), Err(Some(3))));
        assert_eq!(checkpoint.samples_done(), 5 * (3 * 64 + 2 * 12));
        checkpoint.write(Some(&strip(3..5, 20)));
        checkpoint.take(strip(3..5, 64));
        checkpoint.take(strip(5..9, 64));
        checkpoint.write(None);
        drop(checkpoint);
        let mut checkpoint = open(&path, 64, true).unwrap();
        assert_eq!(all(&mut checkpoint), [strip(0..3, 64), strip(3..5, 64), strip(5..9, 64)]);
        assert!(checkpoint.remove() && !path.exists());
    }

    /// However little time they took: what is done is never forgotten.
    #[test]
    fn strips_that_memory_has_no_room_for_are_written_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let long = Duration::from_secs(1 << 20);
        let mut checkpoint =
            Checkpoint::open(&path, (scene(2, 1), Part::default()), None, long, false).unwrap();
        // Three rows.
        checkpoint.max_waiting_bytes = 3 * WIDTH as usize * SUM_BYTES as usize;
        checkpoint.take(strip(0..2, 2));
        checkpoint.take(strip(2..3, 2));
        assert!(!checkpoint.is_due(Duration::ZERO) && !path.exists(), "there is room");
        checkpoint.take(strip(3..4, 2));
        assert_eq!(checkpoint.samples_done(), 5 * 4 * 2);
        checkpoint.take(strip(4..5, 2));
        assert!(checkpoint.failure().is_none());
        drop(checkpoint);
        // Killed there: no more is lost than memory has room for.
        assert_eq!(open(&path, 2, true).unwrap().samples_done(), 5 * 4 * 2);
    }

    #[test]
    fn strips_that_could_not_be_written_wait_for_the_next_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.png.part");
        let mut checkpoint = open(&path, 2, true).unwrap();
        checkpoint.take(strip(0..3, 2));
        checkpoint.write(None);
        assert!(checkpoint.failure().is_some());
        fs::create_dir(folder.path().join("none")).unwrap();
        checkpoint.take(strip(3..4, 2));
        checkpoint.write(None);
        assert!(checkpoint.failure().is_none());
        assert_eq!(checkpoint.samples_done(), 5 * 4 * 2);
    }

    #[test]
    fn nothing_is_kept_where_nothing_is_to_be_kept() {
        let mut checkpoint = Checkpoint::nowhere(scene(64, 1));
        assert!(!checkpoint.is_due(Duration::ZERO) && checkpoint.samples() == (0..64));
        checkpoint.take(strip(0..3, 64));
        checkpoint.write(Some(&strip(3..5, 7)));
        assert!(checkpoint.failure().is_none() && !checkpoint.is_kept());
        assert_eq!(checkpoint.rows_from(0), Err(None));
        assert!(!checkpoint.remove());
    }

    #[test]
    fn a_whole_picture_leaves_nothing_of_an_earlier_render_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        open(&path, 16, false).unwrap().write(Some(&strip(0..9, 2)));
        // Of another picture.
        assert!(
            !Checkpoint::open(&path, (scene(16, 2), Part::default()), None, Duration::ZERO, false)
                .unwrap()
                .remove()
        );
        assert!(path.exists());
        assert!(open(&path, 32, false).unwrap().remove() && !path.exists());
        assert!(!open(&path, 32, false).unwrap().remove());
    }

    #[test]
    fn more_samples_go_on_and_other_scenes_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 16, true).unwrap();
        checkpoint.take(strip(0..9, 16));
        checkpoint.write(None);
        drop(checkpoint);
        assert_eq!(open(&path, 32, true).unwrap().samples_done(), 45 * 16);
        let reason = |opened: Result<Checkpoint, SumsError>| opened.err().unwrap().to_string();
        assert!(reason(open(&path, 8, true)).contains("with 16 samples a pixel, more than the 8"));
        // A single sample is elsewhere in its pixel.
        assert!(reason(open(&path, 1, true)).contains("another scene, or with other settings"));
        let other = Checkpoint::open(&path, (scene(16, 2), Part::default()), None, Duration::ZERO, true);
        assert!(reason(other).contains("another scene, or with other settings"));
        // Anew, which replaces it when there is something to be kept.
        let mut anew =
            Checkpoint::open(&path, (scene(16, 2), Part::default()), None, Duration::ZERO, false).unwrap();
        assert!(!anew.is_kept() && anew.has_other());
        anew.write(Some(&strip(0..1, 3)));
        drop(anew);
        let again =
            Checkpoint::open(&path, (scene(16, 2), Part::default()), None, Duration::ZERO, true).unwrap();
        assert_eq!(again.samples_done(), 15);
        drop(again);
        fs::write(
            &path,
            "my notes, which are long enough to be a header of something else, if not of a picture",
        )
        .unwrap();
        assert!(reason(open(&path, 16, true)).contains("delete it"));
        fs::write(&path, "EOS").unwrap();
        assert_eq!(open(&path, 16, true).unwrap().samples_done(), 0);
    }

    #[test]
    fn a_file_that_was_cut_off_or_damaged_anywhere_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        checkpoint.take(strip(0..3, 64));
        checkpoint.write(None);
        let begin = fs::metadata(&path).unwrap().len() - (3 * u64::from(WIDTH) * SUM_BYTES + 24);
        checkpoint.write(Some(&strip(3..5, 7)));
        checkpoint.write(Some(&strip(3..5, 8)));
        let older = checkpoint.in_work.offsets[0];
        drop(checkpoint);
        let whole = fs::read(&path).unwrap();
        let mut before = 0;
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let Ok(mut checkpoint) = open(&path, 64, true) else { panic!("{length}") };
            let done = checkpoint.samples_done();
            assert!(done >= before, "{length}");
            before = done;
            // It goes on from there.
            checkpoint.take(strip(5..9, 64));
            checkpoint.write(None);
            assert!(checkpoint.failure().is_none());
            drop(checkpoint);
            assert_eq!(open(&path, 64, true).unwrap().samples_done(), done + 20 * 64, "{length}");
        }
        assert_eq!(before, 5 * (3 * 64 + 2 * 8));
        for at in begin as usize..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 16;
            fs::write(&path, &damaged).unwrap();
            let mut checkpoint = open(&path, 64, true).unwrap();
            for got in all(&mut checkpoint) {
                let expected = strip(got.rows.clone(), got.samples);
                assert!(got == expected && [64, 7, 8].contains(&got.samples), "byte {at}");
            }
            // Half of what is written over: the other one counts.
            if (at as u64) >= older && (at as u64) < older + 8 + 10 * SUM_BYTES {
                assert_eq!(checkpoint.samples_done(), 5 * (3 * 64 + 2 * 8), "byte {at}");
            }
        }
    }

    /// Nobody may see there what he may not see in the picture.
    #[cfg(unix)]
    #[test]
    fn the_file_is_for_those_who_may_see_the_picture() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        for (name, mode) in [
            ("a.png.part", 0o600),
            ("b.png.part", 0o640),
            ("c.png.0-64.sums", 0o600),
            ("d.png.part", 0o666),
            ("e.png.part", 0o444),
        ] {
            let picture = folder.path().join(&name[..5]);
            fs::write(&picture, "").unwrap();
            fs::set_permissions(&picture, fs::Permissions::from_mode(mode)).unwrap();
            let path = folder.path().join(name);
            open(&path, 64, false).unwrap().write(Some(&strip(0..9, 2)));
            // (Whoever renders goes on with it, too.)
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, mode | 0o600, "{name}");
        }
    }

    #[test]
    fn two_cannot_have_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png.part");
        let mut first = open(&path, 64, true).unwrap();
        first.write(Some(&strip(0..9, 2)));
        for resume in [false, true] {
            let message = open(&path, 64, resume).err().unwrap().to_string();
            assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
        }
        drop(first);
        assert_eq!(open(&path, 64, true).unwrap().samples_done(), 90);
    }

    #[test]
    fn what_cannot_be_written_is_said_and_tried_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.png.part");
        let mut checkpoint = open(&path, 64, true).unwrap();
        checkpoint.write(Some(&strip(0..9, 2)));
        assert!(checkpoint.failure().unwrap().to_string().contains("cannot keep"));
        fs::create_dir(folder.path().join("none")).unwrap();
        checkpoint.write(Some(&strip(0..9, 3)));
        assert!(checkpoint.failure().is_none());
        drop(checkpoint);
        assert_eq!(open(&path, 64, true).unwrap().samples_done(), 45 * 3);
    }
}
