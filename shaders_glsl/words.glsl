// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// 64-bit words as (low half, high half), and the functions of sdf_lights/bits.py.

uvec2 word_64(uint a) { return uvec2(a, 0u); }
uvec2 word_64(int a) { return uvec2(uint(a), uint(a >> 31)); }
uvec2 word_64(bool a) { return uvec2(uint(a), 0u); }
uvec2 word_64(float a) { return uvec2(uint(mod(a, 4294967296.0)), uint(floor(a / 4294967296.0))); }
float float_of_64(uvec2 a) { return float(a.x) + 4294967296.0 * float(a.y); }
bool bool_of_64(uvec2 a) { return a != uvec2(0u); }

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

// GLSL has no shifts by 32 bits or more.
uvec2 shift_right_64(uvec2 a, int bits)
{
    if (bits >= 32) {
        return uvec2(a.y >> (bits - 32), 0u);
    }
    return bits == 0 ? a : uvec2((a.x >> bits) | (a.y << (32 - bits)), a.y >> bits);
}

uvec2 shift_left_64(uvec2 a, int bits)
{
    if (bits >= 32) {
        return uvec2(0u, a.x << (bits - 32));
    }
    return bits == 0 ? a : uvec2(a.x << bits, (a.y << bits) | (a.x >> (32 - bits)));
}

uvec2 reverse_64(uvec2 a) { return bitfieldReverse(a.yx); }

// Below 1 for any digits: the last eight are cut off.
float unit_float(uint digits) { return float(digits >> 8) * 5.9604644775390625e-8; }
