// The share of a light that reaches a point, looked up in shadow maps: a faster and coarser substitute for shadow.glsl.
// A texel is compared with the depth that the point's own plane has at the texel's centre. A plane therefore never shadows
// itself, at any slant and with any width of the filter (receiver plane: Schüler 2006, Isidoro 2006).
// Needs `maps` (ShadowMapData[]), `light_maps` (LightMapsData[]), `shadow_map` (sampler2DArray) and HAS_GLASS (some material
// transmits) from the includer.
#ifndef SHADOW_MAP_GLSL
#define SHADOW_MAP_GLSL
#include "math.glsl"

// The point is lifted off its plane by this many texels, so that the neighbouring facets of a concave surface do not hide it.
const float LIFT = 0.5;
// The largest slope at which the receiver plane is followed away from the light.
const float STEEPEST = 20.0;
// Number of taps of the blocker search, and of the filter.
const int SEARCH_TAPS = 8;
const int FILTER_TAPS = 16;
// The filter tolerates this many wrong taps.
const float SLIPPED = 1.0;
// Below this width, in texels, the shadow is filtered as a hard one.
const float NARROW = 2.0;
// The widest filter, in texels. WIDE: of a cascade with a coarser one around it; WIDEST: of any map.
const float WIDE = 48.0, WIDEST = 96.0;
// The maps of a light where rays meet overlap their neighbours by a band around each map. This is half the band's width, as a
// share of the map's half width. Twin: GUARD in map_view.rs.
const float GUARD = 0.15;
// Near a cascade's border the next cascade takes over, between these distances from the centre (1: the border).
const float FADE_FROM = 0.85, FADE_TO = 0.96;

// A point and its plane in the space of one map. A map is orthographic (directional light) or a perspective from the light,
// where all rays meet.
struct Seen {
    uint map;
    float near;
    float far;              // 0: the map is a perspective
    float side;             // width of the map, texels
    vec2 texels;            // texels per unit of `tangent`; rows go down
    vec3 at;                // the point in the map's axes, metres: right, up, ahead
    vec2 tangent;           // the point's place across the map: metres, or in a perspective metres a metre ahead
    vec3 normal;            // of the plane, in the map's axes
    float widest;           // metres a texel
};

Seen see(uint map, vec3 position, vec3 normal) {
    Seen s;
    s.map = map;
    s.near = maps[map].near;
    s.far = maps[map].far;
    s.side = float(textureSize(shadow_map, 0).x);
    s.texels = maps[map].scale * vec2(0.5, -0.5) * s.side;
    mat3 axes = transpose(mat3(maps[map].right.xyz, maps[map].up.xyz, maps[map].forward.xyz));
    s.at = axes * position + vec3(maps[map].right.w, maps[map].up.w, maps[map].forward.w);
    s.normal = axes * normal;
    s.widest = (s.far > 0.0 ? 1.0 : s.at.z) / min(s.texels.x, -s.texels.y);
    s.at += s.normal * (LIFT * s.widest);
    s.tangent = s.far > 0.0 ? s.at.xy : s.at.xy / max(s.at.z, 1e-12);
    return s;
}

vec2 center_texel(Seen s) { return s.tangent * s.texels + 0.5 * s.side; }

// How far ahead of the map the point's plane is at a texel, metres.
float plane_ahead(Seen s, vec2 texel) {
    vec2 tangent = (texel - 0.5 * s.side) / s.texels;
    float most = STEEPEST * distance(tangent, s.tangent);
    if (s.far > 0.0) {
        float rise = -dot(s.normal.xy, tangent - s.tangent) / min(s.normal.z, -1e-6);
        return s.at.z + min(rise, most);
    }
    float facing = dot(s.normal, vec3(tangent, 1.0));
    float ahead = facing < -1e-12 ? dot(s.normal, s.at) / facing : FLT_MAX;
    return min(ahead, s.at.z * (1.0 + most));
}

// The distance from the point's plane to what hides it at a texel, metres; 0: nothing hides it.
float gap(Seen s, vec2 texel) {
    ivec2 whole = ivec2(clamp(floor(texel), vec2(0.0), vec2(s.side - 1.0)));
    float depth = texelFetch(shadow_map, ivec3(whole, s.map), 0).x;
    if (depth == 0.0) return 0.0;
    float ahead = s.far > 0.0 ? s.far - depth * (s.far - s.near) : s.near / depth;
    return max(plane_ahead(s, vec2(whole) + 0.5) - ahead, 0.0);
}

