//! Data from the header of a lens file beside the surfaces.

/// The purpose of a lens, as a photographer sorts lenses: a closed list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LensGroup {
    /// A lens that sees more than the eye at rest does.
    WideAngle,
    /// A lens about as long as the film's diagonal.
    Normal,
    /// A lens somewhat longer than [`Self::Normal`], and fast.
    Portrait,
    /// A lens corrected for near subjects.
    Macro,
    /// A lens of long focal length and narrow field.
    Telephoto,
    /// A lens that changes its focal length.
    Zoom,
    /// A lens that bends straight lines to see more than a picture without distortion can hold.
    Fisheye,
    /// A lens that images by mirrors.
    Mirror,
    /// A lens that squeezes the picture in one direction.
    Anamorphic,
    /// A lens of before about 1960, or known for its place in history.
    Historical,
    /// The optics of an eye, with the retina as its film.
    Eye,
    /// An ideal or simple lens: its answers are known, or its faults are large.
    Test,
}

impl LensGroup {
    /// All, in the order in which lists show them.
    pub const ALL: [Self; 12] = [
        Self::WideAngle,
        Self::Normal,
        Self::Portrait,
        Self::Macro,
        Self::Telephoto,
        Self::Zoom,
        Self::Fisheye,
        Self::Mirror,
        Self::Anamorphic,
        Self::Historical,
        Self::Eye,
        Self::Test,
    ];

    /// The word for the group in lens files.
    pub fn word(self) -> &'static str {
        match self {
            Self::WideAngle => "wide angle",
            Self::Normal => "normal",
            Self::Portrait => "portrait",
            Self::Macro => "macro",
            Self::Telephoto => "telephoto",
            Self::Zoom => "zoom",
            Self::Fisheye => "fisheye",
            Self::Mirror => "mirror",
            Self::Anamorphic => "anamorphic",
            Self::Historical => "historical",
            Self::Eye => "eye",
            Self::Test => "test",
        }
    }

    /// The group of that word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|group| group.word().eq_ignore_ascii_case(word.trim()))
    }
}

/// Data from the header of a lens file beside the surfaces. Numbers are those that the source states, not computed ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// The source of the numbers.
    pub source: Option<String>,
    /// The purpose of the lens.
    pub group: Option<LensGroup>,
    /// True if the lens is one of those to begin with.
    pub is_first_choice: bool,
    /// Nominal focal length in mm; `None` also where the header says that none is published.
    pub focal_length_mm: Option<f64>,
    /// Nominal f-number; `None` also where the header says that none is published.
    pub f_number: Option<f64>,
    /// Distance in mm from the last vertex to the focal plane; `None` also where the header says that none is published.
    pub back_focus_mm: Option<f64>,
    /// Half of the field of view that the design is for, in degrees.
    pub half_field_deg: Option<f64>,
    /// Width and height in mm of the film that the design is for.
    pub film_mm: Option<[f64; 2]>,
    /// Every `# key: text` of the header, in order.
    pub all: Vec<(String, String)>,
}

impl Metadata {
    /// The text in the header for a number that the source does not state.
    pub const NOT_PUBLISHED: &str = "not published";

    /// The text of a key, as it stands in the header; of several the first.
    pub fn text(&self, key: &str) -> Option<&str> {
        self.all.iter().find(|(found, _)| found == key).map(|(_, text)| text.as_str())
    }

    /// The reason, from the header, why the computed value differs from that for `key`: `# differs: f_number: why`.
    pub fn difference(&self, key: &str) -> Option<&str> {
        let of_key = |text: &&str| text.split_once(':').is_some_and(|(found, _)| found.trim() == key);
        let lines = self.all.iter().filter(|(found, _)| found == "differs").map(|(_, text)| text.as_str());
        lines.clone().find(of_key).and_then(|text| text.split_once(':')).map(|(_, why)| why.trim())
    }
}
