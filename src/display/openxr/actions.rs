//! Controllers: one action set, with suggested bindings for the controllers of known headsets (OpenXR 1.0, section 11).

use openxr as xr;

use super::headset::Spaces;
use super::place::Pose;
use super::runtime::{CallContext, Runtime};
use crate::display::DisplayError;

/// A stick that was pushed this far moves a choice once. It must come back to `RELEASED` before it moves another.
const PUSHED: f32 = 0.6;
const RELEASED: f32 = 0.3;

/// What was done with the controllers since the last look.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct ControllerInput {
    pub confirm: bool,
    pub pause: bool,
    pub recentre: bool,
    /// +1: the stick was pushed right or down; −1: left or up.
    pub step: i32,
    /// The hand that did it: 0 left, 1 right.
    pub hand: usize,
}

/// The actions and where they are bound.
pub(super) struct Actions {
    set: xr::ActionSet,
    confirm: xr::Action<bool>,
    pause: xr::Action<bool>,
    recentre: xr::Action<bool>,
    /// For pads that count only while they are pressed.
    press: xr::Action<bool>,
    stick: xr::Action<xr::Vector2f>,
    aim: xr::Action<xr::Posef>,
    tick: xr::Action<xr::Haptic>,
    hands: [xr::Path; 2],
    rays: [xr::Space; 2],
    pushed: [bool; 2],
}

#[derive(Clone, Copy)]
enum BoundAction {
    Confirm,
    Pause,
    Recentre,
    Press,
    Stick,
}

