//! The thread of the operator's window.

use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::Duration;

use winit::keyboard::{Key, ModifiersState, NamedKey};

use super::{SessionStatus, WindowMessage};
use crate::display::StimulusFiles;
use crate::display::content::{Content, Words};
use crate::display::desktop::{Composition, DesktopOptions, Mode, Picture, ShellEvent, Stage, StageError, fit};
use crate::display::panel::{Corner, Note, Panel};
use crate::gpu::{Image, ImageDesc};
use crate::study::protocol::{Input, Screen};

use ash::vk;

const KEYS: &str = "P pause   C continue   R repeat   S skip   N note   Q close (resume later)   Ctrl+Shift+A give up";
const SIZE: (u32, u32) = (960, 600);
/// Linear value of the background, display value 128.
const GROUND: f32 = 0.21586;
/// Time between two looks at the session.
const REST: Duration = Duration::from_millis(50);

struct Window<'a> {
    content: &'a Content,
    stimuli: Vec<StimulusFiles>,
    /// Index and picture of the stimulus that was looked at last.
    still: Option<(u32, Image)>,
    status: Option<SessionStatus>,
    /// The note that is being typed.
    note: Option<String>,
    is_closed: bool,
    words: Option<Image>,
    panel: Panel,
    stage: Stage,
}

