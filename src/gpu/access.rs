//! Tracks how each image and buffer was last used, and derives the barrier that its next use needs.
//!
//! [`Frame`](super::Frame) and the pass chains declare each use; nothing else writes barriers.

use ash::vk;

/// One way of using a resource.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Use {
    pub(super) layout: vk::ImageLayout,
    pub(super) stage: vk::PipelineStageFlags2,
    pub(super) access: vk::AccessFlags2,
    pub(super) writes: bool,
}

type Stage = vk::PipelineStageFlags2;
type Access = vk::AccessFlags2;

impl Use {
    const fn new(layout: vk::ImageLayout, stage: Stage, access: Access, writes: bool) -> Use {
        Use { layout, stage, access, writes }
    }

    /// Sampled or fetched by a compute shader.
    pub const SAMPLED: Use =
        Use::new(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, Stage::COMPUTE_SHADER, Access::SHADER_SAMPLED_READ, false);
    /// Sampled by a fragment shader.
    pub const SAMPLED_FRAGMENT: Use =
        Use::new(vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, Stage::FRAGMENT_SHADER, Access::SHADER_SAMPLED_READ, false);
    /// Written as a storage image or buffer by a compute shader.
    pub const STORAGE_WRITE: Use =
        Use::new(vk::ImageLayout::GENERAL, Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_WRITE, true);
    /// Read and written as a storage image or buffer by a compute shader.
    pub const STORAGE_READ_WRITE: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::COMPUTE_SHADER,
        Access::from_raw(Access::SHADER_STORAGE_READ.as_raw() | Access::SHADER_STORAGE_WRITE.as_raw()),
        true,
    );
    /// Read as a storage buffer by a compute shader.
    pub const STORAGE_READ: Use =
        Use::new(vk::ImageLayout::GENERAL, Stage::COMPUTE_SHADER, Access::SHADER_STORAGE_READ, false);
    /// Read as a storage buffer by the stages of a raster pass.
    pub const STORAGE_READ_RASTER: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::from_raw(Stage::VERTEX_SHADER.as_raw() | Stage::FRAGMENT_SHADER.as_raw()),
        Access::SHADER_STORAGE_READ,
        false,
    );
    /// Read as a uniform buffer by the stages of a raster pass.
    pub const UNIFORM_RASTER: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::from_raw(Stage::VERTEX_SHADER.as_raw() | Stage::FRAGMENT_SHADER.as_raw()),
        Access::UNIFORM_READ,
        false,
    );
    /// Read as a uniform buffer.
    pub const UNIFORM: Use = Use::new(vk::ImageLayout::GENERAL, Stage::COMPUTE_SHADER, Access::UNIFORM_READ, false);
    /// An acceleration structure that a compute shader traces rays through.
    pub const STRUCTURE_READ: Use =
        Use::new(vk::ImageLayout::GENERAL, Stage::COMPUTE_SHADER, Access::ACCELERATION_STRUCTURE_READ_KHR, false);
    /// Positions or instances from which an acceleration structure is built.
    pub const STRUCTURE_INPUT: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
        Access::from_raw(Access::SHADER_READ.as_raw() | Access::ACCELERATION_STRUCTURE_READ_KHR.as_raw()),
        false,
    );
    /// A bottom-level acceleration structure to which a top-level one that is being built refers.
    pub const STRUCTURE_BUILD_READ: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
        Access::ACCELERATION_STRUCTURE_READ_KHR,
        false,
    );
    /// An acceleration structure being built, or its scratch memory.
    pub const STRUCTURE_BUILD: Use = Use::new(
        vk::ImageLayout::GENERAL,
        Stage::ACCELERATION_STRUCTURE_BUILD_KHR,
        Access::from_raw(
            Access::ACCELERATION_STRUCTURE_READ_KHR.as_raw() | Access::ACCELERATION_STRUCTURE_WRITE_KHR.as_raw(),
        ),
        true,
    );
    /// A colour attachment, cleared or blended over.
    pub const COLOR: Use = Use::new(
        vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        Stage::COLOR_ATTACHMENT_OUTPUT,
        Access::from_raw(Access::COLOR_ATTACHMENT_READ.as_raw() | Access::COLOR_ATTACHMENT_WRITE.as_raw()),
        true,
    );
    /// A depth attachment that is tested and written.
    pub const DEPTH: Use = Use::new(
        vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL,
        Stage::from_raw(Stage::EARLY_FRAGMENT_TESTS.as_raw() | Stage::LATE_FRAGMENT_TESTS.as_raw()),
        Access::from_raw(
            Access::DEPTH_STENCIL_ATTACHMENT_READ.as_raw() | Access::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
        ),
        true,
    );
    /// Source of a copy.
    pub const COPY_SOURCE: Use =
        Use::new(vk::ImageLayout::TRANSFER_SRC_OPTIMAL, Stage::ALL_TRANSFER, Access::TRANSFER_READ, false);
    /// Destination of a copy, fill or clear.
    pub const COPY_TARGET: Use =
        Use::new(vk::ImageLayout::TRANSFER_DST_OPTIMAL, Stage::ALL_TRANSFER, Access::TRANSFER_WRITE, true);
    /// Arguments of an indirect dispatch.
    pub const INDIRECT: Use =
        Use::new(vk::ImageLayout::GENERAL, Stage::DRAW_INDIRECT, Access::INDIRECT_COMMAND_READ, false);
    /// Read by the host after the frame.
    pub const HOST_READ: Use = Use::new(vk::ImageLayout::GENERAL, Stage::HOST, Access::HOST_READ, false);
}

