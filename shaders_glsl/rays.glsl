// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Rays against triangles: the trees that sdf_lights/render/gpu/bvh.py builds.
//
// Before this file come `#define`s of STACK, ITEMS_IN_LEAF, TEXTURE_BITS, INSTANCE_SIZE and INSTANCE_INVERSE, the workspace's
// Record_ray, `scene.hierarchy_root` and `scene.instances_start`, and maths.glsl.

// Rows of 2^TEXTURE_BITS words of four numbers: what threads read here is nowhere the same for all of them, and textures
// are made for that. They may also be larger than buffers.
uniform usampler2D nodes;
uniform usampler2D items;

ivec2 texel(int place) { return ivec2(place & ((1 << TEXTURE_BITS) - 1), place >> TEXTURE_BITS); }
uvec4 node_at(int place) { return texelFetch(nodes, texel(place), 0); }
uvec4 item_at(int place) { return texelFetch(items, texel(place), 0); }
vec3 point_of(uvec4 words) { return uintBitsToFloat(words.xyz); }

const int LEAVE_INSTANCE = -2147483647 - 1;

int waiting[STACK];

// What a ray goes by in one space: in the world, or in a mesh's own.
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

// Distance of a triangle along a ray, −1 if it is missed; (u, v) are the weights of b and c. The sides are tested by Plücker
// coordinates, as Embree does in its robust mode: neighbours compute the same number for the side they share.
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

// Nearest triangle between t_min and t_max whose instance has a bit of `mask`, in `ray`; or just any.
bool hit_scene(inout Record_ray ray, vec3 o, vec3 d, float t_min, float t_max, int mask, bool any)
{
    Line world = line_of(o, d);
    Line line = world;
    int depth = 0;
    int node = scene.hierarchy_root;
    int inside = -1;  // instance whose tree the ray is in
    bool found = false;
    ray.t_far = t_max;
    while (true) {
        if (node >= 0) {
            uvec4 left_low = node_at(4 * node);
            uvec4 left_high = node_at(4 * node + 1);
            float left = enter_box(line, point_of(left_low), point_of(left_high), t_min, ray.t_far);
            float right = enter_box(line, point_of(node_at(4 * node + 2)), point_of(node_at(4 * node + 3)), t_min, ray.t_far);
            int near = int(left <= right ? left_low.w : left_high.w);
            if (left < INFINITE && right < INFINITE) {
                waiting[depth] = int(left <= right ? left_high.w : left_low.w);
                depth++;
            }
            if (left < INFINITE || right < INFINITE) {
                node = near;
                continue;
            }
        }
        else if (node == LEAVE_INSTANCE) {
            line = world;
            inside = -1;
        }
        else {
            int first = ~node / ITEMS_IN_LEAF;
            int last = first + ~node % ITEMS_IN_LEAF;
            for (int item = first; item <= last; item++) {
                uvec4 first_corner = item_at(3 * item);
                uvec4 second_corner = item_at(3 * item + 1);
                uvec4 third_corner = item_at(3 * item + 2);
                int primitive = int(second_corner.w);
                if (inside < 0 && (int(third_corner.w) & mask) == 0) {
                    continue;
                }
                if (primitive < 0) {
                    // The rest of the leaf waits, which its reference can say.
                    if (item < last) {
                        waiting[depth] = ~(ITEMS_IN_LEAF * (item + 1) + last - item - 1);
                        depth++;
                    }
                    waiting[depth] = LEAVE_INSTANCE;
                    waiting[depth + 1] = int(second_corner.x);
                    depth += 2;
                    inside = int(first_corner.w);
                    int at = scene.instances_start + inside * INSTANCE_SIZE + INSTANCE_INVERSE;
                    vec3 x = vector_at(at);
                    vec3 y = vector_at(at + 4);
                    vec3 z = vector_at(at + 8);
                    line = line_of(
                        vec3(dot(x, o) + float_at(at + 3), dot(y, o) + float_at(at + 7), dot(z, o) + float_at(at + 11)),
                        vec3(dot(x, d), dot(y, d), dot(z, d)));
                    break;
                }
                vec3 a = point_of(first_corner);
                vec3 b = point_of(second_corner);
                vec3 c = point_of(third_corner);
                vec2 uv;
                float t = hit_triangle(line, a, b, c, uv);
                if (t > t_min && t < ray.t_far) {
                    found = true;
                    ray.t_far = t;
                    ray.u = uv.x;
                    ray.v = uv.y;
                    ray.primitive = uint(primitive);
                    ray.instance = inside >= 0 ? uint(inside) : first_corner.w;
                    ray.normal = cross(b - a, c - a);
                    if (any) {
                        return true;
                    }
                }
            }
        }
        if (depth == 0) {
            return found;
        }
        depth--;
        node = waiting[depth];
    }
}
