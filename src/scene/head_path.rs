//! Paths of the head through a scene: where it is and where it looks, as a function of time. They come from a manifest,
//! or are one of the generic paths; sequences and comparisons follow them.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::{Scene, View};

/// Frame rate of a path that does not state one.
pub const DEFAULT_RATE_HZ: f64 = 60.0;

/// A key of a path: the pose of the head at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadKey {
    pub time_s: f64,
    /// Half-way between the eyes, metres, world space.
    pub position: DVec3,
    pub world_from_view: DQuat,
    /// The head jumps here: there is no motion from the key before to this one.
    pub cut: bool,
}

/// A path of the head. Between its keys the position follows a smooth curve through them (Catmull and Rom 1974), and
/// the direction turns at an even rate.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadPath {
    pub name: String,
    /// The frame rate at which the path is meant to be seen.
    pub rate_hz: f64,
    /// At least two, in order of time.
    keys: Vec<HeadKey>,
}

/// Why keys do not make a path, or why a path does not have the frames that were asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeadPathError {
    #[error("it has {0} poses; a path needs at least two")]
    TooFew(usize),
    #[error("pose {0} is not later than the one before it")]
    Order(usize),
    #[error("pose {0} holds a number that is not finite")]
    Number(usize),
    #[error("--frames {asked} is more than path `{name}` has: {has} at {rate_hz} a second")]
    Frames { asked: u32, name: String, has: u32, rate_hz: f64 },
    #[error("its rate is {0} frames a second; it must be above 0 and at most 1000")]
    Rate(f64),
}

impl HeadPath {
    /// # Errors
    /// [`HeadPathError`]: fewer than two keys, keys that are out of order, or numbers that are not finite.
    pub fn new(name: &str, rate_hz: f64, keys: Vec<HeadKey>) -> Result<HeadPath, HeadPathError> {
        if !(rate_hz > 0.0 && rate_hz <= 1000.0) {
            return Err(HeadPathError::Rate(rate_hz));
        }
        if keys.len() < 2 {
            return Err(HeadPathError::TooFew(keys.len()));
        }
        for (i, key) in keys.iter().enumerate() {
            if !(key.time_s.is_finite() && key.position.is_finite() && key.world_from_view.is_finite()) {
                return Err(HeadPathError::Number(i + 1));
            }
            if i > 0 && key.time_s <= keys[i - 1].time_s {
                return Err(HeadPathError::Order(i + 1));
            }
        }
        Ok(HeadPath { name: name.to_owned(), rate_hz, keys })
    }

    /// The number of frames from the first key to the last one, both included.
    pub fn frames(&self) -> u32 {
        let seconds = self.keys[self.keys.len() - 1].time_s - self.keys[0].time_s;
        // The small addition keeps the last frame of a path that lasts a whole number of frames, whatever rounding
        // does.
        ((seconds * self.rate_hz + 1e-6).floor() + 1.0).min(f64::from(u32::MAX)) as u32
    }

    /// The number of frames to render when the first `asked` frames of the path are asked for; `None` asks for all of
    /// them.
    ///
    /// # Errors
    /// [`HeadPathError::Frames`]: the path has fewer frames.
    pub fn frames_asked(&self, asked: Option<u32>) -> Result<u32, HeadPathError> {
        let has = self.frames();
        match asked {
            Some(asked) if asked > has => {
                Err(HeadPathError::Frames { asked, name: self.name.clone(), has, rate_hz: self.rate_hz })
            }
            asked => Ok(asked.unwrap_or(has)),
        }
    }

    /// How many frames begin within so many seconds, and no more than the path has.
    pub fn frames_within(&self, seconds: f64) -> u32 {
        let begin = (seconds * self.rate_hz - 1e-6).ceil().max(1.0);
        self.frames().min(begin.min(f64::from(u32::MAX)) as u32)
    }

    /// Seconds from the path's first key to a frame.
    pub fn time_of(&self, frame: u32) -> f64 {
        f64::from(frame) / self.rate_hz
    }

    /// The view of a frame. Only position and direction come from the path; everything else is that of `view`. After
    /// the last key the head stands still.
    pub fn view(&self, view: &View, frame: u32) -> View {
        let (position, world_from_view) = self.at(self.keys[0].time_s + self.time_of(frame));
        View { position, world_from_view, ..view.clone() }
    }

    /// Whether the head jumps between the frame before and this one.
    pub fn is_cut(&self, frame: u32) -> bool {
        let time = |frame: u32| self.keys[0].time_s + self.time_of(frame) + 1e-9;
        frame > 0 && self.keys.iter().any(|k| k.cut && k.time_s > time(frame - 1) && k.time_s <= time(frame))
    }

