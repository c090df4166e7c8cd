// SPDX-FileCopyrightText: 2026 SDF Lights authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Lamps whose field is a formula: the formula, its numbers, and all intervals of a ray inside.
//
// Before this file come `float field_number(int slot)` over `lamp_numbers`; the generated functions field_0, field_1, …
// with `float lamp_field_of(int formula, vec3 p)`, which selects one of them; `int first_term(int row)` of the record
// of a lamp; and offsets of the record FIELD of sdf_lights/render/gpu/lamp_kernels.py.

int lamp_formula;
vec3 lamp_center;

// Make `field` that of the lamp whose record in `lamps` begins at `row`. Returns the index of its FIELD.
int choose_field(int row)
{
    int at = scene.lamp_fields_start + first_term(row) * FIELD_SIZE;
    lamp_formula = int_at(at + FIELD_FORMULA);
    lamp_numbers = scene.lamp_parameters_start + int_at(at + FIELD_PARAMETERS);
    lamp_center = vector_at(at + FIELD_CENTER);
    return at;
}

float field(vec3 p) { return lamp_field_of(lamp_formula, p + lamp_center); }

float field_value(int row, vec3 p)
{
    choose_field(row);
    return field(p);
}
