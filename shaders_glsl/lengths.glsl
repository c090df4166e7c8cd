// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Two lengths along rays, summed for each lamp: the unresolved one, and the one inside. Only their ratio matters, so
// few threads are enough: a thread notes the lengths of one lamp at most, and adds them to the buffer once, at its end.
layout(std430, binding = 3) buffer Lengths { uint lengths[]; };

const int EACH_THREADS = 64;  // one of so many threads notes a lamp, or one of as many as there are lamps

int noted_lamp;
vec2 noted;

void choose_noted_lamp(int thread)
{
    int lamps = lengths.length() / 2;
    noted_lamp = thread / lamps % max(EACH_THREADS / lamps, 1) == 0 ? thread % lamps : -1;
    noted = vec2(0.0);
}

void note_length(int lamp, int column, float amount)
{
    if (lamp == noted_lamp) {
        noted += column == 0 ? vec2(amount, 0.0) : vec2(0.0, amount);
    }
}

void add_length(int place, float amount)
{
    if (amount == 0.0) {
        return;
    }
    uint before = lengths[place];
    while (true) {
        uint found = atomicCompSwap(lengths[place], before, floatBitsToUint(uintBitsToFloat(before) + amount));
        if (found == before) {
            return;
        }
        before = found;
    }
}

void write_lengths()
{
    if (noted_lamp >= 0) {
        add_length(2 * noted_lamp, noted.x);
        add_length(2 * noted_lamp + 1, noted.y);
    }
}
