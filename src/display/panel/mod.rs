//! Draws pages, questions and the rating panel: they are laid out with egui and drawn into an image, once for each
//! change.
//!
//! There is one picture for each eye (layer 0 left, 1 right); they differ only for stereograms. The layout is this
//! program's, in ems that follow from the pixels per degree. egui shapes the text and makes the triangles, and
//! `egui-ash-renderer` draws them.

mod blocks;
mod note;
mod page;
mod style;

use std::rc::Rc;

use ash::vk;
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};

use super::content::Content;
use crate::gpu::{Frame, Gpu, GpuError, Image, ImageDesc, UploadPool};
use crate::study::protocol::{Input, Screen};

pub use note::{Corner, Note};
pub use style::em_px;

/// What is drawn: a screen, and the target that the viewer has reached.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    pub screen: Screen,
    /// The target that a pointer is on, or that was reached by a thumbstick or the Tab key.
    pub hover: Option<usize>,
    /// Seconds that are left, for a panel that shows its reminder; see [`Content::time_left_s`].
    pub time_left_s: Option<u32>,
    /// Centre of the letter `A` or `B` of a stimulus, pixels; none: the middle of the image.
    pub label_at: Option<[f32; 2]>,
}

impl View {
    pub fn of(screen: &Screen) -> View {
        View { screen: screen.clone(), hover: None, time_left_s: None, label_at: None }
    }
}

/// Something that can be pointed at.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Left, top, right and bottom edge, pixels of the image.
    pub rect: [f32; 4],
    pub input: Input,
}

/// What can be pointed at in a picture, and how it was drawn.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawnView {
    pub targets: Vec<Target>,
    /// Scale of the words; 1 is the size for the pixels per degree, and it is smaller where the words would not fit.
    pub scale: f32,
    /// Whether the eyes' pictures differ.
    pub is_stereo: bool,
}

impl DrawnView {
    /// Index of the target at a place, pixels from the upper left.
    pub fn at(&self, [x, y]: [f32; 2]) -> Option<usize> {
        self.targets.iter().position(|t| (t.rect[0]..t.rect[2]).contains(&x) && (t.rect[1]..t.rect[3]).contains(&y))
    }

    /// The input that choosing a target means.
    pub fn input(&self, target: usize) -> Option<Input> {
        self.targets.get(target).map(|t| t.input.clone())
    }
}

/// The triangles of one layer, with the changes of egui's textures that they need.
#[derive(Default)]
struct LaidOutLayer {
    primitives: Vec<egui::ClippedPrimitive>,
    set: Vec<(egui::TextureId, Vec<egui::epaint::ImageDelta>)>,
    free: Vec<egui::TextureId>,
}

/// Draws views. Fields are dropped in this order, so the renderer goes before the device.
pub struct Panel {
    context: egui::Context,
    px_per_degree: f32,
    shows_keys: bool,
    dot_px: usize,
    /// The left and right images of a stereogram, kept while its screen is shown.
    dots: Option<(usize, [egui::TextureHandle; 2])>,
    renderer: Renderer<GpuAllocator>,
    uploads: UploadPool,
    gpu: Rc<Gpu>,
}

/// The format of the images. The bytes are display values: copy them to an sRGB swapchain, or blit them to any.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

impl Panel {
    /// `px_per_degree`: pixels per degree at the centre of the images to come. `font`: see [`Content::font`].
    /// `shows_keys`: each choice shows its key, for keyboards.
    ///
    /// # Errors
    /// What Vulkan said.
    pub fn new(gpu: &Rc<Gpu>, px_per_degree: f32, font: Option<&[u8]>, shows_keys: bool) -> Result<Panel, GpuError> {
        let context = egui::Context::default();
        context.set_fonts(style::fonts(font));
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: FORMAT,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        // There is one vertex buffer for each eye, drawn in the same submission.
        let options = Options { in_flight_frames: 2, srgb_framebuffer: true, ..Options::default() };
        let renderer =
            Renderer::with_gpu_allocator(gpu.allocator(), gpu.device().clone(), mode, options).map_err(failed)?;
        let uploads = UploadPool::new(gpu)?;
        Ok(Panel { context, px_per_degree, shows_keys, dot_px: 1, dots: None, renderer, uploads, gpu: Rc::clone(gpu) })
    }

    /// Sets how many pixels wide and high a stereogram's dot is.
    pub fn set_dot_px(&mut self, dot_px: usize) {
        (self.dot_px, self.dots) = (dot_px.max(1), None);
    }

    /// An image that [`Panel::draw`] can draw into.
    ///
    /// # Errors
    /// There is no memory for it.
    pub fn image(&self, width: u32, height: u32) -> Result<Image, GpuError> {
        Image::new(&self.gpu, "panel", ImageDesc::stereo_target(width, height, FORMAT))
    }

