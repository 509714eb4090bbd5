//! What presenting to a window needs: the extensions of instance and device ([`WithSurface`]), and the window's surface.

use std::cell::Cell;
use std::ffi::{CStr, c_char};
use std::rc::Rc;

use ash::vk;
use raw_window_handle::{RawDisplayHandle, RawWindowHandle};

use super::{Called, Creator, Gpu, GpuError};

/// Makes instance and device as `inner` does, and adds the extensions that presenting to windows of a display needs.
pub struct WithSurface<C> {
    inner: C,
    instance_extensions: Vec<*const c_char>,
    waits: Cell<bool>,
}

impl<C: Creator> WithSurface<C> {
    /// # Errors
    /// [`GpuError::Surface`] for a kind of display that Vulkan does not know.
    pub fn new(inner: C, display: RawDisplayHandle) -> Result<WithSurface<C>, GpuError> {
        let extensions =
            ash_window::enumerate_required_extensions(display).map_err(|e| GpuError::Surface(e.to_string()))?;
        Ok(WithSurface { inner, instance_extensions: extensions.to_vec(), waits: Cell::new(false) })
    }

    /// Whether the device can wait until a picture is shown (`VK_KHR_present_wait`). Valid after the device has been made.
    pub fn waits_for_presents(&self) -> bool {
        self.waits.get()
    }
}

impl<C: Creator> Creator for WithSurface<C> {
    fn create_instance(
        &self,
        entry: &ash::Entry,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<ash::Instance, GpuError> {
        // SAFETY: by Vulkan's rules the pointer leads to this many names, which live for the call.
        let mut names = unsafe { names(info.pp_enabled_extension_names, info.enabled_extension_count) };
        names.extend(&self.instance_extensions);
        let info = (*info).enabled_extension_names(&names);
        self.inner.create_instance(entry, &info)
    }

    fn choose(&self, instance: &ash::Instance) -> Result<vk::PhysicalDevice, GpuError> {
        self.inner.choose(instance)
    }

    fn create_device(
        &self,
        entry: &ash::Entry,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<ash::Device, GpuError> {
        // SAFETY: `physical` comes from this instance.
        let there = unsafe { instance.enumerate_device_extension_properties(physical) }
            .called("vkEnumerateDeviceExtensionProperties")?;
        let has = |name: &CStr| there.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        if !has(ash::khr::swapchain::NAME) {
            return Err(GpuError::Surface("the graphics device cannot present (no VK_KHR_swapchain)".to_owned()));
        }
        // SAFETY: as for the instance.
        let mut names = unsafe { names(info.pp_enabled_extension_names, info.enabled_extension_count) };
        names.push(ash::khr::swapchain::NAME.as_ptr());
        let mut id = vk::PhysicalDevicePresentIdFeaturesKHR::default();
        let mut wait = vk::PhysicalDevicePresentWaitFeaturesKHR::default();
        let mut waits = has(ash::khr::present_id::NAME) && has(ash::khr::present_wait::NAME);
        if waits {
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut id).push_next(&mut wait);
            // SAFETY: `physical` comes from this instance; the chain lives for the call.
            unsafe { instance.get_physical_device_features2(physical, &mut features) };
            waits = id.present_id == vk::TRUE && wait.present_wait == vk::TRUE;
        }
        self.waits.set(waits);
        let mut info = *info;
        (id.p_next, wait.p_next) = (std::ptr::null_mut(), std::ptr::null_mut());
        if waits {
            names.extend([ash::khr::present_id::NAME.as_ptr(), ash::khr::present_wait::NAME.as_ptr()]);
            info = info.push_next(&mut id).push_next(&mut wait);
        }
        let info = info.enabled_extension_names(&names);
        self.inner.create_device(entry, instance, physical, &info)
    }
}

/// # Safety
/// `first` leads to `count` names, or `count` is 0.
unsafe fn names(first: *const *const c_char, count: u32) -> Vec<*const c_char> {
    match count {
        0 => Vec::new(),
        // SAFETY: the caller's promise.
        _ => unsafe { std::slice::from_raw_parts(first, count as usize) }.to_vec(),
    }
}

/// A window's surface. It must be dropped before its window.
pub struct Surface {
    pub(super) raw: vk::SurfaceKHR,
    pub(super) functions: ash::khr::surface::Instance,
    pub(super) gpu: Rc<Gpu>,
}

impl Surface {
    /// `display` and `window` are the handles of a window that outlives the surface.
    ///
    /// # Errors
    /// [`GpuError::Surface`] when the device cannot present to it.
    pub fn new(gpu: &Rc<Gpu>, display: RawDisplayHandle, window: RawWindowHandle) -> Result<Surface, GpuError> {
        // SAFETY: the handles are those of a living window, and the instance has the extensions (`WithSurface`).
        let raw = unsafe { ash_window::create_surface(&gpu.entry, &gpu.instance, display, window, None) }
            .called("vkCreateSurface")?;
        let functions = ash::khr::surface::Instance::new(&gpu.entry, &gpu.instance);
        let surface = Surface { raw, functions, gpu: Rc::clone(gpu) };
        // SAFETY: surface, device and family are alive and belong together.
        let can = unsafe {
            surface.functions.get_physical_device_surface_support(gpu.physical, gpu.queue_family, surface.raw)
        };
        match can.called("vkGetPhysicalDeviceSurfaceSupportKHR")? {
            true => Ok(surface),
            false => Err(GpuError::Surface(format!("the device `{}` cannot present to it", gpu.info().name))),
        }
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: its swapchain owns it and has already been destroyed.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}
