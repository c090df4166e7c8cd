// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Mathematics that Python has and GLSL lacks, and the tables of the scene.

#define INFINITE uintBitsToFloat(0x7F800000u)
#define NOT_A_NUMBER uintBitsToFloat(0x7FC00000u)

layout(std430, binding = 0) readonly buffer Words { uint words[]; };

float float_at(int place) { return uintBitsToFloat(words[place]); }
int int_at(int place) { return int(words[place]); }
uint uint_at(int place) { return words[place]; }
vec3 vector_at(int place) { return uintBitsToFloat(uvec3(words[place], words[place + 1], words[place + 2])); }

float square(float a) { return a * a; }
float cube(float a) { return a * a * a; }

float copy_sign(float size, float sign_of)
{
    return uintBitsToFloat((floatBitsToUint(size) & 0x7FFFFFFFu) | (floatBitsToUint(sign_of) & 0x80000000u));
}

bool is_finite(float a) { return abs(a) < INFINITE; }

// a modulo b as in Python: with the sign of b. For negative numbers, the result of % depends on the driver.
int modulo(int a, int b)
{
    int size = abs(b), whole = b < 0 ? -a : a;
    int rest = whole >= 0 ? whole % size : size - 1 - (-1 - whole) % size;
    return b < 0 ? -rest : rest;
}
