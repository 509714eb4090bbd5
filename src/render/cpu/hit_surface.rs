//! Twin of `shaders/common/hit_surface.glsl` and `material.glsl`: the surface that a ray hits, whether a cut-out material exists
//! there, and how much light a transmitting one lets through.

use glam::{Vec2, Vec3A, Vec4};

use super::super::bvh::EXCHANGED;
use super::super::shared::TriangleData;
use super::math::{Basis, MOST_HALF, normalize_or, unpack_unorm};
use super::surface::Surface;
use super::tree::Intersection;
use super::world::{Instance, Material, World};

/// The vertices of a hit triangle, by index, and their barycentric weights.
struct Corners {
    vertices: [usize; 3],
    weights: [f32; 3],
}

impl Corners {
    #[inline]
    fn blend<T: std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(&self, of: impl Fn(usize) -> T) -> T {
        let ([a, b, c], [u, v, w]) = (self.vertices, self.weights);
        of(a) * u + of(b) * v + of(c) * w
    }
}

impl World {
    #[inline]
    fn triangle(&self, triangle: u32) -> (&TriangleData, &Instance, &Material) {
        let t = &self.triangles[triangle as usize];
        let instance = &self.instances[t.instance as usize];
        (t, instance, &self.content.materials[instance.material as usize])
    }

    #[inline]
    fn corners(&self, t: &TriangleData, instance: &Instance, uv: Vec2) -> Corners {
        let uv = if t.first_index & EXCHANGED != 0 { Vec2::new(uv.y, uv.x) } else { uv };
        let first = (t.first_index & !EXCHANGED) as usize;
        let at = |k: usize| (instance.first_vertex + self.content.indices[first + k]) as usize;
        Corners { vertices: [at(0), at(1), at(2)], weights: [1.0 - uv.x - uv.y, uv.x, uv.y] }
    }

    #[inline]
    fn uv(&self, k: &Corners) -> Vec4 {
        k.blend(|i| {
            let v = &self.content.vertices[i];
            Vec4::new(v.uv0[0], v.uv0[1], v.uv1[0], v.uv1[1])
        })
    }

    #[inline]
    fn color(&self, k: &Corners) -> Vec4 {
        k.blend(|i| Vec4::from(unpack_unorm(self.content.vertices[i].color)))
    }

    /// The value of a slot's texture, if it has one.
    fn texture(&self, m: &Material, slot: usize, uv: Vec4) -> Option<Vec4> {
        let slot = m.slots[slot].as_ref()?;
        Some(self.content.decoding.sample(&self.content.scene.textures[slot.texture], slot.uv(uv)))
    }

    /// Whether a triangle of a cut-out material exists at a point.
    pub fn uncut(&self, triangle: u32, uv: Vec2) -> bool {
        let (t, instance, m) = self.triangle(triangle);
        let k = self.corners(t, instance, uv);
        let mut alpha = m.base_color.w * self.color(&k).w;
        if m.slots[0].is_some() {
            alpha *= self.texture(m, 0, self.uv(&k)).map_or(1.0, |c| c.w);
        }
        alpha >= m.alpha_cutoff
    }

    /// The share of light that a triangle lets through: the material's transmission times its base colour. Light crosses a closed
    /// mesh twice, so that each side takes the square root.
    pub fn let_through(&self, triangle: u32, uv: Vec2) -> Vec3A {
        let (t, instance, m) = self.triangle(triangle);
        let k = self.corners(t, instance, uv);
        let mut color = m.base_color * self.color(&k);
        if m.slots[0].is_some() {
            color *= self.texture(m, 0, self.uv(&k)).unwrap_or(Vec4::ONE);
        }
        let share = (Vec3A::from_vec4(color) * m.transmission).clamp(Vec3A::ZERO, Vec3A::ONE);
        if instance.closed { Vec3A::new(share.x.sqrt(), share.y.sqrt(), share.z.sqrt()) } else { share }
    }

    /// Whether a ray along `direction` meets the triangle's back.
    pub fn sees_back(&self, triangle: u32, direction: Vec3A) -> bool {
        let t = &self.triangles[triangle as usize];
        Vec3A::from(t.edge1).cross(Vec3A::from(t.edge2)).dot(direction) > 0.0
    }

    /// The surface and its emission; `v` points back along the ray.
    pub fn hit_surface(&self, hit: &Intersection, v: Vec3A) -> (Surface, Vec3A) {
        let (t, instance, m) = self.triangle(hit.triangle);
        let k = self.corners(t, instance, hit.uv);
        let is_textured = m.slots.iter().any(Option::is_some);
        let uv = if is_textured { self.uv(&k) } else { Vec4::ZERO };
        let mut base_color = self.color(&k);
        if let Some(c) = self.texture(m, 0, uv) {
            base_color *= c;
        }
        let (mut roughness, mut metallic) = (1.0, 1.0);
        if let Some(c) = self.texture(m, 1, uv) {
            (roughness, metallic) = (c.y, c.z);
        }
        let bump = self.texture(m, 2, uv).map(|c| Vec3A::from_vec4(c) * 2.0 - 1.0);
        let emissive = self.texture(m, 3, uv).map_or(Vec3A::ONE, Vec3A::from_vec4);
        let emission = (m.emissive * emissive).min(MOST_HALF);

        let vertex = |i: usize| &self.content.vertices[i];
        let face = Vec3A::from(t.edge1).cross(Vec3A::from(t.edge2));
        let face = normalize_or(face, v);
        let face = if face.dot(v) < 0.0 { -face } else { face };
        let normal = instance.normal_matrix * k.blend(|i| Vec3A::from(vertex(i).normal));
        let mut n = normalize_or(normal, face);
        if let Some(bump) = bump {
            let along = |i: usize| Vec3A::from_vec4(Vec4::from(vertex(i).tangent));
            let tangent = instance.render_from_object * k.blend(along);
            let x = normalize_or(tangent - n * n.dot(tangent), Basis::about(n).x);
            let y = n.cross(x) * vertex(k.vertices[0]).tangent[3];
            let local = x * (bump.x * m.normal_scale) + y * (bump.y * m.normal_scale) + n * bump.z;
            n = normalize_or(local, n);
        }
        // The shading normal belongs to the side that is seen.
        if n.dot(face) < 0.0 {
            n = -n;
        }
        let metallic = (m.metallic * metallic).clamp(0.0, 1.0);
        let base = Vec3A::from_vec4(m.base_color * base_color);
        let surface = Surface {
            normal: bend(n, v),
            face_normal: face,
            // Light that the surface transmits is lost to the picture, because a pixel shows only one surface.
            albedo: base * (1.0 - metallic) * (1.0 - m.transmission),
            f0: m.dielectric_f0 * (1.0 - metallic) + base * metallic,
            roughness: (m.roughness * roughness).clamp(0.0, 1.0),
        };
        (surface.through_gbuffer(), emission)
    }
}

/// Bends a normal to the viewer's side. A normal map may turn it away from the viewer, where reflection is undefined.
#[inline]
fn bend(n: Vec3A, v: Vec3A) -> Vec3A {
    const LEAST: f32 = 0.01;
    let d = n.dot(v);
    if d >= LEAST { n } else { normalize_or(n + v * (LEAST - d), v) }
}
