//! Pictures of which only the bytes are wanted.

use super::Rendered;
use crate::{DevelopSettings, Developed, Film, RayStatistics};

/// What a render gives back of which only the bytes are wanted.
#[derive(Clone, Debug)]
pub struct RenderedBytes {
    picture: BytesOrFilm,
    /// False where the render was cancelled before its end.
    pub complete: bool,
    /// Rays traced, and the work on them where it was counted.
    pub statistics: RayStatistics,
}

#[derive(Clone, Debug)]
enum BytesOrFilm {
    Bytes(Developed),
    /// Still to be developed.
    Film(Film, DevelopSettings),
}

impl RenderedBytes {
    /// Of a device that develops.
    pub fn of_bytes(picture: Developed, complete: bool, statistics: RayStatistics) -> RenderedBytes {
        RenderedBytes { picture: BytesOrFilm::Bytes(picture), complete, statistics }
    }

    /// Of one that does not.
    pub fn of_film(rendered: Rendered, develop: DevelopSettings) -> RenderedBytes {
        let Rendered { film, complete, statistics } = rendered;
        RenderedBytes { picture: BytesOrFilm::Film(film, develop), complete, statistics }
    }

    /// The bytes; pixels that were not reached are those of black. What the device has not developed is developed here, on the
    /// CPU, while the device may render the next picture.
    pub fn developed(self) -> Developed {
        match self.picture {
            BytesOrFilm::Bytes(picture) => picture,
            BytesOrFilm::Film(film, develop) => Developed::new(&film, &develop),
        }
    }
}