    /// Draws both eyes' pictures and waits for them. Pages, items, dots, panels and the blank frame are opaque. For a
    /// stimulus, everything is transparent (premultiplied) except its letter and the mark.
    ///
    /// # Errors
    /// What Vulkan said.
    pub fn draw(&mut self, content: &Content, view: &View, into: &Image) -> Result<DrawnView, GpuError> {
        self.keep_dots(content, &view.screen);
        let (px_per_degree, shows_keys, dot_px) = (self.px_per_degree, self.shows_keys, self.dot_px);
        let dots = self.dots.as_ref().map(|(_, textures)| textures[0].id());
        let (drawn, left) = self.lay_out(into, |painter, size| {
            page::PageLayout { painter, content, view, size, px_per_degree, shows_keys, dot_px, dots }.draw()
        });
        let right = left.primitives.iter().cloned().map(|p| self.for_right_eye(p)).collect();
        let right = LaidOutLayer { primitives: right, ..LaidOutLayer::default() };
        let ground = content.blank.linear();
        let clear = match view.screen {
            Screen::Stimulus { .. } => [0.0; 4],
            _ => [ground, ground, ground, 1.0],
        };
        self.fill(into, clear, [left, right])?;
        Ok(drawn)
    }

    /// Draws plain notes: the left eye's and the right eye's. `clear`: linear, premultiplied.
    ///
    /// # Errors
    /// What Vulkan said.
    pub fn write(&mut self, notes: [&[Note]; 2], clear: [f32; 4], into: &Image) -> Result<(), GpuError> {
        let em = em_px(self.px_per_degree);
        let laid = notes.map(|notes| self.lay_out(into, |painter, _| note::draw(&painter, em, notes)).1);
        self.fill(into, clear, laid)
    }

    /// Turns shapes into triangles for an image of this size.
    fn lay_out<T>(&self, into: &Image, draw: impl FnOnce(egui::Painter, egui::Vec2) -> T) -> (T, LaidOutLayer) {
        let (width, height) = into.extent();
        let size = egui::vec2(width as f32, height as f32);
        self.context.begin_pass(egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size)),
            max_texture_side: Some(4096),
            ..egui::RawInput::default()
        });
        let drawn = draw(self.context.layer_painter(egui::LayerId::background()), size);
        let mut output = self.context.end_pass();
        // The changes are taken out of egui's type, which reports a bug when it is dropped with changes left.
        let laid = LaidOutLayer {
            set: std::mem::take(&mut output.textures_delta.set).into_iter().map(|(id, d)| (id, d.into_vec())).collect(),
            free: std::mem::take(&mut output.textures_delta.free).into_iter().collect(),
            primitives: self.context.tessellate(output.shapes, output.pixels_per_point),
        };
        (drawn, laid)
    }

    /// Draws both layers of an image.
    fn fill(&mut self, into: &Image, clear: [f32; 4], eyes: [LaidOutLayer; 2]) -> Result<(), GpuError> {
        let queue = self.gpu.queue().0;
        for (id, changes) in eyes.iter().flat_map(|laid| &laid.set) {
            for change in changes {
                self.renderer.set_texture(queue, self.uploads.raw(), *id, change).map_err(failed)?;
            }
        }
        let mut frame = Frame::begin(&self.gpu)?;
        for (layer, laid) in eyes.iter().enumerate() {
            let renderer = &mut self.renderer;
            frame.draw_foreign("panel", into, layer, clear, |canvas| {
                renderer.cmd_draw(canvas.commands, canvas.extent, 1.0, &laid.primitives).map_err(failed)
            })?;
        }
        frame.finish()?;
        for id in eyes.iter().flat_map(|laid| &laid.free) {
            self.renderer.free_texture(*id).map_err(failed)?;
        }
        Ok(())
    }

    /// Keeps the stereogram's textures while it is shown, and drops them otherwise.
    fn keep_dots(&mut self, content: &Content, screen: &Screen) {
        let Screen::Dots(at) = *screen else {
            self.dots = None;
            return;
        };
        if self.dots.as_ref().is_some_and(|(kept, _)| *kept == at) {
            return;
        }
        self.dots = content.dots.get(at).map(|dots| {
            let texture = |eye: usize| {
                // The dots are enlarged here, because the renderer's own sampler would smooth them.
                let (n, side) = (self.dot_px, self.dot_px * dots.size);
                let texel = |i: usize| dots.eyes[eye][i / side / n * dots.size + i % side / n];
                let bytes: Vec<u8> = (0..side * side).map(texel).collect();
                let image = egui::ColorImage::from_gray([side, side], &bytes);
                self.context.load_texture(["dots left", "dots right"][eye], image, egui::TextureOptions::NEAREST)
            };
            (at, [texture(0), texture(1)])
        });
    }

    fn for_right_eye(&self, mut primitive: egui::ClippedPrimitive) -> egui::ClippedPrimitive {
        if let (Some((_, [left, right])), egui::epaint::Primitive::Mesh(mesh)) = (&self.dots, &mut primitive.primitive)
            && mesh.texture_id == left.id()
        {
            mesh.texture_id = right.id();
        }
        primitive
    }
}

fn failed(error: RendererError) -> GpuError {
    match error {
        RendererError::Vulkan(result) => GpuError::Vulkan { call: "drawing the panel", result },
        other => GpuError::Memory { what: "the panel".to_owned(), bytes: 0, reason: other.to_string() },
    }
}
