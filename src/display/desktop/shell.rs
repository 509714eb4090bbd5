//! The window: opens it on a monitor and takes its events, while the event loop stays under this program's control.

use std::collections::VecDeque;
use std::time::Duration;

use raw_window_handle::{HasDisplayHandle, HasWindowHandle, RawDisplayHandle, RawWindowHandle};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{DeviceEvent, DeviceId, ElementState, MouseButton, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, ModifiersState};
use winit::monitor::MonitorHandle;
use winit::platform::pump_events::{EventLoopExtPumpEvents, PumpStatus};
use winit::window::{Fullscreen, Window, WindowId};

use super::options::DesktopOptions;

/// What happened to the window.
#[derive(Debug, Clone, PartialEq)]
pub enum ShellEvent {
    /// A key was pressed; `is_repeat`: it is being held.
    Key {
        key: Key,
        modifiers: ModifiersState,
        is_repeat: bool,
    },
    KeyUp(Key),
    /// The pointer moved to this place, pixels from the upper left.
    Pointer([f32; 2]),
    Click,
    /// The mouse button was released.
    Release,
    /// The mouse was moved by this much, wherever the pointer is.
    Moved([f32; 2]),
    Focus(bool),
    /// The window was covered or minimised (false), or is back (true).
    Visible(bool),
    Resized,
    /// Somebody wants the window closed.
    Close,
    /// The window is gone.
    Gone,
}

/// A monitor, for `doctor` and for messages.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct MonitorInfo {
    pub name: String,
    pub width_px: u32,
    pub height_px: u32,
    /// Refresh rate, Hz; none: the monitor does not state it.
    pub hz: Option<f64>,
}

impl MonitorInfo {
    fn of(monitor: &MonitorHandle) -> MonitorInfo {
        let size = monitor.size();
        MonitorInfo {
            name: monitor.name().unwrap_or_else(|| "a monitor without a name".to_owned()),
            width_px: size.width,
            height_px: size.height,
            hz: monitor.refresh_rate_millihertz().filter(|mhz| *mhz > 0).map(|mhz| f64::from(mhz) / 1000.0),
        }
    }
}

/// Why no window could be opened.
#[derive(Debug, Clone, thiserror::Error)]
pub enum ShellError {
    #[error("there is no desktop to open a window on ({0}); `cyclopean doctor` says more")]
    NoDesktop(String),
    #[error("a window on X needs libxkbcommon-x11.so.0, which is not installed; `cyclopean doctor` names its package")]
    NoKeyboardLibrary,
    #[error("no monitor is called `{wanted}` (there are: {known}); `cyclopean doctor` lists them")]
    NoMonitor { wanted: String, known: String },
    #[error("the window could not be opened: {0}")]
    Window(String),
}

/// The window and its events. The window is dropped before the event loop.
pub struct Shell {
    handler: Handler,
    events: EventLoop<()>,
}

struct Handler {
    options: DesktopOptions,
    queue: VecDeque<ShellEvent>,
    modifiers: ModifiersState,
    monitors: Vec<MonitorInfo>,
    /// The monitor on which the window was opened.
    monitor: Option<MonitorHandle>,
    is_minimized: bool,
    failed: Option<ShellError>,
    window: Option<Window>,
}

impl Shell {
    /// Opens the window and waits until it is there.
    ///
    /// # Errors
    /// [`ShellError`].
    pub fn open(options: &DesktopOptions) -> Result<Shell, ShellError> {
        let events = event_loop(options.is_beside)?;
        let handler = Handler {
            options: options.clone(),
            queue: VecDeque::new(),
            modifiers: ModifiersState::empty(),
            monitors: Vec::new(),
            monitor: None,
            is_minimized: false,
            failed: None,
            window: None,
        };
        let mut shell = Shell { handler, events };
        for _ in 0..100 {
            shell.pump(Duration::from_millis(20));
            if let Some(error) = shell.handler.failed.take() {
                return Err(error);
            }
            if shell.handler.window.is_some() {
                return Ok(shell);
            }
        }
        Err(ShellError::Window("the desktop did not answer within two seconds".to_owned()))
    }

