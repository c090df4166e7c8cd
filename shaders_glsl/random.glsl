// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// The sampling pattern of sdf_lights/render/kernels/sampler.py, bit for bit but for the rounding to float: see there.
//
// Before this file come the words of the scene, `scene.sobol_start` (of the tables of the third and fourth dimension) and
// `scene.sobol_rows`.

// 64-bit words are (low half, high half).
const uvec2 GOLDEN_64 = uvec2(0x7F4A7C15u, 0x9E3779B9u);

uvec2 multiply_64(uvec2 a, uvec2 b)
{
    uint high, low;
    umulExtended(a.x, b.x, high, low);
    return uvec2(low, high + a.x * b.y + a.y * b.x);
}

uvec2 add_64(uvec2 a, uvec2 b)
{
    uint carry;
    uint low = uaddCarry(a.x, b.x, carry);
    return uvec2(low, a.y + b.y + carry);
}

uvec2 shift_right_64(uvec2 a, int bits) { return uvec2((a.x >> bits) | (a.y << (32 - bits)), a.y >> bits); }

// Finalizer of SplitMix64 (Steele, Lea and Flood 2014), variant 13 of Stafford.
uvec2 mix_64(uvec2 z)
{
    z = multiply_64(z ^ shift_right_64(z, 30), uvec2(0x1CE4E5B9u, 0xBF58476Du));
    z = multiply_64(z ^ shift_right_64(z, 27), uvec2(0x133111EBu, 0x94D049BBu));
    return z ^ shift_right_64(z, 31);
}

uint scramble(uint x, uint seed)
{
    x ^= x * 0x3D20ADEAu;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526C56u;
    return x ^ (x * 0x53A22864u);
}

uint shuffle(uint index, uint word) { return bitfieldReverse(scramble(bitfieldReverse(index), word)); }

uint second_dimension(uint index)
{
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0F0F0F0Fu;
    index ^= (index >> 8) & 0x00FF00FFu;
    return index ^ (index >> 16);
}

uint later_dimension(int table, uint index)
{
    int start = scene.sobol_start + 1024 * table;
    return uint_at(start + int(index & 255u)) ^ uint_at(start + 256 + int((index >> 8) & 255u))
        ^ uint_at(start + 512 + int((index >> 16) & 255u)) ^ uint_at(start + 768 + int(index >> 24));
}

// Below 1, whatever the digits: the last eight are cut off.
float unit(uint digits, uint seed) { return float(bitfieldReverse(scramble(digits, seed)) >> 8) * 5.9604644775390625e-8; }

uvec2 set_word(uint seed, int dimension)
{
    return mix_64(uvec2(0u, seed) ^ multiply_64(uvec2(uint(dimension + 1), 0u), GOLDEN_64));
}

uint pixel_seed(int x, int y, int seed)
{
    uvec2 word = mix_64(uvec2(uint(x), uint(y)));
    return mix_64(add_64(word, multiply_64(uvec2(uint(seed), 0u), GOLDEN_64))).y;
}

float draw1(int index, uint seed, int dimension)
{
    uvec2 word = set_word(seed, dimension);
    return unit(shuffle(uint(index), word.x), word.y);
}

vec4 draw4(int index, uint seed, int dimension)
{
    uvec2 word = set_word(seed, dimension);
    uvec2 more = mix_64(add_64(word, GOLDEN_64));
    uvec2 last = mix_64(add_64(more, GOLDEN_64));
    uint point = shuffle(uint(index), word.x);
    return vec4(unit(point, word.y), unit(second_dimension(point), more.x), unit(later_dimension(0, point), more.y),
                unit(later_dimension(1, point), last.x));
}

vec3 draw3(int index, uint seed, int dimension)
{
    uvec2 word = set_word(seed, dimension);
    uvec2 more = mix_64(add_64(word, GOLDEN_64));
    uint point = shuffle(uint(index), word.x);
    return vec3(unit(point, word.y), unit(second_dimension(point), more.x), unit(later_dimension(0, point), more.y));
}

vec2 draw2(int index, uint seed, int dimension)
{
    uvec2 word = set_word(seed, dimension);
    uvec2 more = mix_64(add_64(word, GOLDEN_64));
    uint point = shuffle(uint(index), word.x);
    return vec2(unit(point, word.y), unit(second_dimension(point), more.x));
}

// Numbers from a counter, for draws that the pattern does not cover: states are 32 bits wide here, and the generator is
// PCG's output function (Jarzynski and Olano 2020, "Hash functions for GPU rendering", JCGT 9(3)).
uint counted_bits(uint state)
{
    state = state * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

uint counted_seeded(float u1, float u2, float u3)
{
    return counted_bits(floatBitsToUint(u1) + counted_bits(floatBitsToUint(u2) + counted_bits(floatBitsToUint(u3))));
}

uint counted_following(uint state) { return state + 0x9E3779B9u; }

float counted_uniform(uint state) { return float(counted_bits(state) >> 8) * 5.9604644775390625e-8; }

vec3 counted_point(uint state)
{
    uint a = counted_bits(state);
    uint b = counted_bits(a);
    return vec3(uvec3(a, b, counted_bits(b)) >> 8) * 5.9604644775390625e-8;
}
