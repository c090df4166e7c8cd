// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Rays against triangles, curves and spheres: traverses the trees that sdf_lights/render/gpu/bvh.py builds.
//
// Before this file come `#define`s of STACK, ITEMS_IN_LEAF and TEXTURE_BITS; INSTANCES if meshes are used more than
// once; CATCHERS if there are shadow catchers; ONE_INSTANCE if rays below surfaces test only one instance; STRANDS if
// there are curves or spheres, whose code is in strands.glsl; IMAGES if textures are read faster as images; the
// workspace's Record_ray; `scene.hierarchy_root`; and maths.glsl.

// Rows of 2^TEXTURE_BITS words of four numbers. Threads read different words here, and textures are made for that. They
// may also be larger than buffers.
ivec2 texel(int place) { return ivec2(place & ((1 << TEXTURE_BITS) - 1), place >> TEXTURE_BITS); }
#ifdef IMAGES
layout(rgba32ui, binding = 0) readonly uniform uimage2D nodes;
layout(rgba32ui, binding = 1) readonly uniform uimage2D items;
uvec4 node_at(int place) { return imageLoad(nodes, texel(place)); }
uvec4 item_at(int place) { return imageLoad(items, texel(place)); }
#else
layout(binding = 0) uniform usampler2D nodes;
layout(binding = 1) uniform usampler2D items;
uvec4 node_at(int place) { return texelFetch(nodes, texel(place), 0); }
uvec4 item_at(int place) { return texelFetch(items, texel(place), 0); }
#endif
vec3 point_of(uvec4 words) { return uintBitsToFloat(words.xyz); }

const int LEAVE = -2147483647 - 1;  // an instance, or the scene

int waiting[STACK];

#ifdef CATCHERS
bool bare = false;  // rays hit only shadow catchers
#endif
#ifdef ONE_INSTANCE
int alone = -1;  // the only instance that rays hit, for any ray visibility; −1: all instances
#endif

// The data of a ray in one space: in the world, or in a mesh's local space.
struct Line {
    vec3 o;
    vec3 d;
    vec3 inverse;
};

Line line_of(vec3 o, vec3 d)
{
    // Finite everywhere: 0 × ∞ has no value.
    vec3 safe = mix(d, vec3(copy_sign(1e-20, d.x), copy_sign(1e-20, d.y), copy_sign(1e-20, d.z)),
                    lessThan(abs(d), vec3(1e-20)));
    return Line(o, d, 1.0 / safe);
}

// Where a ray enters a box; INFINITE if it misses. The far end is widened by the rounding of the products (Ize 2013,
// "Robust BVH ray traversal").
float enter_box(Line line, vec3 low, vec3 high, float t_min, float t_max)
{
    vec3 a = (low - line.o) * line.inverse;
    vec3 b = (high - line.o) * line.inverse;
    vec3 near = min(a, b);
    vec3 far = max(a, b);
    float start = max(max(near.x, near.y), max(near.z, t_min));
    float end = min(min(far.x, far.y), min(far.z, t_max)) * 1.0000004;
    return start <= end ? start : INFINITE;
}

// Distance of a triangle along a ray, −1 if it misses; (u, v) are the weights of b and c. The sides are tested with
// Plücker coordinates, as in Embree's robust mode: neighbours compute the same number for their shared side.
float hit_triangle(Line line, vec3 a, vec3 b, vec3 c, out vec2 uv)
{
    a -= line.o;
    b -= line.o;
    c -= line.o;
    vec3 ca = c - a;
    vec3 ab = a - b;
    vec3 bc = b - c;
    precise float u = dot(cross(ca, c + a), line.d);
    precise float v = dot(cross(ab, a + b), line.d);
    precise float w = dot(cross(bc, b + c), line.d);
    float sum = u + v + w;
    float rounding = 1.2e-7 * abs(sum);
    uv = vec2(u, v) / sum;
    if (!(min(min(u, v), w) >= -rounding || max(max(u, v), w) <= rounding)) {
        return -1.0;
    }
    vec3 normal = cross(ab, bc);
    float slope = dot(normal, line.d);
    return slope == 0.0 ? -1.0 : dot(a, normal) / slope;
}

// As kernels.ray_origins.number_of.
uint number_of(int instance, int primitive) { return uint(instance) * 0x9E3779B1u + uint(primitive) + 1u; }

#ifdef STRANDS
float hit_strand(Line line, uvec4 item, float t_min, float t_max, out vec2 uv);
#endif