    /// The window's handles, valid as long as the shell lives.
    ///
    /// # Errors
    /// The window is gone.
    pub fn handles(&self) -> Result<(RawDisplayHandle, RawWindowHandle), ShellError> {
        let window = self.handler.window.as_ref().ok_or_else(|| ShellError::Window("it is gone".to_owned()))?;
        let failed = |e: raw_window_handle::HandleError| ShellError::Window(e.to_string());
        Ok((window.display_handle().map_err(failed)?.as_raw(), window.window_handle().map_err(failed)?.as_raw()))
    }

    /// Collects what happened, and waits for it at most this long.
    pub fn pump(&mut self, at_most: Duration) {
        if let PumpStatus::Exit(_) = self.events.pump_app_events(Some(at_most), &mut self.handler) {
            self.handler.queue.push_back(ShellEvent::Gone);
        }
    }

    /// Takes the oldest event that was not taken yet.
    pub fn take(&mut self) -> Option<ShellEvent> {
        self.handler.queue.pop_front()
    }

    /// Size of the window, pixels; none while it has no area.
    pub fn size(&self) -> Option<(u32, u32)> {
        let size = self.handler.window.as_ref()?.inner_size();
        (size.width > 0 && size.height > 0).then_some((size.width, size.height))
    }

    /// The monitor that the window is on.
    pub fn monitor(&self) -> Option<MonitorInfo> {
        let window = self.handler.window.as_ref()?;
        window.current_monitor().or_else(|| self.handler.monitor.clone()).map(|m| MonitorInfo::of(&m))
    }

    /// Whether the monitor that the window fills was taken away.
    pub fn has_lost_its_monitor(&self) -> bool {
        let (Some(window), Some(monitor)) = (&self.handler.window, &self.handler.monitor) else { return false };
        self.handler.options.window.is_none() && !window.available_monitors().any(|m| m.name() == monitor.name())
    }

    /// Shows or hides the pointer over the window.
    pub fn show_pointer(&self, is_shown: bool) {
        if let Some(window) = &self.handler.window {
            window.set_cursor_visible(is_shown);
        }
    }
}

