// `intersect` and `transmittance` of rays.glsl by VK_KHR_ray_query. Needs `ray_structure` (accelerationStructureEXT) from the
// includer, and what rays.glsl declares. Double-sided triangles lie in instances without face culling. Cut-out triangles are
// not opaque, so that their texture is tested as in the BVH's leaves.
#ifndef RAY_QUERY_GLSL
#define RAY_QUERY_GLSL

// Twin: STEP in ray_structure.rs.
const uint INSTANCE_STEP = 16u;

Intersection intersect(vec3 origin, vec3 direction) {
#ifdef TWO_SIDED
    uint flags = 0u;
#else
    uint flags = gl_RayFlagsCullBackFacingTrianglesEXT;
#endif
    if (HAS_MASK == 0u) flags |= gl_RayFlagsOpaqueEXT;
    rayQueryEXT query;
    rayQueryInitializeEXT(query, ray_structure, flags, 0xffu, origin, 0.0, direction, FLT_MAX);
    while (rayQueryProceedEXT(query)) {
        if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT) continue;
        uint triangle = INSTANCE_STEP * uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false))
                      + uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        if (uncut(triangle, rayQueryGetIntersectionBarycentricsEXT(query, false))) rayQueryConfirmIntersectionEXT(query);
    }
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) {
        return Intersection(FLT_MAX, vec2(0.0), NO_TRIANGLE);
    }
    return Intersection(rayQueryGetIntersectionTEXT(query, true), rayQueryGetIntersectionBarycentricsEXT(query, true),
                        INSTANCE_STEP * uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true))
                            + uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)));
}

vec3 transmittance(vec3 origin, vec3 direction, float t_max) {
    uint flags = gl_RayFlagsTerminateOnFirstHitEXT;
    // For `intersect`, transmitting triangles are opaque. Here no triangle may be opaque, so that each one is tested.
    if (HAS_GLASS != 0u) flags |= gl_RayFlagsNoOpaqueEXT;
    else if (HAS_MASK == 0u) flags |= gl_RayFlagsOpaqueEXT;
    vec3 share = vec3(1.0);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, ray_structure, flags, 0xffu, origin, 0.0, direction, t_max);
    while (rayQueryProceedEXT(query)) {
        if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT) continue;
        uint triangle = INSTANCE_STEP * uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false))
                      + uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
        vec2 uv = rayQueryGetIntersectionBarycentricsEXT(query, false);
        uint kind = floatBitsToUint(row(triangle_rows, 3u * triangle + 2u).w);
        if ((kind & MASKED) != 0u && !uncut(triangle, uv)) continue;
        if ((kind & TRANSMITS) == 0u) {
            rayQueryConfirmIntersectionEXT(query);
        } else {
            share *= let_through(triangle, uv);
        }
    }
    bool stopped = rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
    return stopped ? vec3(0.0) : share;
}

#endif