/// Shows what it is told, and sends what the operator does, until the session ends or the window is closed.
///
/// # Errors
/// No window can be opened, or it was lost.
pub(super) fn run(
    content: &Content,
    inbox: &Receiver<WindowMessage>,
    inputs: &Sender<Input>,
) -> Result<(), StageError> {
    let options = DesktopOptions {
        mode: Mode::LeftEye,
        window: Some(SIZE),
        title: "cyclopean operator".to_owned(),
        is_beside: true,
        ..DesktopOptions::default()
    };
    let stage = Stage::open(&options)?;
    let panel = Panel::new(stage.gpu(), 26.0, content.font.as_deref(), false)?;
    let mut window = Window {
        content,
        stimuli: Vec::new(),
        still: None,
        status: None,
        note: None,
        is_closed: false,
        words: None,
        panel,
        stage,
    };
    let mut is_new = true;
    loop {
        loop {
            match inbox.try_recv() {
                Ok(WindowMessage::Stimuli(stimuli)) => window.stimuli = stimuli,
                Ok(WindowMessage::Status(status)) => (window.status, is_new) = (Some(*status), true),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
        }
        while let Some(event) = window.stage.wait()? {
            is_new = true;
            if let Some(input) = window.handle(event)
                && inputs.send(input).is_err()
            {
                return Ok(());
            }
        }
        if window.is_closed {
            return Ok(());
        }
        window.stage.frame();
        if std::mem::take(&mut is_new) {
            window.draw()?;
        }
        window.stage.present()?;
        std::thread::sleep(REST);
    }
}

impl Window<'_> {
    fn handle(&mut self, event: ShellEvent) -> Option<Input> {
        match event {
            ShellEvent::Key { key, modifiers, is_repeat } => match &mut self.note {
                Some(_) => self.type_key(&key),
                None if is_repeat => None,
                None => self.press(&key, modifiers),
            },
            ShellEvent::Close => {
                self.is_closed = true;
                None
            }
            _ => None,
        }
    }

    fn press(&mut self, key: &Key, modifiers: ModifiersState) -> Option<Input> {
        let Key::Character(c) = key else { return None };
        if modifiers.control_key() {
            return (modifiers.shift_key() && c.eq_ignore_ascii_case("a")).then_some(Input::Abandon);
        }
        match c.to_lowercase().as_str() {
            "p" => Some(Input::Pause { by_operator: true }),
            "c" => Some(Input::Continue),
            "r" => Some(Input::Repeat),
            "s" => Some(Input::Skip),
            "q" => Some(Input::Quit),
            "n" => {
                self.note = Some(String::new());
                None
            }
            _ => None,
        }
    }

    fn type_key(&mut self, key: &Key) -> Option<Input> {
        let text = self.note.as_mut()?;
        match key {
            Key::Named(NamedKey::Enter) => {
                let text = self.note.take().unwrap_or_default();
                return (!text.trim().is_empty()).then(|| Input::Note(text.trim().to_owned()));
            }
            Key::Named(NamedKey::Escape) => self.note = None,
            Key::Named(NamedKey::Backspace) => drop(text.pop()),
            Key::Named(NamedKey::Space) => text.push(' '),
            Key::Character(c) if text.chars().count() < 500 => text.push_str(c),
            _ => {}
        }
        None
    }

    /// What the participant is doing, in words; it never names a method.
    fn says(&self) -> String {
        let Some(SessionStatus { screen, .. }) = &self.status else { return "The session begins.".to_owned() };
        let progress = |presentation: u32| match self.content.presentations.get(presentation as usize) {
            Some(p) => p
                .progress
                .map_or(self.content.words.practice.clone(), |at| Words::progress(at, &self.content.words.progress)),
            None => String::new(),
        };
        match screen {
            Screen::Page(page) => format!("page: {}", page.phase()),
            Screen::Item(at) => {
                let item = self.content.items.get(*at);
                item.map_or(String::new(), |item| {
                    format!("{} {} of {}", item.question, item.progress.0, item.progress.1)
                })
            }
            Screen::Dots(at) => format!("stereogram {}", at + 1),
            Screen::Stimulus { presentation, attempt, show, .. } => {
                format!("{}, attempt {}: {}", progress(*presentation), attempt + 1, format!("{show:?}").to_lowercase())
            }
            Screen::Blank => "blank".to_owned(),
            Screen::Panel { presentation, chosen, reminder, .. } => {
                let chosen = chosen.map_or("no choice yet".to_owned(), |c| format!("choice {}", c + 1));
                format!("{}: {chosen}{}", progress(*presentation), if *reminder { ", reminded" } else { "" })
            }
        }
    }

    fn health(&self) -> String {
        let Some(SessionStatus { health, .. }) = &self.status else { return String::new() };
        let seen = match (health.is_unseen, health.is_unfocused) {
            (true, _) => "nobody looks",
            (false, true) => "input goes elsewhere",
            (false, false) => "seen",
        };
        format!(
            "{seen}   {:.0} Hz   {} frames, {} missed, {} not drawn   longest gap {:.0} ms",
            health.nominal_hz, health.frames, health.missed, health.unrendered, health.longest_gap_ms
        )
    }

    fn draw(&mut self) -> Result<(), StageError> {
        let Some((width, height)) = self.stage.size() else { return Ok(()) };
        let at = |y: f32| [0.0, y];
        let text = |text: String, y: f32, size: f32, corner: Corner| Note::Text { text, at: at(y), corner, size };
        let below = height as f32;
        let mut notes = vec![
            text(self.says(), 0.0, 0.9, Corner::UpperLeft),
            text(KEYS.to_owned(), below, 0.6, Corner::LowerLeft),
            text(self.health(), below - 30.0, 0.7, Corner::LowerLeft),
        ];
        if let Some(note) = &self.note {
            notes.push(text(format!("note (Enter keeps it, Esc drops it): {note}_"), 60.0, 0.8, Corner::UpperLeft));
        }
        let words = match self.words.take().filter(|w| w.extent() == (width, height)) {
            Some(words) => words,
            None => self.panel.image(width, height)?,
        };
        self.panel.write([&notes, &notes], [0.0; 4], &words)?;
        if let Some(SessionStatus { screen: Screen::Stimulus { stimulus, .. }, .. }) = self.status
            && self.still.as_ref().is_none_or(|(at, _)| *at != stimulus)
        {
            self.still = self.thumbnail(stimulus).map(|image| (stimulus, image));
        }
        let is_stimulus = matches!(self.status, Some(SessionStatus { screen: Screen::Stimulus { .. }, .. }));
        let picture = match &self.still {
            Some((_, image)) if is_stimulus => Picture::Stereo { image, is_encoded: false },
            _ => Picture::None,
        };
        let shape = self.still.as_ref().map_or((16, 9), |(_, image)| image.extent());
        self.stage.compose(&Composition {
            mode: Mode::LeftEye,
            picture,
            place: fit((width, height), shape, width, 70),
            words: &words,
            apart_px: 0,
            ground: GROUND,
            patch: None,
        })?;
        self.words = Some(words);
        Ok(())
    }

    /// A small version of the left eye's picture; none where it cannot be read, which the session has reported before.
    fn thumbnail(&self, stimulus: u32) -> Option<Image> {
        let files = self.stimuli.get(stimulus as usize)?;
        let sbs = crate::picture::read_png(files.first()).ok()?;
        let left = image::imageops::crop_imm(&sbs, 0, 0, (sbs.width() / 2).max(1), sbs.height()).to_image();
        let (width, height) = (left.width().min(640), (left.height() * left.width().min(640) / left.width()).max(1));
        let small = image::imageops::resize(&left, width, height, image::imageops::FilterType::Triangle);
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let desc = ImageDesc { usage, ..ImageDesc::stereo(width, height, vk::Format::R8G8B8A8_SRGB) };
        Image::with_layers(self.stage.gpu(), "thumbnail", desc, &[small.as_raw(), small.as_raw()]).ok()
    }
}