fn event_loop(is_beside: bool) -> Result<EventLoop<()>, ShellError> {
    // The messages of winit name a line of its source, and a missing library makes it panic, so both are checked here.
    #[cfg(target_os = "linux")]
    {
        let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        if !["WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(is_set) {
            if !is_set("DISPLAY") {
                return Err(ShellError::NoDesktop("neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned()));
            }
            if xkbcommon_dl::x11::xkbcommon_x11_option().is_none() {
                return Err(ShellError::NoKeyboardLibrary);
            }
        }
    }
    let mut builder = EventLoop::builder();
    #[cfg(target_os = "linux")]
    if is_beside {
        winit::platform::x11::EventLoopBuilderExtX11::with_any_thread(&mut builder, true);
        winit::platform::wayland::EventLoopBuilderExtWayland::with_any_thread(&mut builder, true);
    }
    if is_beside && !cfg!(target_os = "linux") {
        return Err(ShellError::Window("this system allows windows only on the first thread".to_owned()));
    }
    let events = builder.build().map_err(|error| {
        let name = if std::env::var_os("WAYLAND_DISPLAY").is_some() { "WAYLAND_DISPLAY" } else { "DISPLAY" };
        let value = std::env::var(name).unwrap_or_default();
        tracing::debug!("the desktop: {error}");
        ShellError::NoDesktop(format!("nothing answers at {name}={value}"))
    })?;
    events.set_control_flow(ControlFlow::Wait);
    Ok(events)
}

/// Every monitor of the desktop.
///
/// # Errors
/// [`ShellError::NoDesktop`].
pub fn monitors() -> Result<Vec<MonitorInfo>, ShellError> {
    struct MonitorQuery(Vec<MonitorInfo>);
    impl ApplicationHandler for MonitorQuery {
        fn resumed(&mut self, events: &ActiveEventLoop) {
            self.0 = events.available_monitors().map(|m| MonitorInfo::of(&m)).collect();
        }
        fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
    }
    let mut query = MonitorQuery(Vec::new());
    let mut events = event_loop(false)?;
    for _ in 0..20 {
        events.pump_app_events(Some(Duration::from_millis(10)), &mut query);
        if !query.0.is_empty() {
            break;
        }
    }
    Ok(query.0)
}

impl Handler {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<Window, ShellError> {
        let all: Vec<MonitorHandle> = events.available_monitors().collect();
        self.monitors = all.iter().map(MonitorInfo::of).collect();
        let chosen = match &self.options.monitor {
            None => events.primary_monitor().or_else(|| all.first().cloned()),
            Some(wanted) => {
                let number = wanted.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
                let named = |m: &&MonitorHandle| {
                    m.name().is_some_and(|name| name.to_lowercase().contains(&wanted.to_lowercase()))
                };
                let found = number.and_then(|n| all.get(n)).or_else(|| all.iter().find(named));
                Some(found.cloned().ok_or_else(|| {
                    let names: Vec<_> = self.monitors.iter().map(|m| m.name.clone()).collect();
                    ShellError::NoMonitor { wanted: wanted.clone(), known: names.join(", ") }
                })?)
            }
        };
        self.monitor.clone_from(&chosen);
        let attributes = Window::default_attributes().with_title(self.options.title.clone());
        let attributes = match self.options.window {
            Some((width, height)) => attributes.with_inner_size(PhysicalSize::new(width, height)),
            None => attributes.with_fullscreen(Some(Fullscreen::Borderless(chosen))),
        };
        events.create_window(attributes).map_err(|e| ShellError::Window(e.to_string()))
    }

    fn set_minimized(&mut self, is_minimized: bool) {
        if self.is_minimized != is_minimized {
            self.is_minimized = is_minimized;
            self.queue.push_back(ShellEvent::Visible(!is_minimized));
        }
    }
}

impl ApplicationHandler for Handler {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.window.is_none() {
            match self.open(events) {
                Ok(window) => self.window = Some(window),
                Err(error) => self.failed = Some(error),
            }
        }
    }

    fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let shell_event = match event {
            WindowEvent::KeyboardInput { event, .. } if event.state == ElementState::Pressed => {
                ShellEvent::Key { key: event.logical_key, modifiers: self.modifiers, is_repeat: event.repeat }
            }
            WindowEvent::KeyboardInput { event, .. } => ShellEvent::KeyUp(event.logical_key),
            WindowEvent::ModifiersChanged(modifiers) => {
                self.modifiers = modifiers.state();
                return;
            }
            WindowEvent::CursorMoved { position, .. } => ShellEvent::Pointer([position.x as f32, position.y as f32]),
            WindowEvent::CursorLeft { .. } => ShellEvent::Pointer([-1.0, -1.0]),
            WindowEvent::MouseInput { state: ElementState::Pressed, button: MouseButton::Left, .. } => {
                ShellEvent::Click
            }
            WindowEvent::MouseInput { state: ElementState::Released, button: MouseButton::Left, .. } => {
                ShellEvent::Release
            }
            WindowEvent::Focused(has) => ShellEvent::Focus(has),
            WindowEvent::Occluded(is) => {
                self.set_minimized(is);
                return;
            }
            WindowEvent::Resized(size) => {
                self.set_minimized(size.width == 0 || size.height == 0);
                ShellEvent::Resized
            }
            WindowEvent::CloseRequested => ShellEvent::Close,
            WindowEvent::Destroyed => ShellEvent::Gone,
            _ => return,
        };
        self.queue.push_back(shell_event);
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let DeviceEvent::MouseMotion { delta } = event {
            self.queue.push_back(ShellEvent::Moved([delta.0 as f32, delta.1 as f32]));
        }
    }
}