    fn at(&self, time_s: f64) -> (DVec3, DQuat) {
        let keys = &self.keys;
        // Rounding may make a frame's time slightly smaller than a key's.
        let after = keys.iter().position(|k| k.time_s > time_s + 1e-9).unwrap_or(keys.len());
        let (Some(next), Some(here)) = (keys.get(after), after.checked_sub(1).map(|i| &keys[i])) else {
            let last = if after == 0 { &keys[0] } else { &keys[keys.len() - 1] };
            return (last.position, last.world_from_view);
        };
        if next.cut {
            return (here.position, here.world_from_view);
        }
        let span = next.time_s - here.time_s;
        let t = ((time_s - here.time_s) / span).clamp(0.0, 1.0);
        let before = after.checked_sub(2).map(|i| &keys[i]).filter(|_| !here.cut);
        let beyond = keys.get(after + 1).filter(|k| !k.cut);
        let slope = |a: &HeadKey, b: &HeadKey| (b.position - a.position) / (b.time_s - a.time_s) * span;
        let leaving = before.map_or_else(|| slope(here, next), |b| slope(b, next));
        let arriving = beyond.map_or_else(|| slope(here, next), |b| slope(here, b));
        (
            hermite(here.position, leaving, next.position, arriving, t),
            here.world_from_view.slerp(next.world_from_view, t),
        )
    }
}

fn hermite(p0: DVec3, m0: DVec3, p1: DVec3, m1: DVec3, t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    p0 * (2.0 * t3 - 3.0 * t2 + 1.0) + m0 * (t3 - 2.0 * t2 + t) + p1 * (3.0 * t2 - 2.0 * t3) + m1 * (t3 - t2)
}

/// How far the head of [`sway`] moves to each side and forwards, metres, and how far it turns to each side, radians.
/// This is about how somebody moves who stands and looks around.
const ASIDE_M: f64 = 0.25;
const FORWARDS_M: f64 = 0.25;
const TURN_RAD: f64 = 0.15;
/// Duration of one loop, seconds. The head moves at 0.4 metres and 27 degrees a second at most.
const SWAY_S: f64 = 4.0;
/// Number of keys of a path that is given by a formula. With so many the curve through them stays within a tenth of a
/// millimetre of the formula.
const FORMULA_KEYS: u32 = 64;

/// The view at this share (0–1) of a closed loop that begins in `view`: the head sways and looks around.
pub fn sway(view: &View, share: f64) -> View {
    let angle = TAU * share;
    let step = DVec3::new(ASIDE_M * angle.sin(), 0.0, -FORWARDS_M * (1.0 - angle.cos()) / 2.0);
    View {
        position: view.position + view.world_from_view * step,
        world_from_view: view.world_from_view * DQuat::from_rotation_y(TURN_RAD * (2.0 * angle).sin()),
        ..view.clone()
    }
}

/// Paths that every scene has, with a description of each.
pub const GENERIC: [(&str, &str); 3] = [
    ("still", "the head stands for two seconds"),
    ("sway", "the head sways and looks around for four seconds, and ends where it began"),
    ("cut", "as sway, but after half a second the head jumps to the opposite point of the loop"),
];

/// One of [`GENERIC`] that begins in `view`; `None` for another name.
fn generic(name: &str, view: &View) -> Option<Result<HeadPath, HeadPathError>> {
    let key = |time_s: f64, share: f64, cut: bool| {
        let View { position, world_from_view, .. } = sway(view, share);
        HeadKey { time_s, position, world_from_view, cut }
    };
    let seconds = |i: u32| SWAY_S * f64::from(i) / f64::from(FORMULA_KEYS);
    let keys: Vec<HeadKey> = match name {
        "still" => vec![key(0.0, 0.0, false), key(2.0, 0.0, false)],
        "sway" => (0..=FORMULA_KEYS).map(|i| key(seconds(i), seconds(i) / SWAY_S, false)).collect(),
        "cut" => {
            let at = FORMULA_KEYS / 8;
            let jump = |i: u32| if i >= at { 0.5 } else { 0.0 };
            (0..=FORMULA_KEYS).map(|i| key(seconds(i), seconds(i) / SWAY_S + jump(i), i == at)).collect()
        }
        _ => return None,
    };
    Some(HeadPath::new(name, DEFAULT_RATE_HZ, keys))
}

