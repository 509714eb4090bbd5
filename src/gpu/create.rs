//! How the Vulkan instance and device are made: by ourselves ([`OwnDevice`]), or behind the same trait with a window's
//! extensions (`WithSurface`) or by an OpenXR runtime (`display::openxr`). `Gpu::open` calls the trait.

use std::ffi::CStr;

use ash::vk;

use super::{Called, GpuError};

/// Makes the instance, chooses the physical device and makes the device. These are the three steps that an OpenXR runtime takes
/// over with `XR_KHR_vulkan_enable2`.
pub trait Creator {
    /// Makes the instance.
    ///
    /// # Errors
    /// The error of the loader or the runtime.
    fn create_instance(&self, entry: &ash::Entry, info: &vk::InstanceCreateInfo<'_>)
    -> Result<ash::Instance, GpuError>;

    /// Picks the physical device.
    ///
    /// # Errors
    /// [`GpuError::NoDevice`] when none fits.
    fn choose(&self, instance: &ash::Instance) -> Result<vk::PhysicalDevice, GpuError>;

    /// Makes the device.
    ///
    /// # Errors
    /// The error of the driver or the runtime.
    fn create_device(
        &self,
        entry: &ash::Entry,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<ash::Device, GpuError>;
}

/// Makes both without a runtime. It prefers discrete to integrated to virtual to software devices, among all of them or among
/// those whose name contains `name`.
#[derive(Debug, Clone, Default)]
pub struct OwnDevice {
    /// Part of the device's name; upper and lower case count as equal.
    pub name: Option<String>,
}

impl Creator for OwnDevice {
    fn create_instance(
        &self,
        entry: &ash::Entry,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<ash::Instance, GpuError> {
        // SAFETY: `info` and what it points to live for the call; the caller keeps `entry` longer than the instance.
        unsafe { entry.create_instance(info, None) }.called("vkCreateInstance")
    }

    fn choose(&self, instance: &ash::Instance) -> Result<vk::PhysicalDevice, GpuError> {
        let devices = physical_devices(instance)?;
        let wanted = self.name.as_ref().map(|n| n.to_lowercase());
        let known: Vec<&str> = devices.iter().map(|d| d.name.as_str()).collect();
        devices
            .iter()
            .filter(|d| d.api_version >= vk::API_VERSION_1_3)
            .filter(|d| wanted.as_ref().is_none_or(|w| d.name.to_lowercase().contains(w)))
            .min_by_key(|d| rank(d.kind))
            .map(|d| d.handle)
            .ok_or_else(|| {
                GpuError::NoDevice(match &self.name {
                    Some(name) => format!(" whose name contains `{name}` (there are: {})", known.join(", ")),
                    None if known.is_empty() => String::new(),
                    None => format!(" (older ones: {})", known.join(", ")),
                })
            })
    }

    fn create_device(
        &self,
        _entry: &ash::Entry,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<ash::Device, GpuError> {
        // SAFETY: `physical` came from `instance`; `info` and what it points to live for the call.
        unsafe { instance.create_device(physical, info, None) }.called("vkCreateDevice")
    }
}

fn rank(kind: vk::PhysicalDeviceType) -> u32 {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
        vk::PhysicalDeviceType::CPU => 3,
        _ => 4,
    }
}

struct Physical {
    handle: vk::PhysicalDevice,
    name: String,
    kind: vk::PhysicalDeviceType,
    api_version: u32,
}

fn physical_devices(instance: &ash::Instance) -> Result<Vec<Physical>, GpuError> {
    // SAFETY: the instance is alive.
    let handles = unsafe { instance.enumerate_physical_devices() }.called("vkEnumeratePhysicalDevices")?;
    Ok(handles
        .into_iter()
        .map(|handle| {
            // SAFETY: `handle` was just enumerated from this instance.
            let p = unsafe { instance.get_physical_device_properties(handle) };
            Physical { handle, name: text(&p.device_name), kind: p.device_type, api_version: p.api_version }
        })
        .collect())
}

/// The text of one of Vulkan's fixed-size C strings.
pub(super) fn text(chars: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = chars.iter().map(|&c| c as u8).collect();
    CStr::from_bytes_until_nul(&bytes).map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Name, kind and Vulkan version of every device, for `doctor`.
///
/// # Errors
/// [`GpuError::NoLoader`] without a loader, else the error of the failed Vulkan call.
pub fn list_devices() -> Result<Vec<(String, String, String)>, GpuError> {
    // SAFETY: loading the system's Vulkan loader runs its initialisers, which the system vouches for.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoLoader(e.to_string()))?;
    let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
    let instance =
        OwnDevice::default().create_instance(&entry, &vk::InstanceCreateInfo::default().application_info(&app))?;
    let devices = physical_devices(&instance);
    // SAFETY: nothing made from the instance is left.
    unsafe { instance.destroy_instance(None) };
    Ok(devices?
        .into_iter()
        .map(|d| {
            let v = d.api_version;
            let version =
                format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v));
            (d.name, format!("{:?}", d.kind), version)
        })
        .collect())
}
