// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Two lengths along rays, summed for each lamp: the unresolved one, and the one inside. Only their ratio matters, so
// one thread in 64 is enough.
layout(std430, binding = 3) buffer Lengths { uint lengths[]; };

void note_length(int lamp, int column, float amount)
{
    if (gl_LocalInvocationID.x != 0u || amount == 0.0) {
        return;
    }
    int place = 2 * lamp + column;
    uint before = lengths[place];
    while (true) {
        uint found = atomicCompSwap(lengths[place], before, floatBitsToUint(uintBitsToFloat(before) + amount));
        if (found == before) {
            return;
        }
        before = found;
    }
}
