//! The open device with its queue, allocator, pipeline cache and validation messages.
//!
//! Everything else of this folder is made from a [`Gpu`] and holds an `Rc` to it.

use std::ffi::{CStr, c_void};
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use cyclopean_analysis::{files, terminal};
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};

use super::create::text;
use super::pipelines::Pipelines;
use super::ray_tracing::{EXTENSIONS, RayTracing};
use super::{Called, Creator, GpuError};

/// How to open the device.
#[derive(Debug, Clone, Default)]
pub struct GpuOptions {
    /// Validation with synchronisation checks: slow, for tests. Messages are counted, see [`Gpu::check_validation`].
    pub validation: bool,
    /// The folder in which compiled pipelines are kept between runs; `None`: they are not kept.
    pub pipeline_cache: Option<PathBuf>,
}

impl GpuOptions {
    /// Validation is on if `CYCLOPEAN_VALIDATION` is `1`. The pipeline cache lies in the user's cache folder.
    pub fn from_environment() -> GpuOptions {
        let cache = std::env::var_os("XDG_CACHE_HOME")
            .map(PathBuf::from)
            .or_else(|| std::env::var_os("HOME").map(|h| PathBuf::from(h).join(".cache")));
        GpuOptions {
            validation: std::env::var_os("CYCLOPEAN_VALIDATION").is_some_and(|v| v == "1"),
            pipeline_cache: cache.map(|c| c.join("cyclopean")),
        }
    }
}

/// The device, as the journal and `render.json` describe it.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct DeviceInfo {
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    pub kind: &'static str,
    pub driver: String,
    pub vulkan: String,
}

/// The open device. Everything made from it holds an `Rc` to it, so it is destroyed last.
pub struct Gpu {
    pub(super) device: ash::Device,
    pub(super) queue: vk::Queue,
    pub(super) queue_family: u32,
    pub(super) timestamp_period_ns: f32,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) pipeline_cache: vk::PipelineCache,
    pub(super) pipelines: Pipelines,
    pub(super) limits: vk::PhysicalDeviceLimits,
    ray_tracing: Option<RayTracing>,
    info: DeviceInfo,
    cache_file: Option<PathBuf>,
    /// Shared with libraries that draw with their own buffers (see [`Gpu::allocator`]).
    pub(super) allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Mutex<Vec<String>>>,
    pub(super) instance: ash::Instance,
    pub(super) entry: ash::Entry,
}

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