// The share of 4×4 texels at which nothing hides the plane, interpolated linearly between texels.
float open_share(Seen s) {
    vec2 from = center_texel(s) - 0.5;
    vec2 f = fract(from), base = floor(from) - 0.5;
    float sum = 0.0;
    for (int y = 0; y < 4; ++y) {
        float row = y == 0 ? 1.0 - f.y : (y == 3 ? f.y : 1.0);
        for (int x = 0; x < 4; ++x) {
            float weight = row * (x == 0 ? 1.0 - f.x : (x == 3 ? f.x : 1.0));
            sum += gap(s, base + vec2(x, y)) > 0.0 ? 0.0 : weight;
        }
    }
    return sum * (1.0 / 9.0);
}

// The share of a hard shadow. The darker half of an edge counts as fully dark, so that no light leaks through along the rim of
// a wall. A further tenth counts as dark because an edge runs through the texels in steps.
float hard_share(Seen s) { return clamp(2.5 * open_share(s) - 1.5, 0.0, 1.0); }

// The direction of tap k on a Vogel spiral (Vogel 1979).
vec2 around(int k, float turn) {
    float phi = float(k) * 2.39996323 + turn;
    return vec2(cos(phi), sin(phi));
}

// The largest width that the penumbra can have at the point, texels.
float widest_edge(Seen s, float size) {
    float texels = min(s.texels.x, -s.texels.y);
    if (s.far > 0.0) return min(size * (s.at.z - s.near) * texels, WIDEST);
    // The width of a penumbra from a blocker somewhat nearer to the light than half-way, limited by the map's overlapping band.
    return min(min(1.5 * size / max(s.at.z, 1e-12), GUARD / max(maps[s.map].scale.x, 1e-12)) * texels, WIDEST);
}

// The width of the penumbra, in texels, from the blockers found within `search` texels of the point. `hidden` receives the
// share of the taps that are hidden. The blockers' distances are averaged harmonically: those near the surface weigh most.
float edge_by(Seen s, float size, float search, float turn, out float hidden) {
    vec2 center = center_texel(s);
    float inverse = 0.0;
    hidden = 0.0;
    for (int k = 0; k < SEARCH_TAPS; ++k) {
        // The taps are densest at the point itself, so that a blocker right there is not missed.
        float g = gap(s, center + (search * float(k) / float(SEARCH_TAPS - 1)) * around(k, turn));
        if (g > 0.0) {
            hidden += 1.0;
            inverse += 1.0 / g;
        }
    }
    float before = min(hidden / max(inverse, 1e-12), s.at.z);
    hidden /= float(SEARCH_TAPS);
    float width = size * before;
    if (s.far == 0.0) width /= max(s.at.z * (s.at.z - before), 1e-12);
    return min(width * min(s.texels.x, -s.texels.y), search);
}

// The filter is as wide as the light's disc projected through the blocker (Fernando 2005). Blockers are searched twice, the
// second time only within the width that the first search found. Along the rim of a wall that runs towards the light, blockers
// far from the point on the map are also far before it, and must not soften the shadow at the point.
float soft_share(Seen s, float size, float turn) {
    float width = widest_edge(s, size);
    for (int k = 0; k < 2; ++k) {
        if (width < NARROW) return hard_share(s);
        float hidden;
        float found = edge_by(s, size, width, turn, hidden);
        if (k == 0 && hidden == 0.0) return 1.0;
        if (k == 0 && hidden == 1.0) return 0.0;
        if (hidden > 0.0) width = found;
    }
    if (width < NARROW) return hard_share(s);
    vec2 center = center_texel(s);
    float open = 0.0;
    for (int k = 0; k < FILTER_TAPS; ++k) {
        open += gap(s, center + width * sqrt((float(k) + 0.5) / float(FILTER_TAPS)) * around(k, turn)) > 0.0 ? 0.0 : 1.0;
    }
    // One open tap among hidden ones, past the rim of a wall, counts as no light; one hidden tap among open ones as no shadow.
    return clamp((open - SLIPPED) / (float(FILTER_TAPS) - 2.0 * SLIPPED), 0.0, 1.0);
}

