// Every structure that host and shaders share. src/render/shared.rs is its twin, and a test compares the offsets.
#ifndef SHARED_GLSL
#define SHARED_GLSL

struct EyeUniform {
    mat4 clip_from_render;  // reverse-Z, infinite far plane; y up
    mat4 view_from_render;
    vec4 ray_first;         // direction through the image's top-left corner, scaled to distance 1 along the view
    vec4 ray_across;        // added for each pixel to the right
    vec4 ray_down;          // added for each pixel down
    vec4 position_near;     // xyz: the eye in render space, metres; w: near plane, metres
    uvec4 stream;           // x: token of the eye's random stream
};

struct FrameUniform {
    EyeUniform eyes[2];
    uvec2 size;             // pixels of one eye
    uint seed;
    uint frame;
    float ray_roughness_limit; // above it no ray is traced
    float delta_roughness;     // below it a surface is a mirror
    float open_mesh_thickness; // metres behind the surface of an open mesh that count as matter
    float edge_fade;           // width of the fade at a view's border, as a fraction of its size
    float ray_length;          // metres; nothing of the scene is farther away
    float exposure;
    uint light_count;
    uint max_steps;            // of a march
    uint fallback;             // 0 black, 1 map
    uint firefly;              // the resolve's measure against fireflies: 0 none, 1 tone-mapped weights, 2 bounded shares
    uvec2 guard;               // pixels at each side that are drawn and never shown
};

struct LightData {
    vec3 position;          // render space, metres
    uint kind;              // 0 directional, 1 point, 2 spot
    vec3 direction;         // the light travels along it, unit length
    float range;            // metres
    vec3 color;             // irradiance (directional) or radiant intensity
    float cos_inner;
    float cos_outer;
    float size;             // radius, metres; for a directional light the tangent of half its angular diameter
    uint casts_shadow;
    uint reserved;
};

struct TextureSlot {
    vec4 row_u;             // u' = dot(row_u.xyz, (u, v, 1))
    vec4 row_v;
    int texture_index;      // −1: none
    uint uv_set;
    uint reserved0;
    uint reserved1;
};

struct MaterialData {
    vec4 base_color;        // linear, straight alpha
    vec3 emissive;
    float metallic;
    vec3 dielectric_f0;
    float roughness;        // perceptual
    float normal_scale;
    float alpha_cutoff;     // negative: opaque
    float transmission;
    uint double_sided;
    TextureSlot slots[4];   // base colour, metallic-roughness, normal, emissive
};

struct InstanceData {
    vec4 render_from_object[3];  // rows
    vec4 normal_matrix[3];       // rows of the inverse transpose
    uint material;
    uint first_vertex;
    uint first_index;
    uint closed;
};

struct TextureData {
    uint offset;            // first texel, in words
    uint width;
    uint height;
    uint flags;             // bits 0–1 wrap u, 2–3 wrap v (0 repeat, 1 mirror, 2 clamp), 4 sRGB, 5 nearest
};

// An emissive triangle, and the share of all emitted light that comes from it and the emitters before it.
struct EmitterData {
    uint triangle;
    float cumulative;
};

// The view of a shadow map, in the maps' space.
struct ShadowMapData {
    vec4 right;             // xyz: unit axis; w: minus the dot product of the axis and the place that the map looks from
    vec4 up;
    vec4 forward;
    vec2 scale;             // takes metres (in a perspective: metres a metre ahead) to ±1 at the map's border
    float near;             // metres ahead
    float far;              // metres ahead; 0: the map is a perspective from the light, without an end
};

// The layers of one light: none, one (a narrow spot), six (a cube), or cascades in order from the finest. Where there is
// transmitting matter, as many layers of transmitting matter follow after those of opaque matter.
struct LightMapsData {
    uint first;
    uint count;             // layers of opaque matter
    uint dimming;           // added to the index of a layer of opaque matter to find the one of transmitting matter; 0: none
};

// Fifteen words: position, normal, tangent, uv0, uv1, colour (unorm 4×8).
const uint VERTEX_WORDS = 15u;

// BVH nodes and triangles lie in textures, sixteen bytes a texel; see NodeData and TriangleData in shared.rs.
const uint LEAF = 0x80000000u;
const uint COUNT_SHIFT = 28u;   // up to eight triangles a leaf, 2²⁸ triangles
const uint DOUBLE_SIDED = 1u;
const uint MASKED = 2u;
const uint TRANSMITS = 4u;

// Every device can dispatch 65,535 groups in each dimension. Groups of longer lists of rays go on in the next row.
const uint ROW_OF_GROUPS = 32768u;

// What a frame counts, each in one word.
struct CountersData {
    uint nan;
    uint inf;
    uint clamped;           // radiance beyond fp16
    uint rays;
    uint hits;
    uint sky;
    uint left_view;
    uint behind;
    uint back_facing;
    uint budget;            // marches that ran out of steps
    uint below_horizon;
    uint steps;
    uint asked;             // lost rays that asked the geometry
    uint skipped;           // lost rays that did not ask
};

#endif