/// The last write of a resource and the reads since, for which a next use may have to wait.
#[derive(Debug, Clone, Copy)]
pub(super) struct AccessState {
    layout: vk::ImageLayout,
    write_stage: Stage,
    write_access: Access,
    read_stage: Stage,
    read_access: Access,
}

/// Source and destination of a barrier.
#[derive(Debug, Clone, Copy)]
pub(super) struct Barrier {
    pub old_layout: vk::ImageLayout,
    pub new_layout: vk::ImageLayout,
    pub src_stage: Stage,
    pub src_access: Access,
    pub dst_stage: Stage,
    pub dst_access: Access,
}

impl AccessState {
    /// A resource that has not been used; its content is undefined.
    pub(super) const NEW: AccessState = AccessState {
        layout: vk::ImageLayout::UNDEFINED,
        write_stage: Stage::NONE,
        write_access: Access::NONE,
        read_stage: Stage::NONE,
        read_access: Access::NONE,
    };

    /// A colour image that its owner (a compositor) has just handed over. The owner's work on it is finished, or the first use
    /// waits for it.
    pub(super) const HANDED_OVER: AccessState = AccessState {
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        write_stage: Stage::ALL_COMMANDS,
        write_access: Access::MEMORY_WRITE,
        read_stage: Stage::NONE,
        read_access: Access::NONE,
    };

    /// The barrier before `next`, if it needs one, and the state after it. Buffers ignore the layouts.
    pub(super) fn then(&self, next: Use, is_image: bool) -> (Option<Barrier>, AccessState) {
        let changes_layout = is_image && self.layout != next.layout;
        // The stages and the accesses of the readers are kept as two separate unions. These say for certain that this use has
        // waited for the write only if one of them consists of nothing but this use. Otherwise it waits once more.
        let known = self.read_stage.contains(next.stage) && self.read_access.contains(next.access);
        let seen = known && (self.read_access == next.access || self.read_stage == next.stage);
        let barrier = Barrier {
            old_layout: self.layout,
            new_layout: next.layout,
            src_stage: self.write_stage | self.read_stage,
            // A write after reads needs only an execution dependency on them.
            src_access: self.write_access,
            dst_stage: next.stage,
            dst_access: next.access,
        };
        if next.writes || changes_layout {
            let untouched = self.write_stage == Stage::NONE && self.read_stage == Stage::NONE;
            let needed = changes_layout || !untouched;
            let after = AccessState {
                layout: next.layout,
                // A layout transition counts as a write that this use has already waited for.
                write_stage: next.stage,
                write_access: if next.writes { next.access } else { Access::NONE },
                read_stage: if next.writes { Stage::NONE } else { next.stage },
                read_access: if next.writes { Access::NONE } else { next.access },
            };
            return (needed.then_some(barrier), after);
        }
        let after = AccessState {
            read_stage: self.read_stage | next.stage,
            read_access: self.read_access | next.access,
            ..*self
        };
        if seen || self.write_stage == Stage::NONE {
            return (None, after);
        }
        // A reader waits only for the last write.
        (Some(Barrier { src_stage: self.write_stage, ..barrier }), after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_read_after_a_write_waits_once() {
        let (first, state) = AccessState::NEW.then(Use::STORAGE_WRITE, true);
        assert_eq!(first.map(|b| b.old_layout), Some(vk::ImageLayout::UNDEFINED));
        let (second, state) = state.then(Use::SAMPLED, true);
        let second = second.expect("layout and visibility change");
        assert_eq!(second.src_access, Access::SHADER_STORAGE_WRITE);
        let (third, _) = state.then(Use::SAMPLED, true);
        assert!(third.is_none());
    }

    #[test]
    fn a_write_after_reads_waits_for_all_of_them() {
        let (_, state) = AccessState::NEW.then(Use::STORAGE_WRITE, false);
        let (_, state) = state.then(Use::STORAGE_READ, false);
        let (_, state) = state.then(Use::INDIRECT, false);
        let (barrier, _) = state.then(Use::COPY_TARGET, false);
        let barrier = barrier.expect("write after read");
        assert!(barrier.src_stage.contains(Stage::COMPUTE_SHADER | Stage::DRAW_INDIRECT));
    }

    #[test]
    fn a_fresh_buffer_needs_no_barrier() {
        assert!(AccessState::NEW.then(Use::STORAGE_WRITE, false).0.is_none());
        assert!(AccessState::NEW.then(Use::STORAGE_READ, false).0.is_none());
    }
}