impl Gpu {
    /// Opens a device made by `creator`.
    ///
    /// # Errors
    /// [`GpuError`] naming what is missing.
    pub fn open(creator: &dyn Creator, options: &GpuOptions) -> Result<Rc<Gpu>, GpuError> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which the system vouches for.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoLoader(e.to_string()))?;
        let messages = Box::new(Mutex::new(Vec::new()));
        let instance = create_instance(&entry, creator, options)?;
        let messenger = if options.validation { Some(watch(&entry, &instance, &messages)?) } else { None };
        let physical = creator.choose(&instance)?;
        // SAFETY: `physical` comes from this instance.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let info = describe(&instance, physical, &properties);
        let lacks = |what: &str| GpuError::Lacks { device: info.name.clone(), what: what.to_owned() };

        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let family = families
            .iter()
            .position(|f| f.queue_flags.contains(both) && f.timestamp_valid_bits > 0)
            .ok_or_else(|| lacks("a queue for graphics and compute with timestamps"))? as u32;

        let scratch_alignment = ray_query_of(&instance, physical)?;
        let device =
            create_device((&entry, &instance), physical, creator, family, (scratch_alignment.is_some(), &lacks))?;
        // SAFETY: the family was given one queue at creation.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device: physical,
            debug_settings: Default::default(),
            buffer_device_address: scratch_alignment.is_some(),
            allocation_sizes: Default::default(),
        })
        .map_err(|e| GpuError::Memory {
            what: "the allocator".to_owned(),
            bytes: 0,
            reason: e.to_string(),
        })?;

        let cache_file = options.pipeline_cache.as_ref().map(|folder| {
            let uuid: String = properties.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
            folder.join(format!("pipelines-{uuid}.bin"))
        });
        // Without a cache, or with another driver's, pipelines are only compiled again; drivers check the header themselves.
        let data = cache_file.as_ref().and_then(|f| files::read(f, files::MOST_DATA).ok()).unwrap_or_default();
        let create = vk::PipelineCacheCreateInfo::default().initial_data(&data);
        // SAFETY: `data` lives for the call.
        let pipeline_cache = unsafe { device.create_pipeline_cache(&create, None) }.called("vkCreatePipelineCache")?;

        let ray_tracing = scratch_alignment.map(|scratch_alignment| RayTracing {
            functions: ash::khr::acceleration_structure::Device::new(&instance, &device),
            scratch_alignment,
        });

        Ok(Rc::new(Gpu {
            device,
            queue,
            queue_family: family,
            timestamp_period_ns: properties.limits.timestamp_period,
            physical,
            pipeline_cache,
            pipelines: Pipelines::default(),
            limits: properties.limits,
            ray_tracing,
            info,
            cache_file,
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            messenger,
            messages,
            instance,
            entry,
        }))
    }

    /// Name, kind, driver.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Whether the device is a software device (it runs on the processor). The commands then make smaller images, and say so.
    pub fn is_cpu(&self) -> bool {
        self.info.kind == "cpu"
    }

    /// Whether shaders may trace rays through acceleration structures (`VK_KHR_ray_query`).
    pub fn has_ray_query(&self) -> bool {
        self.ray_tracing.is_some()
    }

    /// Whether the validation layer is on, which makes everything slower.
    pub fn has_validation(&self) -> bool {
        self.messenger.is_some()
    }

    pub(super) fn ray_tracing(&self) -> Result<&RayTracing, GpuError> {
        let lacks = || GpuError::Lacks { device: self.info.name.clone(), what: "ray queries".to_owned() };
        self.ray_tracing.as_ref().ok_or_else(lacks)
    }

    /// The largest storage buffer a shader may see, bytes.
    pub fn max_storage_bytes(&self) -> u64 {
        u64::from(self.limits.max_storage_buffer_range)
    }

    /// Size of the largest device-local heap, bytes; of a software device that is the computer's memory.
    pub fn local_memory_bytes(&self) -> u64 {
        // SAFETY: the physical device belongs to this instance.
        let memory = unsafe { self.instance.get_physical_device_memory_properties(self.physical) };
        let local = |heap: &&vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
        memory.memory_heaps_as_slice().iter().filter(local).map(|heap| heap.size).max().unwrap_or(0)
    }

    /// The largest number of layers that an image may have.
    pub fn max_layers(&self) -> usize {
        self.limits.max_image_array_layers as usize
    }

    /// Fails with the first message of the validation layer, if there has been any.
    ///
    /// # Errors
    /// [`GpuError::Validation`].
    pub fn check_validation(&self) -> Result<(), GpuError> {
        let messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        match messages.first() {
            None => Ok(()),
            Some(first) => Err(GpuError::Validation { count: messages.len(), first: first.clone() }),
        }
    }

    pub(super) fn allocate(
        &self,
        what: &str,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Result<Allocation, GpuError> {
        let desc = AllocationCreateDesc {
            name: what,
            requirements,
            location,
            linear,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner).allocate(&desc).map_err(|e| GpuError::Memory {
            what: what.to_owned(),
            bytes: requirements.size,
            reason: e.to_string(),
        })
    }

    pub(super) fn free(&self, allocation: Allocation) {
        if let Err(error) = self.allocator.lock().unwrap_or_else(PoisonError::into_inner).free(allocation) {
            tracing::warn!("device memory was not freed: {error}");
        }
    }

    /// Writes the compiled pipelines to the cache file, for the next run.
    fn save_cache(&self) {
        let Some(file) = &self.cache_file else { return };
        // SAFETY: the cache belongs to this device.
        let data = unsafe { self.device.get_pipeline_cache_data(self.pipeline_cache) };
        let saved = data.map_err(|e| e.to_string()).and_then(|bytes| {
            if let Some(folder) = file.parent() {
                std::fs::create_dir_all(folder).map_err(|e| e.to_string())?;
            }
            cyclopean_analysis::files::write_bytes(file, &bytes).map_err(|e| e.to_string())
        });
        if let Err(reason) = saved {
            tracing::info!("compiled pipelines were not kept: {reason}");
        }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        self.save_cache();
        // SAFETY: everything made from the device holds an `Rc` to this and is already destroyed. The allocator is dropped
        // before its device, and the messenger is destroyed before its instance.
        unsafe {
            if let Err(error) = self.device.device_wait_idle() {
                tracing::warn!("the device did not come to rest: {error}");
            }
            self.pipelines.destroy(&self.device);
            self.device.destroy_pipeline_cache(self.pipeline_cache, None);
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

fn create_instance(entry: &ash::Entry, creator: &dyn Creator, options: &GpuOptions) -> Result<ash::Instance, GpuError> {
    let app = vk::ApplicationInfo::default()
        .application_name(c"cyclopean")
        .engine_name(c"cyclopean")
        .api_version(vk::API_VERSION_1_3);
    let mut layers = Vec::new();
    let mut extensions = Vec::new();
    if options.validation {
        // SAFETY: the loader is loaded.
        let there =
            unsafe { entry.enumerate_instance_layer_properties() }.called("vkEnumerateInstanceLayerProperties")?;
        if !there.iter().any(|l| text(&l.layer_name).as_bytes() == VALIDATION_LAYER.to_bytes()) {
            return Err(GpuError::NoValidation);
        }
        layers.push(VALIDATION_LAYER.as_ptr());
        extensions.push(ash::ext::debug_utils::NAME.as_ptr());
        extensions.push(ash::ext::validation_features::NAME.as_ptr());
    }
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&app)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&extensions);
    if options.validation {
        info = info.push_next(&mut features);
    }
    creator.create_instance(entry, &info)
}

/// The alignment of scratch memory that the device requires, if it has ray queries; otherwise `None`.
fn ray_query_of(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Result<Option<u64>, GpuError> {
    // SAFETY: `physical` comes from this instance; also below.
    let there = unsafe { instance.enumerate_device_extension_properties(physical) }
        .called("vkEnumerateDeviceExtensionProperties")?;
    let has = |name: &CStr| there.iter().any(|e| text(&e.extension_name).as_bytes() == name.to_bytes());
    if !EXTENSIONS.iter().all(|name| has(name)) {
        return Ok(None);
    }
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default();
    let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default();
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features =
        vk::PhysicalDeviceFeatures2::default().push_next(&mut structures).push_next(&mut queries).push_next(&mut v12);
    // SAFETY: the chain's structures live for the call.
    unsafe { instance.get_physical_device_features2(physical, &mut features) };
    let all = structures.acceleration_structure & queries.ray_query & v12.buffer_device_address;
    let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
    let mut more = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
    // SAFETY: as above.
    unsafe { instance.get_physical_device_properties2(physical, &mut more) };
    let alignment = limits.min_acceleration_structure_scratch_offset_alignment.max(1);
    Ok((all == vk::TRUE).then_some(u64::from(alignment)))
}

fn create_device(
    (entry, instance): (&ash::Entry, &ash::Instance),
    physical: vk::PhysicalDevice,
    creator: &dyn Creator,
    family: u32,
    (ray_query, lacks): (bool, &dyn Fn(&str) -> GpuError),
) -> Result<ash::Device, GpuError> {
    // SAFETY: `physical` comes from this instance.
    let there = unsafe { instance.get_physical_device_features(physical) };
    if there.sampler_anisotropy == vk::FALSE {
        return Err(lacks("anisotropic filtering"));
    }
    if there.shader_storage_image_extended_formats == vk::FALSE {
        return Err(lacks("two-channel storage images"));
    }
    let mut v13 =
        vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true).maintenance4(true);
    let wanted = vk::PhysicalDeviceFeatures::default().sampler_anisotropy(true);
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&priorities)];
    // Not `PhysicalDeviceVulkan12Features`: an OpenXR runtime may add one of the structures that it replaces, and Vulkan forbids
    // both in one chain.
    let mut addresses = vk::PhysicalDeviceBufferDeviceAddressFeatures::default().buffer_device_address(true);
    let mut structures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
    let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
    let extensions = EXTENSIONS.map(CStr::as_ptr);
    let mut info =
        vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&wanted).push_next(&mut v13);
    if ray_query {
        info = info
            .enabled_extension_names(&extensions)
            .push_next(&mut addresses)
            .push_next(&mut structures)
            .push_next(&mut queries);
    }
    creator.create_device(entry, instance, physical, &info)
}

