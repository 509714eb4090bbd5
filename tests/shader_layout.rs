//! Checks that the structures of `shaders/common/shared.glsl` and `src/render/shared.rs` have the same fields at the
//! same offsets. The oracle is the reflection of the compiled SPIR-V. Needs no GPU.
#![cfg(feature = "gpu")]

use std::collections::BTreeMap;
use std::mem::offset_of;

use cyclopean::render::shaders;
use cyclopean::render::shared::{
    CountersData, EmitterData, EyeUniform, FrameUniform, InstanceData, LightData, LightMapsData, MaterialData,
    ShadowMapData, TextureData, TextureSlot,
};
use spirq::ReflectConfig;
use spirq::ty::Type;
use spirq::var::Variable;

type Layout = Vec<(String, usize)>;

macro_rules! layout {
    ($name:ident { $($field:ident),* $(,)? }) => {
        (stringify!($name).to_owned(),
         vec![$((stringify!($field).to_owned(), offset_of!($name, $field))),*])
    };
}

fn host() -> BTreeMap<String, Layout> {
    BTreeMap::from([
        layout!(EyeUniform {
            clip_from_render,
            view_from_render,
            ray_first,
            ray_across,
            ray_down,
            position_near,
            stream,
        }),
        layout!(FrameUniform {
            eyes,
            size,
            seed,
            frame,
            ray_roughness_limit,
            delta_roughness,
            open_mesh_thickness,
            edge_fade,
            ray_length,
            exposure,
            light_count,
            max_steps,
            fallback,
            firefly,
            guard,
        }),
        layout!(LightData {
            position,
            kind,
            direction,
            range,
            color,
            cos_inner,
            cos_outer,
            size,
            casts_shadow,
            reserved,
        }),
        layout!(TextureSlot { row_u, row_v, texture_index, uv_set, reserved0, reserved1 }),
        layout!(MaterialData {
            base_color,
            emissive,
            metallic,
            dielectric_f0,
            roughness,
            normal_scale,
            alpha_cutoff,
            transmission,
            double_sided,
            slots,
        }),
        layout!(InstanceData { render_from_object, normal_matrix, material, first_vertex, first_index, closed }),
        layout!(TextureData { offset, width, height, flags }),
        layout!(EmitterData { triangle, cumulative }),
        layout!(ShadowMapData { right, up, forward, scale, near, far }),
        layout!(LightMapsData { first, count, dimming }),
        layout!(CountersData {
            nan,
            inf,
            clamped,
            rays,
            hits,
            sky,
            left_view,
            behind,
            back_facing,
            budget,
            below_horizon,
            steps,
            asked,
            skipped,
        }),
    ])
}

/// Adds every structure in a type to `found`, by its name, with the stride of the array in which it lies, if any.
fn collect(ty: &Type, found: &mut BTreeMap<String, Vec<(Layout, Option<usize>)>>, stride: Option<usize>) {
    match ty {
        Type::Struct(s) => {
            let fields = s.members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset.unwrap_or(usize::MAX)));
            found.entry(s.name.clone().unwrap_or_default()).or_default().push((fields.collect(), stride));
            for member in &s.members {
                collect(&member.ty, found, None);
            }
        }
        Type::Array(a) => collect(&a.element_ty, found, a.stride),
        _ => {}
    }
}

#[test]
fn host_and_shaders_agree_on_every_offset() {
    let mut found = BTreeMap::new();
    for shader in shaders::ALL {
        let words = shader.words().into_owned();
        let points = ReflectConfig::new().spv(words).ref_all_rscs(true).reflect();
        let points = points.unwrap_or_else(|e| panic!("{}: {e}", shader.name));
        for variable in points.iter().flat_map(|p| &p.vars) {
            if let Variable::Descriptor { ty, .. } = variable {
                collect(ty, &mut found, None);
            }
        }
    }
    let strides = BTreeMap::from([
        ("EyeUniform", size_of::<EyeUniform>()),
        ("LightData", size_of::<LightData>()),
        ("TextureSlot", size_of::<TextureSlot>()),
        ("MaterialData", size_of::<MaterialData>()),
        ("InstanceData", size_of::<InstanceData>()),
        ("TextureData", size_of::<TextureData>()),
        ("EmitterData", size_of::<EmitterData>()),
        ("ShadowMapData", size_of::<ShadowMapData>()),
        ("LightMapsData", size_of::<LightMapsData>()),
    ]);
    for (name, layout) in host() {
        let in_shaders =
            found.get(&name).unwrap_or_else(|| panic!("no shader uses {name}; remove it from Rust and GLSL"));
        for (fields, stride) in in_shaders {
            assert_eq!(fields, &layout, "{name}");
            if let (Some(stride), Some(size)) = (stride, strides.get(name.as_str())) {
                assert_eq!(stride, size, "array stride of {name}");
            }
        }
    }
}
