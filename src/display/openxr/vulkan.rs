//! Makes the Vulkan instance, physical device and device as the runtime demands, by `XR_KHR_vulkan_enable2` (OpenXR
//! 12.20).

use ash::vk::{self, Handle as _};
use openxr as xr;

use super::runtime::Runtime;
use crate::gpu::{Creator, GpuError};

/// Turns a failure of the runtime into an error of the GPU layer.
fn refused(call: &'static str) -> impl Fn(xr::sys::Result) -> GpuError {
    move |result| GpuError::Runtime { call, result: format!("{result:?}") }
}

fn proc_addr(entry: &ash::Entry) -> xr::sys::platform::VkGetInstanceProcAddr {
    let ours = entry.static_fn().get_instance_proc_addr;
    // SAFETY: both types are the C signature of `vkGetInstanceProcAddr`; only the Rust names of the handle and of the
    // returned pointer differ, and both are pointer-sized.
    unsafe { std::mem::transmute::<vk::PFN_vkGetInstanceProcAddr, xr::sys::platform::VkGetInstanceProcAddr>(ours) }
}

impl Creator for Runtime {
    fn create_instance(
        &self,
        entry: &ash::Entry,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<ash::Instance, GpuError> {
        // The specification demands that the requirements are asked for before anything is made.
        let needs = self.instance.graphics_requirements::<xr::Vulkan>(self.system);
        let needs = needs.map_err(refused("xrGetVulkanGraphicsRequirements2KHR"))?;
        if needs.min_api_version_supported > xr::Version::new(1, 3, 0) {
            let result = format!("it wants Vulkan {}", needs.min_api_version_supported);
            return Err(GpuError::Runtime { call: "xrGetVulkanGraphicsRequirements2KHR", result });
        }
        // SAFETY: `info` is a whole VkInstanceCreateInfo that lives for the call; requirements were asked for; the
        // entry point is the loader's own.
        let made = unsafe {
            self.instance.create_vulkan_instance(self.system, proc_addr(entry), std::ptr::from_ref(info).cast())
        };
        let raw = made.map_err(refused("xrCreateVulkanInstanceKHR"))?.map_err(vk::Result::from_raw);
        let raw = raw.map_err(|result| GpuError::Vulkan { call: "vkCreateInstance", result })?;
        // SAFETY: the runtime has just made this instance through the loader's entry points; it is ours to destroy.
        Ok(unsafe { ash::Instance::load(entry.static_fn(), vk::Instance::from_raw(raw as u64)) })
    }

    fn choose(&self, instance: &ash::Instance) -> Result<vk::PhysicalDevice, GpuError> {
        // SAFETY: the instance was made by `create_instance` above and is alive.
        let raw = unsafe { self.instance.vulkan_graphics_device(self.system, instance.handle().as_raw() as _) };
        Ok(vk::PhysicalDevice::from_raw(raw.map_err(refused("xrGetVulkanGraphicsDevice2KHR"))? as u64))
    }

    fn create_device(
        &self,
        entry: &ash::Entry,
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<ash::Device, GpuError> {
        // SAFETY: `physical` is the runtime's choice for this instance; `info` is whole and lives for the call.
        let made = unsafe {
            self.instance.create_vulkan_device(
                self.system,
                proc_addr(entry),
                physical.as_raw() as _,
                std::ptr::from_ref(info).cast(),
            )
        };
        let raw = made.map_err(refused("xrCreateVulkanDeviceKHR"))?.map_err(vk::Result::from_raw);
        let raw = raw.map_err(|result| GpuError::Vulkan { call: "vkCreateDevice", result })?;
        // SAFETY: the runtime has just made this device of this instance; it is ours to destroy.
        Ok(unsafe { ash::Device::load(instance.fp_v1_0(), vk::Device::from_raw(raw as u64)) })
    }
}