// Nearest triangle between t_min and t_max whose instance has a bit of `mask`, in `ray`; or just any. Never the one
// whose number is the ID of the ray.
//
// Threads go down to leaves together, then test them together (Aila and Laine 2009, "Understanding the efficiency of
// ray traversal on GPUs"): waiting threads save the others the code of the other kind of step.
bool hit_scene(inout Record_ray ray, vec3 o, vec3 d, float t_min, float t_max, int mask, bool any)
{
    Line line = line_of(o, d);
    int depth = 1;
    int node = scene.hierarchy_root;
    bool found = false;
    waiting[0] = LEAVE;
    ray.t_far = t_max;
#ifdef STRANDS
    ray.origin = o;
    ray.direction = d;
#endif
#ifdef INSTANCES
    Line world = line;
    int inside = -1;  // instance whose tree the ray is in
#endif
    while (true) {
        while (node >= 0) {
            uvec4 left_low = node_at(4 * node);
            uvec4 left_high = node_at(4 * node + 1);
            float left = enter_box(line, point_of(left_low), point_of(left_high), t_min, ray.t_far);
            float right = enter_box(line, point_of(node_at(4 * node + 2)), point_of(node_at(4 * node + 3)), t_min, ray.t_far);
            bool left_first = left <= right;
            node = int(left_first ? left_low.w : left_high.w);
            if (max(left, right) < INFINITE) {
                waiting[depth] = int(left_first ? left_high.w : left_low.w);
                depth++;
            }
            if (!(min(left, right) < INFINITE)) {
                depth--;
                node = waiting[depth];
            }
        }
        if (node == LEAVE) {
#ifdef INSTANCES
            if (inside >= 0) {
                line = world;
                inside = -1;
                depth--;
                node = waiting[depth];
                continue;
            }
#endif
            return found;
        }
        int first = ~node / ITEMS_IN_LEAF;
        int last = first + ~node % ITEMS_IN_LEAF;
        depth--;
        node = waiting[depth];
        for (int item = first; item <= last; item++) {
            uvec4 first_corner = item_at(3 * item);
            uvec4 second_corner = item_at(3 * item + 1);
            uvec4 third_corner = item_at(3 * item + 2);
            vec3 a = point_of(first_corner);
            vec3 b = point_of(second_corner);
            vec3 c = point_of(third_corner);
            int instance = int(first_corner.w);
            int primitive = int(second_corner.w);
            bool seen = (int(third_corner.w) & mask) != 0;
#ifdef CATCHERS
            if (bare && int(third_corner.w) >= 0) {
                seen = false;
            }
#endif
#ifdef ONE_INSTANCE
            if (alone >= 0) {
                seen = instance == alone;
            }
#endif
#ifdef INSTANCES
            if (inside >= 0) {
                instance = inside;
                seen = true;
            }
            if (primitive == -1) {
                if (!seen) {
                    continue;
                }
                waiting[depth] = node;
                depth++;
                if (item < last) {  // the rest of the leaf waits, encoded in its reference
                    waiting[depth] = ~(ITEMS_IN_LEAF * (item + 1) + last - item - 1);
                    depth++;
                }
                waiting[depth] = LEAVE;
                depth++;
                inside = instance;
                node = int(second_corner.x);
                int place = 3 * int(second_corner.y);
                vec4 x = uintBitsToFloat(item_at(place));
                vec4 y = uintBitsToFloat(item_at(place + 1));
                vec4 z = uintBitsToFloat(item_at(place + 2));
                line = line_of(vec3(dot(x.xyz, o) + x.w, dot(y.xyz, o) + y.w, dot(z.xyz, o) + z.w),
                               vec3(dot(x.xyz, d), dot(y.xyz, d), dot(z.xyz, d)));
                break;
            }
#endif
#ifdef STRANDS
            if (primitive < -1) {
                primitive = -2 - primitive;
                uint number = number_of(instance, int(first_corner.y));
#ifdef ONE_INSTANCE
                seen = seen && alone < 0;  // light does not leave again below curves and spheres
#endif
                if (seen && number != ray.id && number != ray.flags) {
                    vec2 place;
                    float t = hit_strand(line, first_corner, t_min, ray.t_far, place);
                    if (t >= t_min && t < ray.t_far) {
                        found = true;
                        ray.t_far = t;
                        ray.u = place.x;
                        ray.v = place.y;
                        ray.primitive = uint(primitive);
                        ray.instance = uint(instance);
                        if (any) {
                            return true;
                        }
                    }
                }
                continue;
            }
#endif
            vec2 uv;
            float t = hit_triangle(line, a, b, c, uv);
            if (seen && t >= t_min && t < ray.t_far && number_of(instance, primitive) != ray.id) {
                found = true;
                ray.t_far = t;
                ray.u = uv.x;
                ray.v = uv.y;
                ray.primitive = uint(primitive);
                ray.instance = uint(instance);
                ray.normal = cross(b - a, c - a);
                if (any) {
                    return true;
                }
            }
        }
    }
}

#ifdef ONE_INSTANCE
// As hit_scene, with only one instance.
bool hit_instance(inout Record_ray ray, vec3 o, vec3 d, float t_min, float t_max, int instance)
{
    ray.id = 0u;  // it may leave through the triangle that it came in by
    alone = instance;
    bool found = hit_scene(ray, o, d, t_min, t_max, 0, false);
    alone = -1;
    return found;
}
#endif
