/* The Cornell box: with a mirror, 16 quadrilaterals as 32 triangles; with two blocks of glass; and
 * with a parallelogram light in place of the lamp. Source: "Cornell Box Data", Cornell University
 * Program of Computer Graphics, 1998: lengths in millimetres, x to the left of the picture, y up, z
 * away from the viewer. The lamp hangs .02 mm below the ceiling, so that a ray hits the two at
 * different distances and no shadow of the lamp shows beside it. Declared in scenes/makers.h. */
#include "scenes/makers.h"

enum { white, left_wall, right_wall, lamp, tall, low, material_count };

typedef struct face {
    float corners[4][3];
    int material;
} face;

static const face room[] = {
    {{{552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f}}, white},
    {{{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {0, 548.8f, 0}}, white},
    {{{549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f}}, white},
    {{{552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0}}, left_wall},
    {{{0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f}}, right_wall},
    {{{343, 548.78f, 227}, {343, 548.78f, 332}, {213, 548.78f, 332}, {213, 548.78f, 227}}, lamp},
};

/* A block stands on the floor: the (x, z) of its corners, clockwise as seen from above. */
typedef struct block {
    float footprint[4][2];
    float height;
} block;

static const block low_block = {{{130, 65}, {82, 225}, {240, 272}, {290, 114}}, 165};
static const block tall_block = {{{423, 247}, {265, 296}, {314, 456}, {472, 406}}, 330};

enum { room_faces = sizeof room / sizeof room[0] };

/* The box's centre goes to 0, and its half diagonal, 480.3 mm, to just below 1. */
static const double centre[3] = {278, 274.4, 279.6};
static const double millimetres = 1.0 / 481;

static rk_vec3 place(float x, float y, float z)
{
    return rk_vec((float)(((double)x - centre[0]) * millimetres),
                  (float)(((double)y - centre[1]) * millimetres),
                  (float)(((double)z - centre[2]) * millimetres));
}

/* Appends a face, as two triangles. */
static void put_face(rk_mesh *mesh, const face *f)
{
    uint32_t first = mesh->vertex_count, row = mesh->triangle_count;
    for (uint32_t k = 0; k < 4; k++)
        mesh->positions[first + k] = place(f->corners[k][0], f->corners[k][1], f->corners[k][2]);
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t *corner = mesh->triangles[row + half];
        corner[0] = first, corner[1] = first + 1 + half, corner[2] = first + 2 + half;
        mesh->triangle_materials[row + half] = (uint16_t)f->material;
    }
    mesh->vertex_count += 4;
    mesh->triangle_count += 2;
}

static void put_corner(face *f, int i, const float *foot, float y)
{
    f->corners[i][0] = foot[0], f->corners[i][1] = y, f->corners[i][2] = foot[1];
}

/* Top, four sides, and for a block of glass, which has to be closed, a bottom. It then ends 1 mm
 * above the floor, so that a ray hits the two at different distances. */
static void put_block(rk_mesh *mesh, const block *b, int material, bool closed)
{
    const float bottom = closed ? 1 : 0;
    face f = {.material = material};
    for (int i = 0; i < 4; i++)
        put_corner(&f, i, b->footprint[i], b->height);
    put_face(mesh, &f);
    for (int k = 0; k < 4; k++) {
        const float *left = b->footprint[k], *right = b->footprint[(k + 1) % 4];
        put_corner(&f, 0, right, bottom);
        put_corner(&f, 1, right, b->height);
        put_corner(&f, 2, left, b->height);
        put_corner(&f, 3, left, bottom);
        put_face(mesh, &f);
    }
    for (int i = 0; i < 4; i++)
        put_corner(&f, i, b->footprint[3 - i], bottom);
    if (closed)
        put_face(mesh, &f);
}

/* The contents of the room. */
typedef struct furniture {
    bool has_lamp;
    bool of_glass; /* the blocks, both */
    int low, tall; /* their materials */
} furniture;

static bool make_box(rk_mesh *mesh, furniture has, rk_error *error)
{
    const uint32_t faces_max = room_faces + 2 * 6;
    if (!rk_mesh_init(mesh, 4 * faces_max, 2 * faces_max, material_count, 0, error))
        return false;
    mesh->vertex_count = mesh->triangle_count = 0;
    for (int i = 0; i < room_faces; i++)
        if (room[i].material != lamp || has.has_lamp)
            put_face(mesh, &room[i]);
    put_block(mesh, &low_block, has.low, has.of_glass);
    put_block(mesh, &tall_block, has.tall, has.of_glass);
    mesh->materials[white].kd = rk_vec(0.73f, 0.73f, 0.73f);
    mesh->materials[left_wall].kd = rk_vec(0.65f, 0.06f, 0.05f);
    mesh->materials[right_wall].kd = rk_vec(0.12f, 0.45f, 0.15f);
    mesh->materials[lamp].kd = rk_vec(1, 1, 1);
    return true;
}

bool rk_builtin_make_cornell(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!make_box(mesh, (furniture){.has_lamp = true, .low = white, .tall = tall}, error))
        return false;
    mesh->materials[tall] = (rk_material){.kd = rk_vec(0.01f, 0.01f, 0.01f),
                                          .ks = rk_vec(0.95f, 0.95f, 0.95f),
                                          .shininess = 1000,
                                          .alpha = 1};
    return true;
}

bool rk_builtin_make_cornell_glass(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    const furniture glass = {.has_lamp = true, .of_glass = true, .low = low, .tall = tall};
    if (!make_box(mesh, glass, error))
        return false;
    /* The blocks are about 165 mm thick; this thickness filters white light to their colour. */
    const float thickness = (float)(165 * millimetres);
    mesh->materials[low] = rk_builtin_glass(rk_vec(0.9f, 0.6f, 0.2f), 0.3f, thickness);
    mesh->materials[tall] = rk_builtin_glass(rk_vec(0.3f, 0.55f, 0.9f), 0.3f, thickness);
    return true;
}

bool rk_builtin_make_cornell_light(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    return make_box(mesh, (furniture){.low = white, .tall = white}, error);
}

/* The published camera: at (278, 273, -800), looking along z, with a 25 mm film behind a 35 mm
 * lens. */
void rk_builtin_arrange_cornell(rk_scene *scene)
{
    scene->camera = (rk_camera){
        .look_at = place(278, 273, 279.6f),
        .distance = (float)((800 + centre[2]) * millimetres),
        .fov = 39.3076f, /* 2 atan(12.5 / 35) */
    };
    scene->lights[0] = rk_light_point(place(278, 540, 279.5f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}

/* The light replaces the lamp, at the same size. */
void rk_builtin_arrange_cornell_light(rk_scene *scene)
{
    rk_builtin_arrange_cornell(scene);
    const rk_vec3 corner = place(213, 548, 227), white_light = {1, 1, 1};
    scene->lights[0] = (rk_light){
        .kind = RK_LIGHT_PARALLELOGRAM,
        .position = corner,
        .edge01 = rk_sub(place(343, 548, 227), corner),
        .edge02 = rk_sub(place(213, 548, 332), corner),
        .colours = {white_light, white_light, white_light, white_light},
    };
}
