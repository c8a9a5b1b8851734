/* An environment on the faces of a cube: a direction, divided by its largest component, is a place
 * on a face, and the texels around it are mixed, even across edges.
 * Greene, "Environment mapping and other applications of world projections", IEEE Computer Graphics
 * and Applications 6(11), 1986; seamless: the OpenGL extension ARB_seamless_cube_map, 2009. */
#include "features/cubemap.h"

/* A place between the centres of the texels (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1), at the
 * fraction s to the right and t upwards. Indices -1 and `side` are beyond an edge. */
typedef struct quad {
    rk_cube_face face;
    int i, j;
    float s, t;
} quad;

/* Contents, in the order of the chapter. */
static rk_cube_face face_of(rk_vec3 direction);
static float to_unit(float x);
static rk_vec3 texel(const rk_cubemap *map, rk_cube_face face, int i, int j);
static int clamp_index(int i, const rk_cubemap *map);
static rk_vec3 nearest(const rk_cubemap *map, rk_vec3 direction);
static quad quad_around(const rk_cubemap *map, rk_vec3 direction);
static rk_vec3 mix_four(rk_vec3 texels[2][2], float s, float t);
static rk_vec3 bilinear(const rk_cubemap *map, const quad *q);
static bool is_beyond(const rk_cubemap *map, int i);
static rk_vec3 texel_beyond(const rk_cubemap *map, rk_cube_face face, int i, int j);
static rk_vec3 seamless(const rk_cubemap *map, const quad *q);
static bool is_within(const rk_cubemap *map, const quad *q);
static double angle_from_centre(double x, double y);

/* --- Directions ------------------------------------------------------------------------------- */

/* Ties go to x before y before z. */
static rk_cube_face face_of(rk_vec3 direction)
{
    /* solution */
    rk_vec3 size = rk_abs3(direction);
    if (size.x >= size.y && size.x >= size.z)
        return direction.x < 0 ? RK_FACE_MINUS_X : RK_FACE_X;
    if (size.y >= size.z)
        return direction.y < 0 ? RK_FACE_MINUS_Y : RK_FACE_Y;
    return direction.z < 0 ? RK_FACE_MINUS_Z : RK_FACE_Z;
    /* starter
    // First step: the axis of the largest component, and its sign.
    return RK_FACE_MINUS_Z;
    end */
}

/* Clamps; NaN becomes 1. */
static float to_unit(float x)
{
    return rk_max(0, rk_min(x, 1));
}

rk_cube_place rk_cubemap_place(rk_vec3 direction)
{
    /* solution */
    rk_cube_face face = face_of(direction);
    const rk_cube_axes *axes = &rk_cube_faces[face];
    float largest = rk_dot(direction, axes->ahead);
    float right = rk_dot(direction, axes->right) / largest;
    float up = rk_dot(direction, axes->up) / largest;
    return (rk_cube_place){face, to_unit(0.5f * right + 0.5f), to_unit(0.5f * up + 0.5f)};
    /* starter
    // First step: divide by the largest component; then [-1, 1] on the face becomes [0, 1].
    return (rk_cube_place){RK_FACE_MINUS_Z, 0.25f, 0.25f};
    end */
}

/* --- Within a face ---------------------------------------------------------------------------- */

/* Texel i from the left, j from below. */
static rk_vec3 texel(const rk_cubemap *map, rk_cube_face face, int i, int j)
{
    return *rk_cubemap_texel(map, face, (uint32_t)i, map->side - 1 - (uint32_t)j);
}

static int clamp_index(int i, const rk_cubemap *map)
{
    int last = (int)map->side - 1;
    return i < 0 ? 0 : i > last ? last : i;
}

static rk_vec3 nearest(const rk_cubemap *map, rk_vec3 direction)
{
    /* solution */
    rk_cube_place place = rk_cubemap_place(direction);
    float side = (float)map->side;
    return texel(map, place.face, clamp_index((int)(place.u * side), map),
                 clamp_index((int)(place.v * side), map));
    /* starter
    // Second step: the texel that the place is in. u = 1 still belongs to the last one.
    return rk_vec(1, 0, 1);
    end */
}

static quad quad_around(const rk_cubemap *map, rk_vec3 direction)
{
    /* solution */
    rk_cube_place place = rk_cubemap_place(direction);
    float x = place.u * (float)map->side - 0.5f, y = place.v * (float)map->side - 0.5f;
    float left = floorf(x), bottom = floorf(y);
    return (quad){place.face, (int)left, (int)bottom, x - left, y - bottom};
    /* starter
    // Third step: texel i has its centre at u = (i + .5) / side.
    return (quad){RK_FACE_MINUS_Z, 0, 0, 0, 0};
    end */
}