// The share that opaque matter leaves.
float stopped_share(Seen s, float size, float turn) { return size == 0.0 ? hard_share(s) : soft_share(s, size, turn); }

// The share that transmitting matter leaves. Its map is dithered in blocks of 4×4 texels. The filter gives each of the 16
// places in a block the same total weight, so that an even surface has the same share everywhere. This also holds for a soft
// edge, where only every third, fifth … texel is read.
float dimmed_share(Seen s, float size, float turn) {
    float every = 1.0, search = widest_edge(s, size);
    if (search >= NARROW) {
        float hidden;
        float width = edge_by(s, size, search, turn, hidden);
        if (hidden > 0.0) every = 2.0 * floor(0.25 * width) + 1.0;
    }
    vec2 from = (center_texel(s) - 0.5) / every + 0.5;
    vec2 f = fract(from), base = floor(from) - 2.0;
    float sum = 0.0;
    for (int y = 0; y < 5; ++y) {
        float row = y == 0 ? 1.0 - f.y : (y == 4 ? f.y : 1.0);
        for (int x = 0; x < 5; ++x) {
            float weight = row * (x == 0 ? 1.0 - f.x : (x == 4 ? f.x : 1.0));
            sum += gap(s, (base + vec2(x, y)) * every + 0.5) > 0.0 ? 0.0 : weight;
        }
    }
    return sum * (1.0 / 16.0);
}

// `dimming`: see LightMapsData.
float share_in(uint map, uint dimming, LightData light, vec3 position, vec3 normal, float turn) {
    Seen s = see(map, position, normal);
    if (s.far == 0.0 && s.at.z <= s.near) return 1.0;
    // The disc is never wider than its distance from the point, not even for a point inside the light.
    float size = s.far > 0.0 ? light.size : min(light.size, 0.5 * s.at.z);
    if (HAS_GLASS != 0u && dimming != 0u) {
        Seen through = s;
        through.map += dimming;
        float stopped = stopped_share(s, size, turn);
        return stopped == 0.0 ? 0.0 : stopped * dimmed_share(through, size, turn);
    }
    return stopped_share(s, size, turn);
}

// The side of a cube through which a direction leaves, in the order +x −x +y −y +z −z. Twin: `cube` in map_view.rs.
uint cube_side(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= max(a.y, a.z)) return d.x >= 0.0 ? 0u : 1u;
    if (a.y >= a.z) return d.y >= 0.0 ? 2u : 3u;
    return d.z >= 0.0 ? 4u : 5u;
}

// The distance from a cascade's centre; 1 at its border.
float from_center(uint map, vec3 position) {
    vec2 at = vec2(dot(maps[map].right, vec4(position, 1.0)), dot(maps[map].up, vec4(position, 1.0))) * maps[map].scale;
    return max(abs(at.x), abs(at.y));
}

// Whether penumbrae at the point may be wider than the filter of this cascade.
bool is_too_fine(uint map, LightData light, vec3 position) {
    float above = dot(maps[map].forward, vec4(position, 1.0)) - maps[map].near;
    return light.size * above * maps[map].scale.x * 0.5 * float(textureSize(shadow_map, 0).x) > WIDE;
}

// The share of light i at a position in the maps' space. `turn`: rotation of the taps, radians.
float mapped_share(uint i, LightData light, vec3 position, vec3 normal, float turn) {
    uint first = light_maps[i].first, count = light_maps[i].count, dimming = light_maps[i].dimming;
    if (count == 0u) return 1.0;
    if (light.kind != 0u) {
        uint side = count == 1u ? 0u : cube_side(position - light.position);
        return share_in(first + side, dimming, light, position, normal, turn);
    }
    uint last = first + count - 1u;
    uint map = first;
    while (map < last && (from_center(map, position) > FADE_TO || is_too_fine(map, light, position))) ++map;
    float share = share_in(map, dimming, light, position, normal, turn);
    if (map < last) {
        float next = smoothstep(FADE_FROM, FADE_TO, from_center(map, position));
        if (next > 0.0) share = mix(share, share_in(map + 1u, dimming, light, position, normal, turn), next);
    }
    return share;
}

#endif