fn describe(instance: &ash::Instance, physical: vk::PhysicalDevice, p: &vk::PhysicalDeviceProperties) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut more = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: `physical` comes from this instance and the chain lives for the call.
    unsafe { instance.get_physical_device_properties2(physical, &mut more) };
    let kind = match p.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    };
    let v = p.api_version;
    DeviceInfo {
        name: text(&p.device_name),
        kind,
        driver: format!("{} {}", text(&driver.driver_name), text(&driver.driver_info)),
        vulkan: format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v)),
    }
}

fn watch(
    entry: &ash::Entry,
    instance: &ash::Instance,
    messages: &Mutex<Vec<String>>,
) -> Result<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT), GpuError> {
    let functions = ash::ext::debug_utils::Instance::new(entry, instance);
    let severity = vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR;
    let kinds = vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE;
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(severity)
        .message_type(kinds)
        .pfn_user_callback(Some(heard))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast());
    // SAFETY: `messages` is boxed in the `Gpu` and outlives the messenger, which `Drop` destroys first.
    let messenger =
        unsafe { functions.create_debug_utils_messenger(&info, None) }.called("vkCreateDebugUtilsMessenger")?;
    Ok((functions, messenger))
}

/// Prints a message of the validation layer and keeps it for [`Gpu::check_validation`].
unsafe extern "system" fn heard(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes the documented callback data and our own pointer to a living mutex (see `watch`).
    let (text, messages) = unsafe {
        let message = (*data).p_message;
        let text =
            if message.is_null() { String::new() } else { CStr::from_ptr(message).to_string_lossy().into_owned() };
        (text, &*user.cast::<Mutex<Vec<String>>>())
    };
    terminal::say(&format!("vulkan validation: {text}\n"));
    messages.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    vk::FALSE
}