/* texels[j][i]: j = 0 below, 1 above; i = 0 left, 1 right. */
static rk_vec3 mix_four(rk_vec3 texels[2][2], float s, float t)
{
    return rk_mix(rk_mix(texels[0][0], texels[0][1], s), rk_mix(texels[1][0], texels[1][1], s), t);
}

/* Beyond an edge the face's last texels are repeated. */
static rk_vec3 bilinear(const rk_cubemap *map, const quad *q)
{
    /* solution */
    rk_vec3 texels[2][2];
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++)
            texels[j][i] =
                texel(map, q->face, clamp_index(q->i + i, map), clamp_index(q->j + j, map));
    return mix_four(texels, q->s, q->t);
    /* starter
    // Third step: fetch four texels, none of them beyond the face, and mix.
    return rk_vec(1, 0, 1);
    end */
}

/* --- Beyond the edges ------------------------------------------------------------------------- */

static bool is_beyond(const rk_cubemap *map, int i)
{
    return i < 0 || i >= (int)map->side;
}

/* The texel of the neighbouring face in the place of texel (i, j) beyond the edge; one of i and j
 * is -1 or `side`. In units of half a texel the face is `side` away from the cube's centre, and
 * centres of texels are whole numbers. The part of the plane beyond the edge is folded down over
 * it. */
static rk_vec3 texel_beyond(const rk_cubemap *map, rk_cube_face face, int i, int j)
{
    /* solution */
    int side = (int)map->side, right = 2 * i + 1 - side, up = 2 * j + 1 - side;
    int *beyond = is_beyond(map, i) ? &right : &up;
    *beyond = *beyond < 0 ? -side : side;
    const rk_cube_axes *axes = &rk_cube_faces[face];
    rk_vec3 ahead = rk_scale(axes->ahead, (float)(side - 1));
    return nearest(map, rk_madd(rk_madd(ahead, axes->right, (float)right), axes->up, (float)up));
    /* starter
    // Fourth step: the direction to that texel's centre, folded over the edge; then `nearest`.
    return rk_vec(1, 0, 1);
    end */
}

static rk_vec3 seamless(const rk_cubemap *map, const quad *q)
{
    /* solution */
    rk_vec3 texels[2][2], sum = {0, 0, 0};
    rk_vec3 *missing = NULL;
    for (int j = 0; j < 2; j++)
        for (int i = 0; i < 2; i++) {
            bool across = is_beyond(map, q->i + i), along = is_beyond(map, q->j + j);
            if (across && along) {
                missing = &texels[j][i];
                continue;
            }
            texels[j][i] = across || along ? texel_beyond(map, q->face, q->i + i, q->j + j)
                                           : texel(map, q->face, q->i + i, q->j + j);
            sum = rk_add(sum, texels[j][i]);
        }
    if (missing)
        *missing = rk_scale(sum, 1.0f / 3);
    return mix_four(texels, q->s, q->t);
    /* starter
    // Fourth step: as bilinear, with the neighbour's texels beyond an edge. Fifth step: at a
    // corner there are three; their mean replaces the fourth.
    return rk_vec(1, 0, 1);
    end */
}

static bool is_within(const rk_cubemap *map, const quad *q)
{
    int last = (int)map->side - 1;
    return q->i >= 0 && q->j >= 0 && q->i < last && q->j < last;
}

rk_vec3 rk_cubemap_at(const rk_cubemap *map, rk_vec3 direction, rk_cubemap_filter filter)
{
    if (filter == RK_CUBEMAP_NEAREST)
        return nearest(map, direction);
    quad q = quad_around(map, direction);
    if (filter == RK_CUBEMAP_BILINEAR || is_within(map, &q))
        return bilinear(map, &q);
    return seamless(map, &q);
}

/* --- Solid angles ----------------------------------------------------------------------------- */

/* The solid angle of the rectangle from (0, 0) to (x, y) on a plane at distance 1, with the sign of
 * x y. */
static double angle_from_centre(double x, double y)
{
    /* solution */
    return atan2(x * y, sqrt(x * x + y * y + 1));
    /* starter
    // Sixth step: the formula's atan2.
    return 0;
    end */
}

double rk_cubemap_solid_angle(uint32_t side, uint32_t column, uint32_t row)
{
    /* solution */
    double texels = side;
    double left = 2 * column / texels - 1, right = 2 * (column + 1) / texels - 1;
    double top = 2 * row / texels - 1, bottom = 2 * (row + 1) / texels - 1;
    return angle_from_centre(right, bottom) - angle_from_centre(left, bottom) -
           angle_from_centre(right, top) + angle_from_centre(left, top);
    /* starter
    // Sixth step: add and subtract the rectangles from the centre to the four corners.
    return 0;
    end */
}
