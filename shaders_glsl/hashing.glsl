// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Numbers from a counter, for draws outside the sampler; replaces sdf_lights/emitter/hashing.py. States are 32 bits
// wide here, and the generator is PCG's output function (Jarzynski and Olano 2020, "Hash functions for GPU rendering",
// JCGT 9(3)).
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
