//! Finds the loader, the runtime and the system (headset), which must be there before anything else can be asked.
//!
//! OpenXR 1.0, sections 4 (instance) and 5 (system).

use openxr as xr;

use super::quiet::quietly;
use crate::display::DisplayError;

/// A runtime with a headset.
pub struct Runtime {
    pub(super) instance: xr::Instance,
    pub(super) system: xr::SystemId,
    pub(super) blend: xr::EnvironmentBlendMode,
    pub(super) enabled: xr::ExtensionSet,
    /// Name and version of the runtime.
    pub name: String,
    /// Name of the headset.
    pub headset: String,
    /// The largest side of a swapchain image, pixels.
    pub(super) max_side_px: u32,
    /// Recommended size of one eye's image, pixels.
    pub(super) eye_px: (u32, u32),
}

/// The view configuration with two views, one for each eye.
pub(super) const VIEWS: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;

/// The error of this display, with what was wrong.
pub(super) fn failure(what: impl Into<String>) -> DisplayError {
    DisplayError { display: "openxr", what: what.into() }
}

/// Names the failed call in the error.
pub(super) trait CallContext<T> {
    fn in_call(self, call: &'static str) -> Result<T, DisplayError>;
}

impl<T> CallContext<T> for xr::Result<T> {
    fn in_call(self, call: &'static str) -> Result<T, DisplayError> {
        self.map_err(|result| {
            failure(match result {
                xr::sys::Result::ERROR_INSTANCE_LOST | xr::sys::Result::ERROR_RUNTIME_UNAVAILABLE => {
                    format!("the OpenXR runtime is gone ({call}); start it again, then go on with --resume")
                }
                xr::sys::Result::ERROR_SESSION_LOST => {
                    format!("the headset is gone ({call}); connect it again, then go on with --resume")
                }
                other => format!("{call} failed: {other:?}"),
            })
        })
    }
}

const LOADER: &str = if cfg!(windows) { "openxr_loader.dll" } else { "libopenxr_loader.so.1" };

impl Runtime {
    /// Asks the loader for the active runtime, and the runtime for a headset.
    ///
    /// # Errors
    /// One sentence that names what is missing. What the loader and the runtime print meanwhile is kept off the
    /// terminal.
    pub fn open() -> Result<Runtime, DisplayError> {
        quietly(Runtime::find)
    }

    fn find() -> Result<Runtime, DisplayError> {
        // SAFETY: loading the system's OpenXR loader runs its initialisers, which the system vouches for.
        let entry = unsafe { xr::Entry::load(&()) }.map_err(|_| {
            failure(format!(
                "there is no OpenXR loader ({LOADER}); `cyclopean doctor` names the package that brings it"
            ))
        })?;
        let no_runtime = |result: xr::sys::Result| {
            let place = match std::env::var("XR_RUNTIME_JSON") {
                Ok(file) => format!(" (XR_RUNTIME_JSON={file})"),
                Err(_) => String::new(),
            };
            failure(format!(
                "no OpenXR runtime answers{place}: {result:?}; start your headset's software, and see `cyclopean doctor`"
            ))
        };
        let there = entry.enumerate_extensions().map_err(no_runtime)?;
        if !there.khr_vulkan_enable2 {
            return Err(failure("the OpenXR runtime lacks XR_KHR_vulkan_enable2, without which nothing can be drawn"));
        }
        let mut enabled = xr::ExtensionSet::default();
        enabled.khr_vulkan_enable2 = true;
        enabled.khr_convert_timespec_time = there.khr_convert_timespec_time;
        #[cfg(windows)]
        {
            enabled.khr_win32_convert_performance_counter_time = there.khr_win32_convert_performance_counter_time;
        }
        enabled.ext_user_presence = there.ext_user_presence;
        enabled.fb_display_refresh_rate = there.fb_display_refresh_rate;
        enabled.bd_controller_interaction = there.bd_controller_interaction;
        let app = xr::ApplicationInfo {
            application_name: "cyclopean",
            application_version: 1,
            engine_name: "cyclopean",
            engine_version: 1,
            api_version: xr::Version::new(1, 0, 0),
        };
        let instance = entry.create_instance(&app, &enabled, &[], &()).map_err(no_runtime)?;
        let properties = instance.properties().in_call("xrGetInstanceProperties")?;
        let name = format!("{} {}", properties.runtime_name, properties.runtime_version);
        let system = instance.system(xr::FormFactor::HEAD_MOUNTED_DISPLAY).map_err(|result| match result {
            xr::sys::Result::ERROR_FORM_FACTOR_UNAVAILABLE | xr::sys::Result::ERROR_FORM_FACTOR_UNSUPPORTED => {
                failure(format!("{name} sees no headset; connect it and switch it on, and see `cyclopean doctor`"))
            }
            other => failure(format!("xrGetSystem failed: {other:?}")),
        })?;
        let properties = instance.system_properties(system).in_call("xrGetSystemProperties")?;
        let views = instance.enumerate_view_configuration_views(system, VIEWS);
        let views = views.in_call("xrEnumerateViewConfigurationViews")?;
        let eye_px = views.first().map(|v| (v.recommended_image_rect_width, v.recommended_image_rect_height));
        let eye_px = eye_px.ok_or_else(|| failure(format!("{name} has no stereo views")))?;
        let blends = instance.enumerate_environment_blend_modes(system, VIEWS);
        let blends = blends.in_call("xrEnumerateEnvironmentBlendModes")?;
        let blend = blends.iter().find(|b| **b == xr::EnvironmentBlendMode::OPAQUE).or(blends.first());
        let graphics = properties.graphics_properties;
        Ok(Runtime {
            system,
            blend: *blend.ok_or_else(|| failure(format!("{name} has no blend mode")))?,
            enabled,
            name,
            headset: properties.system_name,
            max_side_px: graphics.max_swapchain_image_width.min(graphics.max_swapchain_image_height),
            eye_px,
            instance,
        })
    }

    /// The time of the runtime's clock now; none where it cannot be asked.
    pub(super) fn now_ns(&self) -> Option<i64> {
        #[cfg(windows)]
        let asked = self.instance.exts().khr_win32_convert_performance_counter_time.is_some();
        #[cfg(not(windows))]
        let asked = self.instance.exts().khr_convert_timespec_time.is_some();
        asked.then(|| self.instance.now().ok()).flatten().map(xr::Time::as_nanos)
    }
}
