// Which share of a light reaches a point, looked up in depth maps from the light: the answer of shadow.glsl, quicker and
// coarser. What is compared with a texel is the depth that the point's own plane has at the texel's centre, so that a plane
// hides none of itself at any slant and under any width of the filter (receiver plane: Schüler 2006, Isidoro 2006).
// Needs `maps` (ShadowMapData[]), `light_maps` (LightMapsData[]), `shadow_map`
// (sampler2DArray) and HAS_GLASS (some material transmits) from the includer.
#ifndef SHADOW_MAP_GLSL
#define SHADOW_MAP_GLSL
#include "math.glsl"

// The point is lifted off its plane by this many texels: neighbouring facets of a hollow do not hide it.
const float LIFT = 0.5;
// The plane is followed away from the light up to this slope.
const float STEEPEST = 20.0;
// Taps that look for what hides the light, and that find its share.
const int SEARCH_TAPS = 8;
const int FILTER_TAPS = 16;
// So many of the latter may be wrong.
const float SLIPPED = 1.0;
// A filter this narrow, in texels, is the one of a hard shadow.
const float NARROW = 2.0;
// The widest, in texels: of a cascade that another one lies around, and of any map.
const float WIDE = 48.0, WIDEST = 96.0;
// Where rays meet in a light, half the width of the band about a map that neighbours draw, too, as a share of the map's
// half width. Twin: GUARD in sight.rs.
const float GUARD = 0.15;
// Within the last share of a cascade the next one takes over.
const float FADE_FROM = 0.85, FADE_TO = 0.96;

// A point in its plane as a map sees it.
struct Seen {
    uint map;
    float near;
    float far;              // 0: rays meet in the light
    float side;             // texels
    vec2 texels;            // per metre, or per metre a metre ahead; rows go down
    vec3 at;                // metres: right, up, ahead
    vec2 tangent;           // what `texels` is of
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

// How far ahead the point's plane is in a texel, metres.
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

// How far before the plane something hides it in a texel, metres; 0: nothing does.
float gap(Seen s, vec2 texel) {
    ivec2 whole = ivec2(clamp(floor(texel), vec2(0.0), vec2(s.side - 1.0)));
    float depth = texelFetch(shadow_map, ivec3(whole, s.map), 0).x;
    if (depth == 0.0) return 0.0;
    float ahead = s.far > 0.0 ? s.far - depth * (s.far - s.near) : s.near / depth;
    return max(plane_ahead(s, vec2(whole) + 0.5) - ahead, 0.0);
}

// The share of 4×4 texels that nothing hides, linear in the place.
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

// The darker half of an edge counts as dark: a wall that the light does not pass lets none of it through along its rim. A
// tenth more, because an edge runs through its texels in steps.
float hard_share(Seen s) { return clamp(2.5 * open_share(s) - 1.5, 0.0, 1.0); }

// The direction of tap k of a spiral (Vogel 1979).
vec2 around(int k, float turn) {
    float phi = float(k) * 2.39996323 + turn;
    return vec2(cos(phi), sin(phi));
}

// The widest that the shadow's edge may be where the point is, texels.
float widest_edge(Seen s, float size) {
    float texels = min(s.texels.x, -s.texels.y);
    if (s.far > 0.0) return min(size * (s.at.z - s.near) * texels, WIDEST);
    // As wide as from half-way and somewhat nearer to the light; the map's band ends there.
    return min(min(1.5 * size / max(s.at.z, 1e-12), GUARD / max(maps[s.map].scale.x, 1e-12)) * texels, WIDEST);
}

// How wide the shadow's edge is by what hides the point within some texels of it, likewise in texels; and which share of
// the taps is hidden. Of several distances the nearest to the surface weigh most.
float edge_by(Seen s, float size, float search, float turn, out float hidden) {
    vec2 center = center_texel(s);
    float inverse = 0.0;
    hidden = 0.0;
    for (int k = 0; k < SEARCH_TAPS; ++k) {
        // Densest at the point itself: what stands there must not be missed.
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

// The filter is as wide as the light's disc seen through what hides it (Fernando 2005). Looked for twice, the second time
// as near as the first answer says: along the rim of a wall that runs towards the light, what is far from the point is far
// before it, too, and does not soften the shadow at the point.
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
    // A tap that slips past the rim of a wall is no light, and one that is hidden no shadow.
    return clamp((open - SLIPPED) / (float(FILTER_TAPS) - 2.0 * SLIPPED), 0.0, 1.0);
}

// Of what stops light.
float stopped_share(Seen s, float size, float turn) { return size == 0.0 ? hard_share(s) : soft_share(s, size, turn); }

// Of what dims light. Every residue of the texels by four has one weight in all, so that the dither of an even surface
// gives one share everywhere; so it does where only every third, fifth … texel is read, for a soft edge.
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

// `dimming`: as LightMapsData has it.
float share_in(uint map, uint dimming, LightData light, vec3 position, vec3 normal, float turn) {
    Seen s = see(map, position, normal);
    if (s.far == 0.0 && s.at.z <= s.near) return 1.0;
    // A point within the light sees it as a disc half as far away as its centre.
    float size = s.far > 0.0 ? light.size : min(light.size, 0.5 * s.at.z);
    if (HAS_GLASS != 0u && dimming != 0u) {
        Seen through = s;
        through.map += dimming;
        float stopped = stopped_share(s, size, turn);
        return stopped == 0.0 ? 0.0 : stopped * dimmed_share(through, size, turn);
    }
    return stopped_share(s, size, turn);
}

// The side of a cube that a direction goes through, +x −x +y −y +z −z. Twin: `cube` in sight.rs.
uint cube_side(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= max(a.y, a.z)) return d.x >= 0.0 ? 0u : 1u;
    if (a.y >= a.z) return d.y >= 0.0 ? 2u : 3u;
    return d.z >= 0.0 ? 4u : 5u;
}

// How far from a cascade's centre, 1 at its border.
float from_center(uint map, vec3 position) {
    vec2 at = vec2(dot(maps[map].right, vec4(position, 1.0)), dot(maps[map].up, vec4(position, 1.0))) * maps[map].scale;
    return max(abs(at.x), abs(at.y));
}

// Whether the edges of shadows are too wide for a cascade's texels.
bool is_too_fine(uint map, LightData light, vec3 position) {
    float above = dot(maps[map].forward, vec4(position, 1.0)) - maps[map].near;
    return light.size * above * maps[map].scale.x * 0.5 * float(textureSize(shadow_map, 0).x) > WIDE;
}

// Of light i, a place in the maps' space. `turn`: an angle that spreads the taps.
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
