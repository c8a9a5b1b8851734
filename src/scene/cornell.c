/* The Cornell box with a mirror: 16 four-cornered faces, cut into 32 triangles.
 * Source: "Cornell Box Data", Cornell University Program of Computer Graphics, 1998: lengths in
 * millimetres, x to the left of the picture, y up, z away from the viewer. The tall block is a
 * mirror here; the lamp hangs .8 mm below the ceiling, so that a ray meets one of them first. */
#include "scene/builtin.h"

enum { white, red, green, lamp, mirror, material_count };

typedef struct face {
    float corners[4][3];
    int material;
} face;

static const face room[] = {
    {{{552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f}}, white},
    {{{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {0, 548.8f, 0}}, white},
    {{{549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f}}, white},
    {{{552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0}}, red},
    {{{0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f}}, green},
    {{{343, 548, 227}, {343, 548, 332}, {213, 548, 332}, {213, 548, 227}}, lamp},
};

/* A block stands on the floor: the (x, z) of its corners, clockwise as seen from above. */
typedef struct block {
    float footprint[4][2];
    float height;
    int material;
} block;

static const block blocks[] = {
    {{{130, 65}, {82, 225}, {240, 272}, {290, 114}}, 165, white},
    {{{423, 247}, {265, 296}, {314, 456}, {472, 406}}, 330, mirror},
};

enum {
    room_faces = sizeof room / sizeof room[0],
    block_count = sizeof blocks / sizeof blocks[0],
    face_count = room_faces + 5 * block_count /* no bottom */
};

/* The box's centre goes to 0 and its half diagonal, 480.3 mm, to just below 1. */
static const double centre[3] = {278, 274.4, 279.6};
static const double millimetres = 1.0 / 481;

static rk_vec3 place(float x, float y, float z)
{
    return rk_vec((float)(((double)x - centre[0]) * millimetres),
                  (float)(((double)y - centre[1]) * millimetres),
                  (float)(((double)z - centre[2]) * millimetres));
}

static void put_face(rk_mesh *mesh, uint32_t index, const face *f)
{
    for (uint32_t k = 0; k < 4; k++)
        mesh->positions[4 * index + k] =
            place(f->corners[k][0], f->corners[k][1], f->corners[k][2]);
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t *row = mesh->triangles[2 * index + half];
        row[0] = 4 * index, row[1] = 4 * index + 1 + half, row[2] = 4 * index + 2 + half;
        mesh->triangle_materials[2 * index + half] = (uint16_t)f->material;
    }
}

/* Face 0 is the top, face 1 + k the side between corners k and k + 1. */
static face block_face(const block *b, int index)
{
    face f = {.material = b->material};
    int k = index - 1;
    const int side[4] = {k + 1, k + 1, k, k};
    for (int i = 0; i < 4; i++) {
        const float *foot = b->footprint[index == 0 ? i : side[i] % 4];
        f.corners[i][0] = foot[0];
        f.corners[i][1] = index == 0 || i == 1 || i == 2 ? b->height : 0;
        f.corners[i][2] = foot[1];
    }
    return f;
}

bool rk_mesh_make_cornell(rk_mesh *mesh, uint32_t number, rk_error *error)
{
    (void)number;
    if (!rk_mesh_init(mesh, 4 * face_count, 2 * face_count, material_count, 0, error))
        return false;
    uint32_t index = 0;
    for (int i = 0; i < room_faces; i++)
        put_face(mesh, index++, &room[i]);
    for (int i = 0; i < 5 * block_count; i++) {
        face f = block_face(&blocks[i / 5], i % 5);
        put_face(mesh, index++, &f);
    }
    mesh->materials[white].kd = rk_vec(0.73f, 0.73f, 0.73f);
    mesh->materials[red].kd = rk_vec(0.65f, 0.06f, 0.05f);
    mesh->materials[green].kd = rk_vec(0.12f, 0.45f, 0.15f);
    mesh->materials[lamp].kd = rk_vec(1, 1, 1);
    mesh->materials[mirror].kd = rk_vec(0.01f, 0.01f, 0.01f);
    mesh->materials[mirror].ks = rk_vec(0.95f, 0.95f, 0.95f);
    mesh->materials[mirror].shininess = 1000;
    return true;
}

/* The published camera: at (278, 273, -800), along z, a 25 mm film behind a lens of 35 mm. */
void rk_scene_arrange_cornell(rk_scene *scene)
{
    scene->camera = (rk_camera){
        .look_at = place(278, 273, 279.6f),
        .distance = (float)((800 + centre[2]) * millimetres),
        .fov = 39.3076f, /* 2 atan(12.5 / 35) */
    };
    scene->lights[0] = rk_light_point(place(278, 540, 279.5f), rk_vec(1, 1, 1));
    scene->light_count = 1;
}