/// A scene has no path of this name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("scene `{scene}` has no path `{name}`; it has: {known}")]
pub struct UnknownPath {
    scene: String,
    name: String,
    known: String,
}

impl Scene {
    /// The path of this name: one of the scene's own, or one that every scene has, which begins in `view`.
    ///
    /// # Errors
    /// [`UnknownPath`], which lists the known ones.
    pub fn path(&self, name: &str, view: &View) -> Result<HeadPath, UnknownPath> {
        if let Some(own) = self.paths.iter().find(|p| p.name == name) {
            return Ok(own.clone());
        }
        match generic(name, view) {
            Some(Ok(path)) => Ok(path),
            _ => {
                let own = self.paths.iter().map(|p| p.name.as_str());
                let known: Vec<&str> = own.chain(GENERIC.iter().map(|(name, _)| *name)).collect();
                let known = known.join(", ");
                Err(UnknownPath { scene: self.name.clone(), name: name.to_owned(), known })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View {
            name: "main".to_owned(),
            position: DVec3::new(1.0, 2.0, 3.0),
            world_from_view: DQuat::from_rotation_y(0.7),
            vertical_fov_rad: 0.9,
            ipd_m: 0.063,
            cant_rad: 0.0,
            near_m: 0.05,
        }
    }

    fn key(time_s: f64, x: f64, cut: bool) -> HeadKey {
        HeadKey { time_s, position: DVec3::X * x, world_from_view: DQuat::from_rotation_y(x), cut }
    }

    #[test]
    fn the_loop_ends_where_it_began() {
        let path = generic("sway", &view()).expect("known").expect("a path");
        assert_eq!(path.frames(), 241);
        for frame in [0, 240, 1000] {
            let at = path.view(&view(), frame);
            assert!((at.position - view().position).length() < 1e-9, "frame {frame}");
            assert!(at.world_from_view.angle_between(view().world_from_view) < 1e-6, "frame {frame}");
        }
        // Between its keys the curve follows the formula within a tenth of a millimetre.
        for frame in 0..240 {
            let (curve, formula) = (path.view(&view(), frame), sway(&view(), f64::from(frame) / 240.0));
            assert!((curve.position - formula.position).length() < 1e-4, "frame {frame}");
        }
    }

    #[test]
    fn as_many_frames_begin_within_a_time_as_its_rate_says() {
        let path = HeadPath::new("p", 10.0, vec![key(0.0, 0.0, false), key(1.0, 1.0, false)]).expect("a path");
        let counts: Vec<u32> = [0.0, 0.05, 0.1, 0.11, 0.5, 1.0, 9.0].map(|s| path.frames_within(s)).to_vec();
        assert_eq!(counts, [1, 1, 1, 2, 5, 10, 11]);
    }

    #[test]
    fn nothing_leads_across_a_cut() {
        let path = HeadPath::new("p", 10.0, vec![key(0.0, 0.0, false), key(1.0, 1.0, false), key(2.0, 9.0, true)]);
        let path = path.expect("a path");
        assert_eq!(path.frames(), 21);
        assert!((path.view(&view(), 5).position.x - 0.5).abs() < 1e-9);
        assert_eq!((path.view(&view(), 19).position.x, path.view(&view(), 20).position.x), (1.0, 9.0));
        let cuts: Vec<u32> = (0..=25).filter(|f| path.is_cut(*f)).collect();
        assert_eq!(cuts, [20]);
    }

    #[test]
    fn a_straight_line_is_followed_evenly() {
        let path = HeadPath::new("p", 4.0, (0..5).map(|i| key(f64::from(i), f64::from(i), false)).collect());
        let path = path.expect("a path");
        for frame in 0..17 {
            let x = path.view(&view(), frame).position.x;
            assert!((x - f64::from(frame) / 4.0).abs() < 1e-12, "{frame}: {x}");
        }
    }

    #[test]
    fn what_is_no_path_is_refused() {
        let refused = |keys, rate| HeadPath::new("p", rate, keys).expect_err("refused");
        assert_eq!(refused(vec![key(0.0, 0.0, false)], 60.0), HeadPathError::TooFew(1));
        assert_eq!(refused(vec![key(1.0, 0.0, false), key(1.0, 0.0, false)], 60.0), HeadPathError::Order(2));
        assert_eq!(refused(vec![key(0.0, 0.0, false), key(1.0, f64::NAN, false)], 60.0), HeadPathError::Number(2));
        assert_eq!(refused(vec![key(0.0, 0.0, false), key(1.0, 0.0, false)], 0.0), HeadPathError::Rate(0.0));
    }
}