/// An interaction profile, its bindings for both hands, and those for each hand; every profile has aim and haptics.
/// Paths: section 6.4 and the extensions.
type InteractionProfile =
    (&'static str, &'static [(BoundAction, &'static str)], [&'static [(BoundAction, &'static str)]; 2]);

const PROFILES: &[InteractionProfile] = &[
    (
        "khr/simple_controller",
        &[(BoundAction::Confirm, "select/click"), (BoundAction::Pause, "menu/click")],
        [&[], &[]],
    ),
    (
        "valve/index_controller",
        &[
            (BoundAction::Confirm, "trigger/click"),
            (BoundAction::Confirm, "a/click"),
            (BoundAction::Pause, "b/click"),
            (BoundAction::Stick, "thumbstick"),
            (BoundAction::Recentre, "thumbstick/click"),
        ],
        [&[], &[]],
    ),
    (
        "oculus/touch_controller",
        &[
            (BoundAction::Confirm, "trigger/value"),
            (BoundAction::Stick, "thumbstick"),
            (BoundAction::Recentre, "thumbstick/click"),
        ],
        [
            &[(BoundAction::Confirm, "x/click"), (BoundAction::Pause, "y/click"), (BoundAction::Pause, "menu/click")],
            &[(BoundAction::Confirm, "a/click"), (BoundAction::Pause, "b/click")],
        ],
    ),
    (
        "htc/vive_controller",
        &[
            (BoundAction::Confirm, "trigger/click"),
            (BoundAction::Pause, "menu/click"),
            (BoundAction::Stick, "trackpad"),
            (BoundAction::Press, "trackpad/click"),
            (BoundAction::Recentre, "squeeze/click"),
        ],
        [&[], &[]],
    ),
    (
        "microsoft/motion_controller",
        &[
            (BoundAction::Confirm, "trigger/value"),
            (BoundAction::Pause, "menu/click"),
            (BoundAction::Stick, "thumbstick"),
            (BoundAction::Recentre, "thumbstick/click"),
        ],
        [&[], &[]],
    ),
    (
        "bytedance/pico4_controller",
        &[
            (BoundAction::Confirm, "trigger/value"),
            (BoundAction::Stick, "thumbstick"),
            (BoundAction::Recentre, "thumbstick/click"),
        ],
        [
            &[(BoundAction::Confirm, "x/click"), (BoundAction::Pause, "y/click")],
            &[(BoundAction::Confirm, "a/click"), (BoundAction::Pause, "b/click")],
        ],
    ),
];

const HANDS: [&str; 2] = ["/user/hand/left", "/user/hand/right"];

impl Actions {
    /// Makes the set, suggests bindings, and attaches it to the session, which is possible only once (section 11.2).
    pub fn new(runtime: &Runtime, session: &xr::Session<xr::Vulkan>) -> Result<Actions, DisplayError> {
        let path = |text: &str| runtime.instance.string_to_path(text).in_call("xrStringToPath");
        let hands = [path(HANDS[0])?, path(HANDS[1])?];
        let set = runtime.instance.create_action_set("answers", "Answers", 0).in_call("xrCreateActionSet")?;
        fn make<T: xr::ActionTy>(
            set: &xr::ActionSet,
            hands: &[xr::Path; 2],
            name: &str,
            words: &str,
        ) -> Result<xr::Action<T>, DisplayError> {
            set.create_action(name, words, hands).in_call("xrCreateAction")
        }
        let aim: xr::Action<xr::Posef> = make(&set, &hands, "aim", "Point at the panel")?;
        let ray =
            |hand: usize| aim.create_space(session, hands[hand], xr::Posef::IDENTITY).in_call("xrCreateActionSpace");
        let rays = [ray(0)?, ray(1)?];
        let actions = Actions {
            confirm: make(&set, &hands, "confirm", "Confirm")?,
            pause: make(&set, &hands, "pause", "Pause")?,
            recentre: make(&set, &hands, "recentre", "Centre the view")?,
            press: make(&set, &hands, "press", "Press the pad to move the choice")?,
            stick: make(&set, &hands, "stick", "Move the choice")?,
            tick: make(&set, &hands, "tick", "Answer felt")?,
            aim,
            set,
            hands,
            rays,
            pushed: [false; 2],
        };
        for profile in PROFILES {
            actions.suggest(runtime, profile)?;
        }
        session.attach_action_sets(&[&actions.set]).in_call("xrAttachSessionActionSets")?;
        Ok(actions)
    }

    fn suggest(&self, runtime: &Runtime, (profile, both, each): &InteractionProfile) -> Result<(), DisplayError> {
        if profile.starts_with("bytedance") && !runtime.enabled.bd_controller_interaction {
            return Ok(());
        }
        let path = |text: String| runtime.instance.string_to_path(&text).in_call("xrStringToPath");
        let mut bindings = Vec::new();
        for (hand, more) in HANDS.iter().zip(each) {
            for (to, part) in both.iter().chain(*more) {
                let at = path(format!("{hand}/input/{part}"))?;
                bindings.push(match to {
                    BoundAction::Confirm => xr::Binding::new(&self.confirm, at),
                    BoundAction::Pause => xr::Binding::new(&self.pause, at),
                    BoundAction::Recentre => xr::Binding::new(&self.recentre, at),
                    BoundAction::Press => xr::Binding::new(&self.press, at),
                    BoundAction::Stick => xr::Binding::new(&self.stick, at),
                });
            }
            bindings.push(xr::Binding::new(&self.aim, path(format!("{hand}/input/aim/pose"))?));
            bindings.push(xr::Binding::new(&self.tick, path(format!("{hand}/output/haptic"))?));
        }
        let profile_path = path(format!("/interaction_profiles/{profile}"))?;
        match runtime.instance.suggest_interaction_profile_bindings(profile_path, &bindings) {
            Ok(()) => Ok(()),
            // A runtime need not know every device. The other profiles stay.
            Err(xr::sys::Result::ERROR_PATH_UNSUPPORTED) => {
                tracing::debug!("openxr: {profile} is not known to this runtime");
                Ok(())
            }
            Err(other) => Err(other).in_call("xrSuggestInteractionProfileBindings"),
        }
    }

    /// Updates the actions and returns what was done since the last call; nothing while another program has the focus.
    pub fn read(&mut self, session: &xr::Session<xr::Vulkan>) -> Result<ControllerInput, DisplayError> {
        session.sync_actions(&[xr::ActiveActionSet::new(&self.set)]).in_call("xrSyncActions")?;
        let mut done = ControllerInput { hand: 1, ..ControllerInput::default() };
        for (hand, path) in self.hands.into_iter().enumerate() {
            let pressed = |action: &xr::Action<bool>| -> Result<(bool, bool), DisplayError> {
                let state = action.state(session, path).in_call("xrGetActionStateBoolean")?;
                Ok((state.is_active && state.current_state && state.changed_since_last_sync, state.is_active))
            };
            let (press, has_pad) = pressed(&self.press)?;
            let stick = self.stick.state(session, path).in_call("xrGetActionStateVector2f")?;
            let (x, y) = (stick.current_state.x, stick.current_state.y);
            // Right and down move forward.
            let along = if x.abs() >= y.abs() { x } else { -y };
            let was = self.pushed[hand];
            self.pushed[hand] = stick.is_active && along.abs() > if was { RELEASED } else { PUSHED };
            let moved = if has_pad { press && along.abs() > RELEASED } else { self.pushed[hand] && !was };
            let before = done;
            if moved {
                done.step = if along > 0.0 { 1 } else { -1 };
            }
            done.confirm |= pressed(&self.confirm)?.0;
            done.pause |= pressed(&self.pause)?.0;
            done.recentre |= pressed(&self.recentre)?.0;
            if done != before {
                done.hand = hand;
            }
        }
        Ok(done)
    }

    /// The ray along which a hand points, in the room; none while the hand is not tracked.
    pub fn ray(&self, hand: usize, spaces: &Spaces, time: xr::Time) -> Result<Option<Pose>, DisplayError> {
        let located = self.rays[hand].locate(&spaces.room, time).in_call("xrLocateSpace")?;
        let needed = xr::SpaceLocationFlags::ORIENTATION_VALID | xr::SpaceLocationFlags::POSITION_VALID;
        Ok(located.location_flags.contains(needed).then(|| Pose::of(located.pose)))
    }

    /// A short vibration in the hand. A controller that cannot vibrate is no failure.
    pub fn pulse(&self, session: &xr::Session<xr::Vulkan>, hand: usize) {
        let pulse = xr::HapticVibration::new()
            .duration(xr::Duration::MIN_HAPTIC)
            .frequency(xr::FREQUENCY_UNSPECIFIED)
            .amplitude(0.4);
        if let Err(result) = self.tick.apply_feedback(session, self.hands[hand], &pulse) {
            tracing::debug!("openxr: xrApplyHapticFeedback: {result:?}");
        }
    }
}
